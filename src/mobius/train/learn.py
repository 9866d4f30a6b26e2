"""Train a policy: PPO of rsl_rl on the vectorised environment, resumable, logged.

A run folder holds ``config.json``, ``progress.jsonl`` (a line an iteration), TensorBoard
events, ``checkpoint.pt`` (the newest, replaced atomically) and at the end ``policy.onnx``.
"""

from __future__ import annotations

import json
import math
import os
import random
import time
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import torch
from rsl_rl.algorithms import PPO
from torch.utils.tensorboard import SummaryWriter

from mobius.errors import InvalidInput
from mobius.files import write_json_atomic, write_text_atomic
from mobius.train.env import LocomotionEnv
from mobius.train.equivariant import EquivariantActor
from mobius.train.presets import Preset
from mobius.train.vec import RslVecEnv

Progress = Callable[[dict[str, float]], None]
SAVE_EVERY = 25
"""Iterations between checkpoints."""


def build_learner(preset: Preset, vec: RslVecEnv) -> PPO:
    """rsl_rl's PPO for the preset; seeds nothing."""
    cfg = preset.runner(actor_class="MLPModel")
    if preset.symmetric:
        cfg["actor"]["class_name"] = EquivariantActor.configure(vec.env.layout, preset.env.body)
    cfg["multi_gpu"] = None
    return PPO.construct_algorithm(vec.get_observations(), vec, cfg, "cpu")


def anneal(preset: Preset, learner: PPO, steps: int) -> None:
    """Set entropy bonus and largest action noise for the step count (``preset.anneal``)."""
    if preset.anneal is None:
        return
    begin, end = preset.anneal
    left = 1.0 - min(max((steps - begin) / (end - begin), 0.0), 1.0)
    learner.entropy_coef = preset.entropy * left
    most = preset.final_std * (preset.init_std / preset.final_std) ** left
    with torch.no_grad():
        learner.get_policy().distribution.log_std_param.clamp_(max=math.log(most))


def seed_everything(seed: int) -> None:
    """rsl_rl seeds nothing itself."""
    random.seed(seed)
    np.random.seed(seed)  # noqa: NPY002  rsl_rl may use the global generator
    torch.manual_seed(seed)


def train(
    preset: Preset,
    out: Path,
    *,
    seed: int = 0,
    threads: int = 0,
    resume: bool = False,
    progress: Progress | None = None,
) -> Path:
    """Train until ``preset.steps`` environment steps; returns the checkpoint's path.

    Args:
        preset: Environment, learner and budget.
        out: Run folder; must not hold a run unless ``resume``.
        seed: Seeds environment, network and sampling.
        threads: CPU threads of physics and learner; 0 takes all.
        resume: Continue the run in ``out``.
        progress: Called after every iteration with its figures.

    Raises:
        InvalidInput: ``out`` holds a run already, or there is none to resume.
    """
    checkpoint = out / "checkpoint.pt"
    if checkpoint.exists() and not resume:
        raise InvalidInput(
            f"{out} holds a training run already. Type --resume to continue it, or choose"
            " another --out"
        )
    if resume and not checkpoint.exists():
        raise InvalidInput(f"{out} holds no checkpoint.pt to resume; leave --resume away")
    threads = threads or len(os.sched_getaffinity(0))
    torch.set_num_threads(threads)
    seed_everything(seed)
    vec = RslVecEnv(LocomotionEnv(preset.env, preset.num_envs, seed=seed, nthread=threads))
    learner = build_learner(preset, vec)
    out.mkdir(parents=True, exist_ok=True)
    done_steps, elapsed = 0, 0.0
    wanted = {"seed": seed, **asdict(preset)}
    if resume:
        _same_run(out / "config.json", wanted)
        done_steps, elapsed = _load(checkpoint, learner)
        seed_everything(seed + done_steps)  # not the stream of the first part again
        vec.env.reseed(seed + done_steps)
    else:
        vec.episode_length_buf = torch.from_numpy(
            vec.env.rng.integers(0, vec.env.max_steps, vec.num_envs)
        )
        write_json_atomic(out / "config.json", wanted)
    writer = SummaryWriter(str(out), purge_step=done_steps or None)
    batch = preset.horizon * preset.num_envs
    learner.train_mode()
    lines_path = out / "progress.jsonl"
    kept = [] if not resume else lines_path.read_text().splitlines(keepends=True)
    kept = [line for line in kept if json.loads(line)["steps"] <= done_steps]
    write_text_atomic(lines_path, "".join(kept))
    with lines_path.open("a") as lines:
        iteration = done_steps // batch
        while done_steps < preset.steps:
            start = time.perf_counter()
            anneal(preset, learner, done_steps)
            figures = _iterate(vec, learner, preset.horizon)
            done_steps += batch
            iteration += 1
            elapsed += time.perf_counter() - start
            figures.update(
                iteration=iteration,
                steps=done_steps,
                wall_s=elapsed,
                steps_per_s=batch / (time.perf_counter() - start),
                learning_rate=learner.learning_rate,
            )
            lines.write(json.dumps({k: round(v, 6) for k, v in figures.items()}) + "\n")
            lines.flush()
            for key, value in figures.items():
                writer.add_scalar(key, value, done_steps)
            if progress is not None:
                progress(figures)
            if iteration % SAVE_EVERY == 0 or done_steps >= preset.steps:
                _save(checkpoint, learner, done_steps, elapsed)
    writer.close()
    return checkpoint


def _same_run(config: Path, wanted: dict[str, Any]) -> None:
    """Refuse to resume a run that was begun otherwise; only the budget may change."""
    begun = json.loads(config.read_text())
    wanted = json.loads(json.dumps(wanted))
    other = sorted(k for k in wanted if k != "steps" and begun.get(k) != wanted[k])
    if other:
        raise InvalidInput(
            f"{config.parent} was begun with another {', '.join(other)}; resume with the same"
            " body, preset and seed, or choose another --out"
        )


def _iterate(vec: RslVecEnv, learner: PPO, horizon: int) -> dict[str, float]:
    """One rollout and one update; means of the rollout's log."""
    logs: list[dict[str, float]] = []
    reward = 0.0
    with torch.inference_mode():
        obs = vec.get_observations()
        for _ in range(horizon):
            obs, rewards, dones, extras = vec.step(learner.act(obs))
            if not bool(torch.isfinite(rewards).all() and torch.isfinite(obs["policy"]).all()):
                raise FloatingPointError("the simulation produced a number that is not finite")
            learner.process_env_step(obs, rewards, dones, extras)
            logs.append(extras["log"])
            reward += float(rewards.mean()) / horizon
        learner.compute_returns(obs)
    losses = learner.update()
    figures = {k.strip("/"): float(np.mean([log[k] for log in logs])) for k in logs[0]}
    figures["reward"] = reward
    figures["action_std"] = float(learner.get_policy().output_std.detach().mean())
    figures.update({f"loss/{k}": float(v) for k, v in losses.items()})
    return figures


def _save(path: Path, learner: PPO, steps: int, elapsed: float) -> None:
    """Replace the checkpoint atomically."""
    state: dict[str, Any] = learner.save()
    state.update(steps=steps, elapsed=elapsed, learning_rate=learner.learning_rate)
    temporary = path.with_suffix(".tmp")
    torch.save(state, temporary)
    os.replace(temporary, path)


def _load(path: Path, learner: PPO) -> tuple[int, float]:
    state = torch.load(path, weights_only=True)
    learner.load(state, None, True)
    learner.learning_rate = state["learning_rate"]
    for group in learner.optimizer.param_groups:
        group["lr"] = state["learning_rate"]
    return int(state["steps"]), float(state["elapsed"])
