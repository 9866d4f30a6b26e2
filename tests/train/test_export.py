"""One ONNX file: equal to torch over recorded observations, and it says what it is."""

import json
import shutil
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

torch = pytest.importorskip("torch")
pytest.importorskip("onnx")

import onnx  # noqa: E402
import onnx.numpy_helper  # noqa: E402

from mobius.control.policy import PolicyController, load_policy  # noqa: E402
from mobius.errors import InvalidInput  # noqa: E402
from mobius.train import export as module  # noqa: E402
from mobius.train.config import preset_from  # noqa: E402
from mobius.train.export import CURVE, PARITY, export, parity, record  # noqa: E402
from mobius.train.learn import load_checkpoint, train  # noqa: E402
from mobius.train.presets import preset_of  # noqa: E402
from mobius.train.runlog import read_rows  # noqa: E402

BATCH = 8 * 24
TINY = {
    ("biped", "smoke"): replace(preset_of("biped", "smoke"), num_envs=8, steps=2 * BATCH),
    ("crawl", "paper"): replace(
        preset_of("crawl", "paper"), num_envs=8, horizon=24, minibatches=2, steps=2 * BATCH
    ),
}


@pytest.fixture(scope="module", params=TINY, ids="-".join)
def exported(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("export")
    preset, name = TINY[request.param], request.param[1]
    train(preset, folder / "run", seed=7, threads=1)
    difference = export(preset, name, folder / "run", folder / "out" / "policy.onnx")
    return preset, name, folder / "run", folder / "out" / "policy.onnx", difference


ONCE = pytest.mark.parametrize("exported", [("biped", "smoke")], ids="-".join, indirect=True)


@pytest.fixture
def quick(exported, monkeypatch):
    """With a short recording."""
    monkeypatch.setattr(module, "record", partial(record, steps=3))
    return exported


def test_it_equals_torch_and_runs_in_the_loop(exported):
    *_, path, difference = exported
    assert difference <= PARITY
    policy = load_policy(path)
    assert PolicyController(policy).observation.shape == (policy.layout.size,)
    assert [p.name for p in path.parent.iterdir()] == ["policy.onnx"]


def test_parity_is_over_observations_of_walking_robots(exported):
    preset, *_ = exported
    from mobius.train.env import LocomotionEnv

    env = LocomotionEnv(preset.env, 4, seed=1, nthread=1)
    asked = []

    def actor(obs):
        asked.append(obs.numpy().copy())
        return torch.zeros(4, env.layout.actions)

    observations, actions = record(env, actor, steps=6)
    np.testing.assert_array_equal(observations, np.concatenate(asked))
    assert observations.shape == (24, env.layout.size) and actions.shape == (24, env.layout.actions)
    assert np.ptp(observations, axis=0).max() > 0


@ONCE
def test_a_file_that_differs_from_torch_is_not_exported(quick, monkeypatch, tmp_path):
    preset, name, run, *_ = quick
    write = module.write_onnx

    def spoil(actor, size, metadata, path):
        write(actor, size, metadata, path)
        model = onnx.load(str(path))
        bias = next(x for x in model.graph.initializer if x.dims and len(x.dims) == 1)
        bias.CopyFrom(
            onnx.numpy_helper.from_array(onnx.numpy_helper.to_array(bias) + 0.01, bias.name)
        )
        onnx.save(model, str(path))

    monkeypatch.setattr(module, "write_onnx", spoil)
    with pytest.raises(InvalidInput, match="differs from torch"):
        export(preset, name, run, tmp_path / "p.onnx")
    assert list(tmp_path.iterdir()) == []


def test_nan_is_no_parity(exported):
    *_, path, _ = exported
    size = load_policy(path).layout.size
    seen = np.zeros((2, size), np.float32)
    assert not parity(path, seen, np.full((2, 1), np.nan, np.float32)) <= PARITY


def test_the_file_says_what_it_is(exported):
    preset, name, run, path, _ = exported
    meta = load_policy(path).metadata
    body = preset.env.body
    assert (meta["body"], meta["preset"], meta["seed"]) == (body, name, 7)
    assert preset_from(meta["config"]) == preset
    k = len(meta["joints"])
    for key in ("kp", "damping", "stall_torque"):
        assert len(meta[key]) == k and min(meta[key]) > 0
    layout = load_policy(path).layout
    assert sum(width for _, width in meta["observation"]["frame"]) == layout.frame_size
    assert meta["observation"]["frames"] == layout.history
    assert meta["curve_columns"] == list(CURVE)
    assert [row[0] for row in meta["curve"]] == [BATCH, 2 * BATCH]
    assert np.isfinite(meta["curve"]).all() and meta["wall_s"] > 0
    assert meta["weights_sha256"] == load_checkpoint(run)["policy"]
    assert meta["steps"] == 2 * BATCH and meta["warm_start"] is None and meta["git"]
    json.dumps(meta, allow_nan=False)


@ONCE
def test_the_gait_and_the_curve_are_those_of_the_training(quick, tmp_path):
    preset, name, run, *_ = quick
    shutil.copytree(run, tmp_path / "run")
    config = json.loads((run / "config.json").read_text())
    config["gait"]["period"] = 0.7  # as if bodies.py had changed since
    (tmp_path / "run" / "config.json").write_text(json.dumps(config))
    with (tmp_path / "run" / "progress.jsonl").open("a") as lines:  # later than the checkpoint
        lines.write(json.dumps(read_rows(run)[-1] | {"steps": 3 * BATCH}) + "\n")
    export(preset, name, tmp_path / "run", tmp_path / "p.onnx")
    policy = load_policy(tmp_path / "p.onnx")
    assert policy.gait.period == 0.7
    assert policy.metadata["curve"][-1][0] == 2 * BATCH


def test_a_fast_policy_stays_small(exported):
    _, name, _, path, _ = exported
    if name != "paper":
        assert path.stat().st_size < 300_000


@ONCE
def test_only_a_run_of_that_preset_is_exported(quick, tmp_path):
    preset, name, run, *_ = quick
    with pytest.raises(InvalidInput, match="another env"):
        export(replace(preset, env=replace(preset.env, min_height=0.1)), name, run, tmp_path / "p")
    assert export(None, name, run, tmp_path / "own" / "p.onnx") <= PARITY
    (tmp_path / "own" / "p.onnx").unlink()
    (tmp_path / "own").rmdir()
    with pytest.raises(InvalidInput, match=r"no checkpoint\.safetensors"):
        export(preset, name, tmp_path / "empty", tmp_path / "p.onnx")
    assert list(tmp_path.iterdir()) == []
