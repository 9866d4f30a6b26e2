"""When a number stops being finite: leave what is needed to see it again, and see it again.

A dump is one safetensors file. ``step``: the environment's state before the step, the action
and the robots. ``update``: the learner before the update and the rollout it learned from.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from rsl_rl.algorithms import PPO
from tensordict import TensorDict

from mobius.errors import InvalidInput, MobiusError
from mobius.train.checkpoint import read_tree, write_tree
from mobius.train.config import as_plain, preset_from
from mobius.train.ppo import build_learner
from mobius.train.presets import Preset
from mobius.train.snapshot import (
    Tree,
    finite_learner,
    learner_state,
    load_learner,
    load_random_state,
    random_state,
)
from mobius.train.vec import RslVecEnv
from mobius.train.watch import NotFinite, WatchedEnv

_ROLLOUT = ("actions", "values", "returns", "advantages", "actions_log_prob")


class TrainingStopped(MobiusError):
    """Training met a number that is not finite; the message names the dump."""


@dataclass(frozen=True)
class Replayed:
    """What came of a replay."""

    kind: str
    """``step`` or ``update``."""
    recorded: str
    """What was not finite when the dump was written."""
    seen: str | None
    """What is not finite now; None when everything is."""
    robots: NDArray[np.int64]
    """(m,) robots concerned in the recording; empty for ``update``."""


class Guard:
    """Watches one run; at most one dump, then the run ends."""

    def __init__(self, preset: Preset, vec: RslVecEnv, learner: PPO, folder: Path) -> None:
        assert isinstance(vec.env, WatchedEnv)
        self.preset, self.env, self.learner, self.folder = preset, vec.env, learner, folder

    def before_rollout(self) -> None:
        """Remember where the environment is."""
        self.env.mark()

    def before_update(self) -> None:
        """Remember the learner and the rollout it is about to learn from."""
        self._learner, self._random = learner_state(self.learner), random_state()

    def after_update(self, losses: dict[str, float], steps: int) -> None:
        """Raises :class:`TrainingStopped` when losses or weights are not finite."""
        bad = _bad_update(losses, self.learner)
        if bad is None:
            return
        storage = self.learner.storage
        tree = {
            "learner": self._learner,
            "random": self._random,
            "entropy": float(self.learner.entropy_coef),
            "observations": dict(storage.observations.items()),
            "params": list(storage.distribution_params or ()),
            **{name: getattr(storage, name) for name in _ROLLOUT},
        }
        self._stop("update", bad, tree, steps)

    def physics(self, error: NotFinite, steps: int) -> None:
        """Dump and raise :class:`TrainingStopped` for what the environment met."""
        state, action = self.env.before()
        self._stop("step", str(error), {"env": state, "action": action}, steps, error.robots)

    def _stop(
        self, kind: str, what: str, tree: Tree, steps: int, robots: NDArray[np.int64] | None = None
    ) -> None:
        path = self.folder / f"{kind}_{steps:010d}.safetensors"
        robots = np.zeros(0, dtype=np.int64) if robots is None else robots
        head = {"kind": kind, "what": what, "robots": robots, "preset": as_plain(self.preset)}
        write_tree(path, {**head, **tree})
        raise TrainingStopped(
            f"training stopped after {steps} steps, not finite: {what}. See it again with"
            f" mobius train --replay {path} (the last checkpoint is from before)"
        )


def _bad_update(losses: dict[str, float], learner: PPO) -> str | None:
    bad = [f"loss {k}" for k, v in losses.items() if not np.isfinite(v)]
    if not finite_learner(learner):
        bad.append("weights")
    return ", ".join(bad) or None


def replay(path: Path) -> Replayed:
    """Do again what a dump recorded.

    Raises:
        InvalidInput: ``path`` is no dump, or of another version.
    """
    tree = read_tree(path)
    if tree.get("kind") not in ("step", "update"):
        raise InvalidInput(f"{path}: expected a dump out of a run's nan folder, got another file")
    preset = preset_from(tree["preset"])
    again = _replay_step if tree["kind"] == "step" else _replay_update
    return Replayed(tree["kind"], tree["what"], again(preset, tree), tree["robots"])


def _replay_step(preset: Preset, tree: Tree) -> str | None:
    env = WatchedEnv(preset.env, len(tree["action"]), nthread=1)
    env.load_state(tree["env"])
    try:
        env.step(tree["action"])
    except NotFinite as error:
        return str(error)
    return None


def _replay_update(preset: Preset, tree: Tree) -> str | None:
    n, observations = tree["actions"].shape[1], tree["observations"]
    vec = RslVecEnv(WatchedEnv(preset.env, n, nthread=1))
    learner = build_learner(preset, vec)
    load_learner(learner, tree["learner"])
    load_random_state(tree["random"])
    learner.entropy_coef = tree["entropy"]
    storage = learner.storage
    for name in _ROLLOUT:
        getattr(storage, name).copy_(torch.from_numpy(tree[name]))
    storage.observations.copy_(
        TensorDict(
            {k: torch.from_numpy(v) for k, v in observations.items()}, batch_size=[]
        ).auto_batch_size_(2)
    )
    storage.distribution_params = tuple(torch.from_numpy(v) for v in tree["params"])
    return _bad_update(dict(learner.update()), learner)
