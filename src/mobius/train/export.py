"""A trained actor as one ONNX file that runs anywhere, with everything needed to run it."""

from __future__ import annotations

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

from mobius.control.action import ACTION_SCALE, FILTER_LENGTH
from mobius.errors import InvalidInput
from mobius.model import robot
from mobius.model.servo import servo_of
from mobius.train.env import LocomotionEnv
from mobius.train.learn import build_learner
from mobius.train.presets import Preset
from mobius.train.symmetric import ExportedActor
from mobius.train.vec import RslVecEnv

PARITY = 1e-5
"""Largest difference between torch and onnxruntime that is accepted."""


def git_hash() -> str:
    """Short hash of the checked-out commit, ``unknown`` outside a checkout."""
    try:
        run = subprocess.run(
            ["git", "rev-parse", "--short", "HEAD"],
            capture_output=True,
            text=True,
            check=True,
            cwd=Path(__file__).parent,
        )
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
    return run.stdout.strip()


def build_metadata(
    preset: Preset, name: str, curve: list[list[float]], seed: int
) -> dict[str, Any]:
    """What the ONNX file says about itself."""
    from mobius.control.bodies import body_of

    body = body_of(preset.env.body)
    _, ctrl = robot.keyframe_joints(body.keyframe)
    return {
        "body": preset.env.body,
        "frame": preset.env.frame,
        "history": preset.env.history,
        "clock": preset.env.clock,
        "joints": list(body.joints),
        "default": [round(float(v), 9) for v in ctrl],
        "scale": ACTION_SCALE,
        "filter_length": FILTER_LENGTH,
        "kp": [round(servo_of(j).kp, 4) for j in body.joints],
        "preset": name,
        "seed": seed,
        "git": git_hash(),
        "curve": curve,
    }


def read_curve(run: Path, points: int = 40) -> list[list[float]]:
    """[steps, wall seconds, linear error, yaw error] along the training, thinned."""
    lines = (run / "progress.jsonl").read_text().splitlines()
    rows = [json.loads(line) for line in lines]
    keep = np.unique(np.linspace(0, len(rows) - 1, points).astype(int))
    keys = ("steps", "wall_s", "error/linear", "error/yaw")
    return [[round(float(rows[i][k]), 4) for k in keys] for i in keep]


def export(preset: Preset, name: str, run: Path, out: Path) -> float:
    """Write ``out`` from the checkpoint in ``run``; returns the torch/onnxruntime difference.

    Raises:
        InvalidInput: no checkpoint, or the two disagree by more than 1e-5.
    """
    checkpoint = run / "checkpoint.pt"
    if not checkpoint.is_file():
        raise InvalidInput(f"{run} holds no checkpoint.pt; type 'mobius train' first")
    vec = RslVecEnv(LocomotionEnv(preset.env, 16, seed=1, nthread=1))
    learner = build_learner(preset, vec)
    state = torch.load(checkpoint, weights_only=True)
    learner.load(state, None, True)
    learner.eval_mode()
    actor = ExportedActor(learner.get_policy()).eval()
    samples = [vec.env.observation.astype(np.float32)]
    with torch.no_grad():
        for _ in range(60):
            action = actor(torch.from_numpy(samples[-1]))
            samples.append(vec.env.step(action.numpy()).observation.astype(np.float32))
        batch = np.concatenate(samples)
        expected = actor(torch.from_numpy(batch)).numpy()
    seed = json.loads((run / "config.json").read_text())["seed"]
    metadata = build_metadata(preset, name, read_curve(run), seed)
    temporary = out.with_suffix(".tmp.onnx")
    out.parent.mkdir(parents=True, exist_ok=True)
    try:
        _write_onnx(actor, vec.env.layout.size, metadata, temporary)
        session = ort.InferenceSession(str(temporary), providers=["CPUExecutionProvider"])
        got = session.run(None, {"obs": batch})[0]
        difference = float(np.abs(got - expected).max())
        if not difference <= PARITY:
            raise InvalidInput(
                f"{out}: onnxruntime differs from torch by {difference:.2e}, allowed {PARITY:.0e}"
            )
        os.replace(temporary, out)
    finally:
        temporary.unlink(missing_ok=True)
    return difference


def _write_onnx(actor: torch.nn.Module, size: int, metadata: dict[str, Any], path: Path) -> None:
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
    entry.key, entry.value = "mobius", json.dumps(metadata)
    onnx.save(model, str(path))
