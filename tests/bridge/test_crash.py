"""Whatever happens to a log while or after it is written, it reads as far as it can be."""

import errno
import io
import os
import signal
import subprocess
import sys

import numpy as np
import pytest

from mobius.bridge.about import About
from mobius.bridge.log_file import FLUSH_EVERY, LogFile
from mobius.bridge.read_log import read_log
from mobius.bridge.read_run import Run, open_run
from mobius.bridge.record import McapRecorder
from mobius.errors import InvalidInput, MobiusError

DRIVER = """
import sys
import numpy as np
from mobius.assemble import Start, build_sim_stack, flat_model
from mobius.bridge.record import McapRecorder
from mobius.types import Mode, ModeCommand

stack, robot = build_sim_stack(flat_model(), Start(seed=1))
recorder = McapRecorder(path=sys.argv[1])
while True:
    sample = stack.turn(lambda b: ModeCommand(Mode.CRAWL, np.array([0.3, 0.0, 0.0]), b.stamp))
    if sample is not None:
        recorder.see(sample, robot.truth())
        print(sample.tick, flush=True)
"""


@pytest.fixture
def growing(drive, tmp_path):
    """(bytes of a log, [(size on the disk, time of the last sample)] as it was written)."""
    path, sizes = tmp_path / "live.mcap", []
    with McapRecorder(path=path, about=drive.about) as recorder:
        for sample, truth in zip(drive.samples, drive.truths, strict=True):
            recorder.see(sample, truth)
            sizes.append((path.stat().st_size, sample.tick / 600))
    return path.read_bytes(), sizes


def reads(data, path):
    """The run in some bytes, or None where there is a clear no; anything else fails the test."""
    path.write_bytes(data)
    try:
        return open_run(path)
    except InvalidInput as error:
        assert str(path) in str(error)
        return None


def test_a_drive_killed_without_warning_reads_up_to_the_last_second(tmp_path):
    """kill -9 while the stack turns and records at full speed."""
    log = tmp_path / "run.mcap"
    driver = subprocess.Popen(
        [sys.executable, "-c", DRIVER, str(log)], stdout=subprocess.PIPE, text=True
    )
    tick = 0
    while tick < 1100:
        tick = int(driver.stdout.readline())
    driver.kill()
    assert driver.wait() == -signal.SIGKILL
    run = open_run(log)
    assert not run.complete
    assert run.t[-1] >= tick / 600 - 1.0
    assert "cut off, or still being written; it reads up to" in run.notes[0]
    np.testing.assert_allclose(np.diff(run.t), 1 / 60, atol=1e-9)


def test_at_every_moment_the_disk_holds_all_but_the_last_half_second(growing, tmp_path):
    data, sizes = growing
    for size, t in sizes[:: len(sizes) // 20]:
        run = reads(data[:size], tmp_path / "cut.mcap")
        last = 0.0 if run is None else run.t[-1]
        assert last >= t - FLUSH_EVERY - 1 / 60


def test_cut_at_any_byte_it_reads_up_to_within_a_second_or_says_no(growing, tmp_path):
    data, sizes = growing
    rng = np.random.default_rng(0)
    for size in [1, 7, 8, 9, len(data) - 1, *rng.integers(1, len(data), 60)]:
        run = reads(data[:size], tmp_path / "cut.mcap")
        written = max((t for s, t in sizes if s <= size), default=0.0)
        assert (0.0 if run is None else run.t[-1]) >= written - 1.0
        if run is not None:
            assert not run.complete
            assert run.notes


def test_a_byte_turned_over_anywhere_is_never_a_crash(growing, tmp_path):
    data, rng = growing[0], np.random.default_rng(1)
    for at in [8, 9, 20, *rng.integers(8, len(data), 60)]:
        broken = bytearray(data)
        broken[at] ^= int(rng.integers(1, 256))
        run = reads(bytes(broken), tmp_path / "broken.mcap")
        assert run is None or isinstance(run, Run)


def test_numbers_in_a_damaged_chunk_are_not_believed(growing, tmp_path):
    """The checksum of the chunk says so; what stands before it is read."""
    data = bytearray(growing[0])
    data[len(data) // 2] ^= 0xFF
    run = reads(bytes(data), tmp_path / "broken.mcap")
    assert not run.complete
    assert "damaged before byte" in run.notes[0]
    assert 0.3 < run.t[-1] < 1.7


@pytest.mark.parametrize(
    ("data", "complaint"),
    [
        (b"", "is empty; nothing was recorded"),
        (b"hello, I am a text file", "is no log: expected a MCAP file"),
        (b"\x89MCAP0\r\n", "still being written: no joint angles can be read"),
        (b"\x89MCAP0\r\n" + bytes(range(256)) * 40, "no joint angles can be read"),
    ],
)
def test_what_is_no_log_is_refused_in_words(data, complaint, tmp_path):
    (tmp_path / "run.mcap").write_bytes(data)
    with pytest.raises(InvalidInput, match=complaint):
        open_run(tmp_path / "run.mcap")


def test_a_log_without_its_index_misses_no_message(growing, tmp_path):
    data, sizes = growing
    run = reads(data[:-40], tmp_path / "cut.mcap")
    assert run.t[-1] == pytest.approx(sizes[-1][1])
    assert "its index is cut off; every message is there" in run.notes[0]


def test_written_live_and_saved_at_the_end_are_the_same_messages(growing, drive, tmp_path):
    recorder = McapRecorder(about=drive.about)
    for sample, truth in zip(drive.samples, drive.truths, strict=True):
        recorder.see(sample, truth)
    recorder.save(tmp_path / "saved.mcap")
    (tmp_path / "live_again.mcap").write_bytes(growing[0])
    saved, live = (read_log(tmp_path / name) for name in ("saved.mcap", "live_again.mcap"))
    assert saved.messages == live.messages
    assert len(recorder) == sum(saved.counts.values())
    assert (saved.problem, live.problem) == ("", "")


def test_half_a_second_of_wall_time_ends_a_chunk_of_a_slow_run(monkeypatch):
    """A paused or slow simulation must not hold back what it has said."""
    clock = iter(np.arange(0.0, 100.0, 0.3))
    monkeypatch.setattr("mobius.bridge.log_file.time.monotonic", lambda: next(clock))
    stream = io.BytesIO()
    log, sizes = LogFile(stream), []
    for k in range(6):
        log.write("/clock", k * 1_000_000, b"\x00\x01\x00\x00" + bytes(8))
        sizes.append(stream.tell())
    assert len(set(sizes)) >= 3


def test_a_reset_does_not_turn_back_the_log(drive, nouns, tmp_path):
    times = []
    with McapRecorder(path=tmp_path / "run.mcap") as recorder:
        for _ in range(2):
            for sample in drive.samples[:30]:
                recorder.see(sample)
            times.append(recorder.time)
        recorder.once(plan=nouns["plan"])
    run = open_run(tmp_path / "run.mcap")
    np.testing.assert_allclose(np.diff(run.t), 1 / 60, atol=1e-9)
    np.testing.assert_array_equal(run.q[:30], run.q[30:])
    assert times == pytest.approx([29 / 60, 59 / 60])
    assert [t for t, _ in run.plans] == pytest.approx([59 / 60])


def test_a_log_never_takes_the_place_of_another(drive, tmp_path):
    (tmp_path / "run.mcap").write_bytes(b"dear")
    with pytest.raises(InvalidInput, match="exists; choose another name"):
        McapRecorder(path=tmp_path / "run.mcap")
    with pytest.raises(InvalidInput, match=r"expected a file name ending in \.mcap"):
        McapRecorder(path=tmp_path / "run.log")
    assert (tmp_path / "run.mcap").read_bytes() == b"dear"
    assert os.listdir(tmp_path) == ["run.mcap"]


def test_a_full_disk_is_said_in_a_line_and_what_was_written_reads(drive, tmp_path, monkeypatch):
    path = tmp_path / "run.mcap"
    recorder = McapRecorder(path=path)
    for sample in drive.samples[:60]:
        recorder.see(sample)

    def full(self):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("mobius.bridge.log_file.Writer.flush", full)
    with pytest.raises(MobiusError, match=r"can no longer be written .No space left on device"):
        for sample in drive.samples[60:]:
            recorder.see(sample)
    monkeypatch.undo()
    assert open_run(path).t[-1] > 0.3


def test_a_closed_recorder_takes_nothing_more(drive, tmp_path):
    recorder = McapRecorder(path=tmp_path / "run.mcap")
    recorder.see(drive.samples[0])
    recorder.close()
    recorder.close()
    with pytest.raises(MobiusError, match="the log is closed"):
        recorder.see(drive.samples[1])
    with pytest.raises(InvalidInput, match=r"writes .*run\.mcap"):
        recorder.save(tmp_path / "other.mcap")


def test_a_later_format_of_the_head_is_refused_by_name():
    with pytest.raises(InvalidInput, match="format 2, expected 1"):
        About.from_record({"format": "2"})
    with pytest.raises(InvalidInput, match="cannot be understood"):
        About.from_record({"variation": "{"})
    with pytest.raises(InvalidInput, match="cannot be understood"):
        About.from_record({}, b"no gzip")
