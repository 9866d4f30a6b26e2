"""A trained actor as one ONNX file that runs anywhere, with everything needed to run it."""

from __future__ import annotations

import dataclasses
import json
import os
import subprocess
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import onnxruntime as ort
import torch
from numpy.typing import NDArray
from rsl_rl.models import MLPModel
from torch import nn

from mobius.control.action import ACTION_SCALE, FILTER_LENGTH, POLICY_DT
from mobius.control.bodies import body_of
from mobius.control.observation import Layout
from mobius.errors import InvalidInput
from mobius.model.servo import servo_of
from mobius.train.config import as_plain, gait_as_plain, preset_from
from mobius.train.env import LocomotionEnv, posture_of
from mobius.train.equivariant import Equivariant
from mobius.train.learn import load_checkpoint, read_config
from mobius.train.ppo import build_learner
from mobius.train.presets import Preset
from mobius.train.runlog import read_rows
from mobius.train.snapshot import Tree, load_networks
from mobius.train.vec import RslVecEnv

PARITY = 1e-5
"""Largest difference between torch and onnxruntime that is accepted."""
CURVE = ("steps", "wall_s", "error/linear", "error/yaw", "reward")


class ExportedActor(nn.Module):
    """Observation (n, size) to mean action (n, k), for ONNX."""

    def __init__(self, actor: MLPModel) -> None:
        super().__init__()
        self.actor = actor

    def forward(self, obs: torch.Tensor) -> torch.Tensor:
        """Deterministic action."""
        if isinstance(self.actor, Equivariant):
            return self.actor.mean_of(obs)
        return self.actor.mlp(self.actor.obs_normalizer(obs))


def git_hash() -> str:
    """Short hash of the checked-out commit, with ``-dirty``; ``unknown`` outside a checkout."""
    try:
        run = subprocess.run(
            ["git", "describe", "--always", "--dirty", "--abbrev=7", "--exclude=*"],
            capture_output=True,
            text=True,
            check=True,
            cwd=Path(__file__).parent,
        )
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
    return run.stdout.strip()


def describe_layout(layout: Layout) -> list[tuple[str, int]]:
    """Name and width of the parts of one frame, in order."""
    k = layout.actions
    if layout.kind == "paper":
        parts = [("roll, pitch, yaw since the start [rad]", 3), ("yaw rate [rad/s]", 1)]
        parts += [("velocity, heading frame [m/s]", 3), ("joint angles [rad]", k)]
    else:
        parts = [("unit gravity, trunk frame", 3), ("trunk rates, trunk frame [rad/s]", 3)]
        parts += [("velocity, heading frame [m/s]", 3), ("joint angles minus default [rad]", k)]
    parts += [("last raw action", k), ("commanded vx, vy [m/s], wz [rad/s]", 3)]
    if layout.clock:
        parts += [("sine and cosine of the gait clock", 2)]
    if sum(width for _, width in parts) != layout.frame_size:
        raise AssertionError(f"describe_layout does not describe {layout}")
    return parts


def build_metadata(preset: Preset, name: str, run: Path, checkpoint: Tree) -> dict[str, Any]:
    """What the ONNX file says about itself; JSON values."""
    body = body_of(preset.env.body)
    env, config = preset.env, read_config(run)
    _, default, _ = posture_of(env)
    servos = [servo_of(j) for j in body.joints]
    layout = Layout(env.frame, len(body.joints), env.history, env.clock)
    return {
        "body": env.body,
        "frame": env.frame,
        "history": env.history,
        "clock": env.clock,
        "joints": list(body.joints),
        "default": [round(float(v), 9) for v in default],
        "scale": ACTION_SCALE,
        "filter_length": FILTER_LENGTH,
        "period_s": POLICY_DT,
        "gait": config.get("gait", gait_as_plain(env)),
        "kp": [round(s.kp, 4) for s in servos],
        "damping": [round(s.damping, 4) for s in servos],
        "stall_torque": [round(s.stall_torque, 4) for s in servos],
        "observation": {"frame": describe_layout(layout), "frames": env.history, "first": "newest"},
        "preset": name,
        "config": as_plain(preset),
        "seed": config["seed"],
        "steps": checkpoint["steps"],
        "wall_s": round(checkpoint["elapsed"], 1),
        "warm_start": checkpoint["init"],
        "weights_sha256": checkpoint["policy"],
        "git": git_hash(),
        "curve_columns": list(CURVE),
        "curve": read_curve(run, checkpoint["steps"]),
    }


def read_curve(run: Path, steps: int, points: int = 40) -> list[list[float]]:
    """Rows of :data:`CURVE` along the training up to ``steps``, thinned."""
    rows = [row for row in read_rows(run) if row["steps"] <= steps]
    keep = np.unique(np.linspace(0, max(len(rows) - 1, 0), points).astype(int))
    return [[round(float(rows[i][k]), 4) for k in CURVE] for i in keep if rows]


def export(preset: Preset | None, name: str, run: Path, out: Path) -> float:
    """Write ``out`` from the checkpoint in ``run``; returns the torch/onnxruntime difference.

    Args:
        preset: What the run must have been trained with; None takes what it says itself.
        name: What to call the preset in the file.
        run: Run folder.
        out: ONNX file to write.

    Raises:
        InvalidInput: no checkpoint, one of another preset, or torch and onnxruntime differ by
            more than 1e-5 on observations recorded in the environment.
    """
    checkpoint = load_checkpoint(run)
    config = read_config(run)
    own = {f.name for f in dataclasses.fields(Preset)}
    preset = preset or preset_from({k: v for k, v in config.items() if k in own})
    other = [k for k, v in as_plain(preset).items() if k != "steps" and config.get(k) != v]
    if other:
        raise InvalidInput(f"{run} was trained with another {', '.join(other)} than '{name}' has")
    vec = RslVecEnv(LocomotionEnv(preset.env, 16, seed=1, nthread=1))
    learner = build_learner(preset, vec)
    load_networks(learner, checkpoint["learner"])
    learner.eval_mode()
    actor = ExportedActor(learner.get_policy()).eval()
    observations, expected = record(vec.env, actor)
    temporary = out.with_suffix(".tmp.onnx")
    out.parent.mkdir(parents=True, exist_ok=True)
    try:
        metadata = build_metadata(preset, name, run, checkpoint)
        write_onnx(actor, vec.env.layout.size, metadata, temporary)
        difference = parity(temporary, observations, expected)
        if not difference <= PARITY:
            raise InvalidInput(
                f"{out}: onnxruntime differs from torch by {difference:.2e}, allowed {PARITY:.0e}"
            )
        os.replace(temporary, out)
    finally:
        temporary.unlink(missing_ok=True)
    return difference


def record(
    env: LocomotionEnv, actor: nn.Module, steps: int = 120
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Observations (m, size) of all robots walking with the policy, and its actions (m, k)."""
    seen, done = [], []
    with torch.no_grad():
        for _ in range(steps):
            seen.append(env.observation.astype(np.float32))
            done.append(actor(torch.from_numpy(seen[-1])).numpy())
            env.step(done[-1].astype(float))
    return np.concatenate(seen), np.concatenate(done)


def parity(path: Path, observations: NDArray[np.float32], expected: NDArray[np.float32]) -> float:
    """Largest difference of the ONNX file's actions from ``expected``; NaN if one is NaN."""
    session = ort.InferenceSession(str(path), providers=["CPUExecutionProvider"])
    got = session.run(None, {"obs": observations})[0]
    return float(np.abs(got - expected).max())


def write_onnx(actor: nn.Module, size: int, metadata: dict[str, Any], path: Path) -> None:
    """Write a network (n, size) -> (n, k) as one ONNX file with ``metadata`` as JSON values."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        torch.onnx.export(
            actor,
            (torch.zeros(2, size),),
            str(path),
            input_names=["obs"],
            output_names=["action"],
            dynamic_axes={"obs": {0: "n"}, "action": {0: "n"}},
            opset_version=18,
            dynamo=False,
        )
    model = onnx.load(str(path))
    entry = model.metadata_props.add()
    entry.key, entry.value = "mobius", json.dumps(metadata, allow_nan=False)
    onnx.save(model, str(path))
