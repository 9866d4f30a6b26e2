"""Train a policy: PPO of rsl_rl on the vectorised environment, exactly resumable, logged.

A run folder holds ``config.json``, ``progress.jsonl`` (a line an iteration), TensorBoard
events, ``checkpoint.safetensors`` (the newest, replaced atomically), ``nan/`` if a number
stopped being finite, and at the end ``policy.onnx``.
"""

from __future__ import annotations

import json
import math
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import torch
from rsl_rl.algorithms import PPO

from mobius.errors import InvalidInput
from mobius.files import write_json_atomic
from mobius.train.checkpoint import read_tree, write_tree
from mobius.train.config import as_plain, gait_as_plain
from mobius.train.guard import Guard
from mobius.train.parts import PARTS
from mobius.train.ppo import build_learner
from mobius.train.presets import Preset
from mobius.train.runlog import RunLog
from mobius.train.snapshot import (
    Tree,
    learner_state,
    load_learner,
    load_networks,
    load_random_state,
    policy_hash,
    random_state,
    seed_everything,
)
from mobius.train.vec import RslVecEnv
from mobius.train.watch import NotFinite, WatchedEnv

Progress = Callable[[dict[str, float]], None]
CHECKPOINT = "checkpoint.safetensors"
SAVE_EVERY = 25
"""Iterations between checkpoints."""


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


def train(
    preset: Preset,
    out: Path,
    *,
    seed: int = 0,
    threads: int = 0,
    resume: bool = False,
    init: Path | None = None,
    learner_threads: int = 0,
    save_every: int = SAVE_EVERY,
    progress: Progress | None = None,
) -> Path:
    """Train until ``preset.steps`` environment steps; returns the checkpoint's path.

    The weights depend on preset, seed and ``init``, bit for bit on one machine; not on how many
    threads there are, and not on how often the run was stopped and resumed.

    Args:
        preset: Environment, learner and budget.
        out: Run folder; must not hold a run unless ``resume``.
        seed: Seeds environment, network and sampling.
        threads: CPU threads of the physics; 0 takes all.
        resume: Continue the run in ``out`` exactly where its checkpoint was.
        init: Run folder to take actor, critic and normalisers from, not optimiser or counters.
        learner_threads: CPU threads of the learner, at most :data:`PARTS`; 0 takes as many as
            the physics has.
        save_every: Iterations between checkpoints.
        progress: Called after every iteration with its figures.

    Raises:
        InvalidInput: ``out`` holds a run already, or there is none to resume.
        TrainingStopped: a number is not finite; a dump was left in ``out/nan``.
    """
    _demand_room(out, resume)
    wanted = {"seed": seed, "gait": gait_as_plain(preset.env), **as_plain(preset)}
    before = _read_run(out, wanted) if resume else None
    seed_everything(seed)
    threads = threads or len(os.sched_getaffinity(0))
    vec = RslVecEnv(WatchedEnv(preset.env, preset.num_envs, seed=seed, nthread=threads))
    learner = build_learner(preset, vec, min(learner_threads or threads, PARTS))
    run = _Run(preset, vec, learner, out)
    if before is not None:
        run.load(before)
    else:
        run.begin(init)
    out.mkdir(parents=True, exist_ok=True)
    for half in out.glob(f".{CHECKPOINT}.*.tmp"):  # killed while saving
        half.unlink()
    write_json_atomic(out / "config.json", wanted)
    with RunLog(out, steps=run.steps, batch=run.batch) as log:
        if not resume:
            run.save()
        while run.steps < preset.steps:
            figures = run.iterate()
            log.add(figures)
            if progress is not None:
                progress(figures)
            if (run.steps // run.batch) % save_every == 0 or run.steps >= preset.steps:
                log.sync()
                run.save()
    return out / CHECKPOINT


class _Run:
    """Where a run is, how it goes on, and how to store that."""

    def __init__(self, preset: Preset, vec: RslVecEnv, learner: PPO, out: Path) -> None:
        self.preset, self.vec, self.learner, self.out = preset, vec, learner, out
        self.guard = Guard(preset, vec, learner, out / "nan")
        self.batch = preset.horizon * preset.num_envs
        self.steps, self.elapsed = 0, 0.0
        self.init: Tree | None = None
        learner.train_mode()

    def iterate(self) -> dict[str, float]:
        """One iteration; its figures."""
        start = time.perf_counter()
        anneal(self.preset, self.learner, self.steps)
        if self.preset.late is not None and self.steps >= self.preset.late[0]:
            self.vec.env.weights.update(self.preset.late[1])
        figures = iterate(self.vec, self.learner, self.preset.horizon, self.guard, self.steps)
        took = time.perf_counter() - start
        self.steps += self.batch
        self.elapsed += took
        return {
            **figures,
            "iteration": self.steps // self.batch,
            "steps": self.steps,
            "wall_s": self.elapsed,
            "steps_per_s": self.batch / took,
            "learning_rate": self.learner.learning_rate,
        }

    def begin(self, init: Path | None) -> None:
        """Episodes of mixed age; weights of another run where one is named."""
        env = self.vec.env
        env.steps[:] = env.rng.integers(0, env.max_steps, env.n)
        if init is not None:
            other = load_checkpoint(init)
            load_networks(self.learner, other["learner"])
            self.init = {
                "policy": policy_hash(self.learner),
                "steps": other["steps"],
                "wall_s": other["elapsed"],
                "init": other["init"],
            }

    def save(self) -> None:
        """Replace the checkpoint atomically."""
        tree = {
            "steps": self.steps,
            "elapsed": self.elapsed,
            "policy": policy_hash(self.learner),
            "init": self.init,
            "learner": learner_state(self.learner),
            "random": random_state(),
            "env": self.vec.env.state(),
        }
        write_tree(self.out / CHECKPOINT, tree)

    def load(self, tree: Tree) -> None:
        """Go on from :meth:`save`."""
        self.steps, self.elapsed = int(tree["steps"]), float(tree["elapsed"])
        self.init = tree["init"]
        load_learner(self.learner, tree["learner"])
        self.vec.env.load_state(tree["env"])
        load_random_state(tree["random"])


def load_checkpoint(run: Path) -> Tree:
    """The checkpoint of a run folder. Raises :class:`InvalidInput` if there is none."""
    path = run / CHECKPOINT
    if not path.is_file():
        raise InvalidInput(f"{run} holds no {CHECKPOINT}; type 'mobius train' first")
    return read_tree(path)


def _demand_room(out: Path, resume: bool) -> None:
    exists = (out / CHECKPOINT).exists()
    if exists and not resume:
        raise InvalidInput(
            f"{out} holds a training run already. Type --resume to continue it, or choose"
            " another --out"
        )
    if resume and not exists:
        raise InvalidInput(f"{out} holds no {CHECKPOINT} to resume; leave --resume away")


def read_config(run: Path) -> dict[str, Any]:
    """Seed, gait and preset of a run folder. Raises :class:`InvalidInput`."""
    path = run / "config.json"
    if not path.is_file():
        raise InvalidInput(f"{path}: no such file; without it nobody knows what the run was")
    config: dict[str, Any] = json.loads(path.read_text())
    return config


def _read_run(out: Path, wanted: dict[str, Any]) -> Tree:
    """The checkpoint of a run that was begun as ``wanted``; only the budget may change."""
    begun = read_config(out)
    other = sorted(k for k in wanted if k != "steps" and begun.get(k) != wanted[k])
    if other:
        raise InvalidInput(
            f"{out} was begun with another {', '.join(other)}; resume with the same body, preset"
            " and seed, or choose another --out"
        )
    return load_checkpoint(out)


def iterate(
    vec: RslVecEnv, learner: PPO, horizon: int, guard: Guard, steps: int
) -> dict[str, float]:
    """One rollout of ``horizon`` policy steps and one update; means of the rollout's log.

    Raises:
        TrainingStopped: a number is not finite; ``steps`` names the dump.
    """
    logs: list[dict[str, float]] = []
    reward = 0.0
    guard.before_rollout()
    with torch.inference_mode():
        obs = vec.get_observations()
        for _ in range(horizon):
            try:
                obs, rewards, dones, extras = vec.step(learner.act(obs))
            except NotFinite as error:
                guard.physics(error, steps)
                raise
            learner.process_env_step(obs, rewards, dones, extras)
            logs.append(extras["log"])
            reward += float(rewards.mean()) / horizon
        learner.compute_returns(obs)
    guard.before_update()
    losses = learner.update()
    guard.after_update(losses, steps)
    figures = {k.strip("/"): float(np.mean([log[k] for log in logs])) for k in logs[0]}
    figures["reward"] = reward
    figures["action_std"] = float(learner.get_policy().output_std.detach().mean())
    figures.update({f"loss/{k}": float(v) for k, v in losses.items()})
    return figures
