"""progress.jsonl and TensorBoard: every step once, whatever was killed or resumed."""

import json

import pytest

for package in ("torch", "tensorboard"):
    pytest.importorskip(package)

from tensorboard.backend.event_processing.event_accumulator import (  # noqa: E402
    EventAccumulator,
)

from mobius.errors import InvalidInput  # noqa: E402
from mobius.train.runlog import LINES, RunLog, read_rows  # noqa: E402


def row(i: int, reward: float = 0.0) -> dict[str, float]:
    return {"steps": 100 * i, "wall_s": 2.0 * i, "reward": reward, "learning_rate": 1e-5 / 3}


def board(folder) -> list[tuple[int, float]]:
    events = EventAccumulator(str(folder))
    events.Reload()
    return [(e.step, e.value) for e in events.Scalars("reward")]


def test_rows_are_kept_to_seven_digits_and_whole_numbers_exactly(tmp_path):
    with RunLog(tmp_path) as log:
        log.add({"steps": 123_456_789_012, "wall_s": 1.0, "learning_rate": 1e-5 / 3})
    (kept,) = read_rows(tmp_path)
    assert kept["steps"] == 123_456_789_012
    assert kept["learning_rate"] == pytest.approx(1e-5 / 3, rel=1e-6)


def test_resuming_drops_what_came_after_the_checkpoint(tmp_path):
    with RunLog(tmp_path, batch=100) as log:
        for i in (1, 2, 3):
            log.add(row(i, reward=-1.0))
        log.sync()
    with (tmp_path / LINES).open("a") as file:
        file.write('{"steps": 400, "wall')  # killed while writing
    for _ in range(2):  # stopped twice at the same place
        with RunLog(tmp_path, steps=200, batch=100) as log:
            log.add(row(3, reward=5.0))
    assert [r["steps"] for r in read_rows(tmp_path)] == [100, 200, 300]
    assert board(tmp_path) == [(100, -1.0), (200, -1.0), (300, 5.0)]
    assert len(list(tmp_path.glob("events.out.tfevents.*"))) == 1


@pytest.mark.parametrize("kept", [[], [1], [2], [1, 1, 2]])
def test_a_missing_or_doubled_step_is_not_passed_over(tmp_path, kept):
    text = "".join(json.dumps(row(i)) + "\n" for i in kept)
    (tmp_path / LINES).write_text(text)
    with pytest.raises(InvalidInput, match="every 100 steps up to 200"):
        RunLog(tmp_path, steps=200, batch=100)
    assert (tmp_path / LINES).read_text() == text


def test_a_new_run_begins_empty(tmp_path):
    (tmp_path / LINES).write_text(json.dumps(row(1)) + "\n")  # killed before its first checkpoint
    with RunLog(tmp_path, batch=100) as log:
        log.add(row(1, reward=2.0))
    assert [r["reward"] for r in read_rows(tmp_path)] == [2.0]
