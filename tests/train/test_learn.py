"""Training end to end in seconds: exact, resumable after any kill, refuses to overwrite."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import replace

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from mobius.errors import InvalidInput  # noqa: E402
from mobius.train.config import as_plain  # noqa: E402
from mobius.train.learn import CHECKPOINT, load_checkpoint, train  # noqa: E402
from mobius.train.presets import preset_of  # noqa: E402
from mobius.train.runlog import read_rows  # noqa: E402

BATCH = 16 * 24
TINY = replace(preset_of("crawl", "smoke"), num_envs=16, steps=4 * BATCH)
VARYING = {"wall_s", "steps_per_s"}


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Four iterations without a stop, physics on one thread."""
    out = tmp_path_factory.mktemp("train") / "run"
    train(TINY, out, seed=7, threads=1)
    return out


def learned(out) -> list[dict[str, float]]:
    """Progress without what the clock on the wall decides."""
    return [{k: v for k, v in row.items() if k not in VARYING} for row in read_rows(out)]


def same_end(a, b) -> bool:
    """Weights, moments, random streams, curriculum and robots agree bit for bit."""
    left, right = load_checkpoint(a), load_checkpoint(b)

    def equal(x, y) -> bool:
        if isinstance(x, dict):
            return x.keys() == y.keys() and all(equal(x[k], y[k]) for k in x)
        if isinstance(x, np.ndarray):
            return x.tobytes() == y.tobytes()
        return x == y

    del left["elapsed"], right["elapsed"]
    return equal(left, right)


def test_a_run_leaves_checkpoint_and_progress(run):
    assert (run / CHECKPOINT).is_file() and (run / "config.json").is_file()
    rows = read_rows(run)
    assert [r["steps"] for r in rows] == [BATCH * i for i in (1, 2, 3, 4)]
    for key in ("reward", "error/linear", "error/yaw", "power_W", "steps_per_s", "wall_s"):
        assert np.isfinite(rows[-1][key])


def test_two_n_steps_are_n_steps_and_n_resumed(run, tmp_path):
    """And two threads of physics and learner end where one of each ended."""
    half = replace(TINY, steps=2 * BATCH)
    train(half, tmp_path / "run", seed=7, threads=2)
    assert load_checkpoint(tmp_path / "run")["policy"] != load_checkpoint(run)["policy"]
    train(TINY, tmp_path / "run", seed=7, threads=2, resume=True)
    assert load_checkpoint(tmp_path / "run")["policy"] == load_checkpoint(run)["policy"]
    assert same_end(run, tmp_path / "run")
    assert learned(run) == learned(tmp_path / "run")


def test_another_seed_is_another_run(run, tmp_path):
    train(replace(TINY, steps=BATCH), tmp_path / "run", seed=8, threads=1)
    assert learned(tmp_path / "run")[0]["reward"] != learned(run)[0]["reward"]


KILLED = """
import json, sys
from pathlib import Path
from mobius.train.config import preset_from
from mobius.train.learn import train
train(preset_from(json.loads(sys.argv[1])), Path(sys.argv[2]), seed=7, threads=1, save_every=2)
"""


def test_kill_9_loses_at_most_one_save_interval(run, tmp_path):
    endless = replace(TINY, steps=1000 * BATCH)
    out = tmp_path / "run"
    args = [sys.executable, "-c", KILLED, json.dumps(as_plain(endless)), str(out)]
    child = subprocess.Popen(args, stdout=subprocess.DEVNULL)
    try:
        deadline = time.monotonic() + 120
        while len(read_rows(out)) < 3 and child.poll() is None and time.monotonic() < deadline:
            time.sleep(0.01)
    finally:
        os.kill(child.pid, signal.SIGKILL)
    assert child.wait() == -signal.SIGKILL
    reached = read_rows(out)[-1]["steps"]
    kept = load_checkpoint(out)["steps"]
    assert kept >= 2 * BATCH and reached - kept <= 2 * BATCH
    (out / f".{CHECKPOINT}.x.tmp").touch()  # as a kill during a save leaves one
    goal = max(4, kept // BATCH)
    train(replace(TINY, steps=goal * BATCH), out, seed=7, threads=1, resume=True)
    assert learned(out)[:4] == learned(run)
    assert list(out.glob(".*")) == []
    if goal == 4:
        assert same_end(run, out)


def test_resume_refuses_another_run(run):
    with pytest.raises(InvalidInput, match="another seed"):
        train(TINY, run, seed=8, resume=True)
    with pytest.raises(InvalidInput, match="another learning_rate"):
        train(replace(TINY, learning_rate=1e-5), run, seed=7, resume=True)


def test_nothing_is_overwritten_or_resumed_by_mistake(run, tmp_path):
    with pytest.raises(InvalidInput, match="--resume"):
        train(TINY, run)
    with pytest.raises(InvalidInput, match=r"no checkpoint\.safetensors"):
        train(TINY, tmp_path / "empty", resume=True)


def test_a_cut_off_checkpoint_is_refused(run, tmp_path):
    shutil.copy(run / "config.json", tmp_path)
    (tmp_path / CHECKPOINT).write_bytes((run / CHECKPOINT).read_bytes()[:-100])
    with pytest.raises(InvalidInput, match="not a whole safetensors file"):
        train(TINY, tmp_path, seed=7, resume=True)


def test_a_warm_start_takes_networks_and_normalisers_only(run, tmp_path):
    rough = replace(preset_of("crawl", "fast-rough"), num_envs=16, steps=0)
    train(rough, tmp_path / "rough", seed=1, threads=1, init=run)
    old, new = load_checkpoint(run), load_checkpoint(tmp_path / "rough")
    assert new["policy"] == old["policy"] == new["init"]["policy"]
    assert new["steps"] == 0 and new["init"]["steps"] == 4 * BATCH
    assert new["learner"]["optimiser"] == {} and old["learner"]["optimiser"] != {}
    assert new["learner"]["learning_rate"] == rough.learning_rate
    count = new["learner"]["actor"]["obs_normalizer.count"]
    assert count == 4 * BATCH


def test_a_warm_start_from_another_body_is_refused(run, tmp_path):
    biped = replace(preset_of("biped", "smoke"), num_envs=4, steps=96)
    with pytest.raises(InvalidInput, match="actor does not fit"):
        train(biped, tmp_path / "biped", init=run)
    with pytest.raises(InvalidInput, match=r"no checkpoint\.safetensors"):
        train(TINY, tmp_path / "none", init=tmp_path)
    assert list(tmp_path.iterdir()) == []
