"""The environment as rsl_rl sees it."""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from rsl_rl.env import VecEnv
from tensordict import TensorDict

from mobius.train.env import LocomotionEnv


class RslVecEnv(VecEnv):
    """Adapter of :class:`LocomotionEnv` to rsl_rl's contract (autoreset in the same step)."""

    def __init__(self, env: LocomotionEnv) -> None:
        self.env = env
        self.num_envs = env.n
        self.num_actions = env.layout.actions
        self.max_episode_length = env.max_steps
        self.device = "cpu"
        self.cfg: dict[str, Any] = {}

    @property
    def episode_length_buf(self) -> torch.Tensor:
        """(n,) steps of the running episodes."""
        return torch.from_numpy(self.env.steps)

    @episode_length_buf.setter
    def episode_length_buf(self, value: torch.Tensor) -> None:
        self.env.steps[:] = value.numpy()

    def get_observations(self) -> TensorDict:
        """Observation groups ``policy`` and ``privileged``, float32."""
        return TensorDict(
            {
                "policy": torch.from_numpy(self.env.observation.astype(np.float32)),
                "privileged": torch.from_numpy(self.env.privileged.astype(np.float32)),
            },
            batch_size=[self.num_envs],
        )

    def step(
        self, actions: torch.Tensor
    ) -> tuple[TensorDict, torch.Tensor, torch.Tensor, dict[str, Any]]:
        """One policy step of all robots."""
        result = self.env.step(actions.numpy().astype(np.float64))
        extras = {"time_outs": torch.from_numpy(result.time_out), "log": result.log}
        return (
            self.get_observations(),
            torch.from_numpy(result.reward.astype(np.float32)),
            torch.from_numpy(result.done.astype(np.int64)),
            extras,
        )
