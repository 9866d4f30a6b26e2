"""Training end to end in seconds: runs, resumes, exports, refuses to overwrite."""

import json
from dataclasses import replace

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from mobius.control.policy import PolicyController, load_policy  # noqa: E402
from mobius.errors import InvalidInput  # noqa: E402
from mobius.train.export import PARITY, export  # noqa: E402
from mobius.train.learn import build_learner, seed_everything, train  # noqa: E402
from mobius.train.presets import preset_of  # noqa: E402
from mobius.train.vec import RslVecEnv  # noqa: E402

BATCH = 16 * 24
TINY = replace(preset_of("crawl", "smoke"), num_envs=16, steps=2 * BATCH)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    out = tmp_path_factory.mktemp("train") / "run"
    train(TINY, out, seed=7, threads=1)
    return out


def rows(out) -> list[dict]:
    return [json.loads(line) for line in (out / "progress.jsonl").read_text().splitlines()]


def test_a_run_leaves_checkpoint_and_progress(run):
    assert (run / "checkpoint.pt").is_file() and (run / "config.json").is_file()
    assert [r["steps"] for r in rows(run)] == [BATCH, 2 * BATCH]
    for key in ("reward", "error/linear", "error/yaw", "power_W", "steps_per_s", "wall_s"):
        assert np.isfinite(rows(run)[-1][key])


def test_same_seed_same_training(run, tmp_path):
    train(TINY, tmp_path / "again", seed=7, threads=1)
    for a, b in zip(rows(run), rows(tmp_path / "again"), strict=True):
        assert a["reward"] == b["reward"] and a["loss/value"] == b["loss/value"]


def test_resume_continues_counting(run, tmp_path):
    out = tmp_path / "resumed"
    train(replace(TINY, steps=BATCH), out, seed=7, threads=1)
    train(TINY, out, seed=7, threads=1, resume=True)
    assert [r["steps"] for r in rows(out)] == [BATCH, 2 * BATCH]
    assert rows(out)[1]["iteration"] == 2


def test_resume_refuses_another_run(run, tmp_path):
    with pytest.raises(InvalidInput, match="another seed"):
        train(TINY, run, seed=8, resume=True)
    with pytest.raises(InvalidInput, match="another learning_rate"):
        train(replace(TINY, learning_rate=1e-5), run, seed=7, resume=True)


def test_resume_drops_lines_beyond_the_checkpoint(tmp_path):
    out = tmp_path / "stopped"
    train(replace(TINY, steps=BATCH), out, seed=7, threads=1)
    with (out / "progress.jsonl").open("a") as lines:  # an iteration whose save never came
        lines.write(json.dumps({"steps": 2 * BATCH, "reward": 99.0}) + "\n")
    train(TINY, out, seed=7, threads=1, resume=True)
    assert [r["steps"] for r in rows(out)] == [BATCH, 2 * BATCH]
    assert rows(out)[1]["reward"] != 99.0


def test_nothing_is_overwritten_or_resumed_by_mistake(run, tmp_path):
    with pytest.raises(InvalidInput, match="--resume"):
        train(TINY, run)
    with pytest.raises(InvalidInput, match=r"no checkpoint\.pt"):
        train(TINY, tmp_path / "empty", resume=True)
    with pytest.raises(InvalidInput, match=r"no checkpoint\.pt"):
        export(TINY, "smoke", tmp_path / "empty", tmp_path / "p.onnx")
    assert not (tmp_path / "p.onnx").exists()


def test_export_equals_torch_and_runs_in_the_loop(run, tmp_path):
    path = tmp_path / "policy.onnx"
    assert export(TINY, "smoke", run, path) <= PARITY
    policy = load_policy(path)
    assert policy.metadata["seed"] == 7 and policy.metadata["preset"] == "smoke"
    assert policy.metadata["curve"][-1][0] == 2 * BATCH
    assert PolicyController(policy).observation.shape == (policy.layout.size,)
    assert [p.name for p in tmp_path.iterdir()] == ["policy.onnx"]


def test_actor_is_exactly_equivariant():
    from mobius.control.observation import mirror_frame, mirror_joints
    from mobius.train.env import LocomotionEnv

    seed_everything(0)
    vec = RslVecEnv(LocomotionEnv(TINY.env, 4, nthread=1))
    actor = build_learner(TINY, vec).get_policy()
    obs = torch.randn(8, vec.env.layout.size)
    perm, signs = mirror_frame(vec.env.layout, vec.env.body)
    index, sign = mirror_joints(vec.env.body)
    with torch.no_grad():
        straight = actor.mean_of(obs)
        mirrored = actor.mean_of(obs[:, perm] * torch.tensor(signs, dtype=torch.float32))
    want = straight[:, index] * torch.tensor(sign, dtype=torch.float32)
    torch.testing.assert_close(mirrored, want, atol=1e-6, rtol=1e-5)
