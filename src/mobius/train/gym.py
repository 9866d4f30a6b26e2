"""The environment for everyone else's learners: Gymnasium ids and a vector environment.

    import gymnasium
    env = gymnasium.make("mobius.train.gym:mobius/Biped-v0")   # importing this file registers
    envs = gymnasium.make_vec("mobius.train.gym:mobius/Crawl-v0", num_envs=512,
                              vectorization_mode="vector_entry_point")

Actions are in [-1, 1]: raw policy actions divided by :data:`mobius.control.action.ACTION_CLIP`.
Observations are those of the policy, clipped to the bounds of their space. The randomisation is
the preset's in full from the first step; its curriculum is off, so that a seed fixes an episode.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from mobius.control.action import ACTION_CLIP
from mobius.control.observation import Layout
from mobius.train.curriculum import CurriculumConfig
from mobius.train.env import LocomotionEnv, StepResult
from mobius.train.presets import EnvConfig, preset_of
from mobius.train.randomise import settle_pool

Obs = NDArray[np.float32]
Array = NDArray[np.float64]
Info = dict[str, Any]

START_STATES = 16
"""Different settled stances that a single robot starts from, at least."""


def observation_limit(layout: Layout) -> Obs:
    """(size,) largest magnitude of every number of an observation; nothing real reaches it."""
    k = layout.actions
    tail = [ACTION_CLIP] * k + [2.0] * 3 + [1.0] * (2 if layout.clock else 0)
    if layout.kind == "paper":
        head = [np.pi] * 3 + [50.0] + [10.0] * 3
    else:
        head = [1.0] * 3 + [50.0] * 3 + [10.0] * 3
    return np.tile(np.array(head + [2 * np.pi] * k + tail, np.float32), layout.history)


class EpisodicEnv(LocomotionEnv):
    """A :class:`LocomotionEnv` of fixed difficulty that keeps how its episodes ended."""

    final: Array
    """(n, size) observations that the episodes which ended in the last step ended with."""
    _stepping = False

    def __init__(self, cfg: EnvConfig, n: int, *, nthread: int = 0) -> None:
        super().__init__(replace(cfg, curriculum=CurriculumConfig(step=0.0)), n, nthread=nthread)
        pools = [self.pool] + [settle_pool(self) for _ in range(START_STATES // n)]
        self.pool = (np.concatenate([q for q, _ in pools]), np.concatenate([v for _, v in pools]))

    def begin(self, rng: np.random.Generator) -> None:
        """Start all episodes, drawing from ``rng`` from now on."""
        self.rng = self.randomiser.rng = rng
        levels, columns = self.curriculum.levels, self.curriculum.columns
        if levels:
            self.curriculum.level[:] = rng.integers(0, levels + 1, self.n)
            self.curriculum.column[:] = rng.integers(0, columns, self.n)
        self.reset_all()

    def hold(self, command: tuple[float, float, float]) -> None:
        """Keep vx, vy [m/s], wz [rad/s] until the episodes end."""
        self.command[:], self.command_left[:] = command, np.inf
        self.reset_observation()

    def step(self, action: Array) -> StepResult:
        """As :meth:`LocomotionEnv.step`."""
        self._stepping = True
        try:
            return super().step(action)
        finally:
            self._stepping = False

    def _reset(self, ids: NDArray[np.int64]) -> None:
        if self._stepping:
            frames, history = self.frames.copy(), self.history.state()
            self.final, _ = self.observe()
            self.frames[:] = frames
            self.history.load_state(history)
        super()._reset(ids)


class _Spaces:
    """Observation and action space of one robot, and the way in and out of them."""

    def __init__(self, layout: Layout) -> None:
        self.limit = observation_limit(layout)
        self.observation = gymnasium.spaces.Box(-self.limit, self.limit)
        self.action = gymnasium.spaces.Box(-1.0, 1.0, (layout.actions,))

    def show(self, observation: Array) -> Obs:
        """Inside the space."""
        return np.clip(observation.astype(np.float32), -self.limit, self.limit)


class RobotEnv(gymnasium.Env[Obs, Obs]):
    """One robot, one command after the other; an episode ends by a fall or after 20 s.

    ``reset(options={"command": (vx, vy, wz)})`` holds one command for the episode.
    """

    metadata = {"render_modes": []}  # noqa: RUF012  as gymnasium has it

    def __init__(
        self,
        body: str,
        preset: str = "fast",
        cfg: EnvConfig | None = None,
        render_mode: str | None = None,
    ) -> None:
        """Args: body; preset, or cfg in its place; render_mode, which must be None."""
        self.render_mode = render_mode
        self._env = EpisodicEnv(cfg or preset_of(body, preset).env, 1, nthread=1)
        self._spaces = _Spaces(self._env.layout)
        self.observation_space, self.action_space = self._spaces.observation, self._spaces.action

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Obs, Info]:
        """Start an episode."""
        super().reset(seed=seed)
        self._env.begin(self.np_random)
        if options and "command" in options:
            self._env.hold(options["command"])
        return self._spaces.show(self._env.observation[0]), self._info()

    def step(self, action: Obs) -> tuple[Obs, float, bool, bool, Info]:
        """One policy step of 1/60 s."""
        result = self._env.step(ACTION_CLIP * np.asarray(action, dtype=float)[None])
        done, late = bool(result.done[0]), bool(result.time_out[0])
        seen = self._env.final if done else result.observation
        info = self._info() | {k.strip("/"): v for k, v in result.log.items()}
        return self._spaces.show(seen[0]), float(result.reward[0]), done and not late, late, info

    def _info(self) -> Info:
        return {"command": self._env.command[0].copy()}


class RobotVectorEnv(gymnasium.vector.VectorEnv[Obs, Obs, NDArray[Any]]):
    """n robots in one batched simulation; an episode that ends starts anew in the same step."""

    metadata = {"render_modes": [], "autoreset_mode": AutoresetMode.SAME_STEP}  # noqa: RUF012

    def __init__(
        self,
        num_envs: int = 1,
        body: str = "biped",
        preset: str = "fast",
        cfg: EnvConfig | None = None,
        nthread: int = 0,
    ) -> None:
        """Args: num_envs robots; body; preset, or cfg in its place; nthread CPU threads, 0 all."""
        self.num_envs = num_envs
        self._env = EpisodicEnv(cfg or preset_of(body, preset).env, num_envs, nthread=nthread)
        self._spaces = _Spaces(self._env.layout)
        self.single_observation_space = self._spaces.observation
        self.single_action_space = self._spaces.action
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Obs, Info]:
        """Start all episodes; ``options`` as :class:`RobotEnv` has them."""
        super().reset(seed=seed)
        self._env.begin(self.np_random)
        if options and "command" in options:
            self._env.hold(options["command"])
        return self._spaces.show(self._env.observation), {"command": self._env.command.copy()}

    def step(self, actions: Obs) -> tuple[Obs, Array, NDArray[np.bool_], NDArray[np.bool_], Info]:
        """One policy step of 1/60 s; ``final_obs`` holds what ended episodes ended with."""
        result = self._env.step(ACTION_CLIP * np.asarray(actions, dtype=float))
        info: Info = {"command": self._env.command.copy()}
        if result.done.any():
            last = np.full(self.num_envs, None, dtype=object)
            for i in np.flatnonzero(result.done):
                last[i] = self._spaces.show(self._env.final[i])
            info["final_obs"], info["_final_obs"] = last, result.done.copy()
        fallen = result.done & ~result.time_out
        return (
            self._spaces.show(result.observation), result.reward, fallen, result.time_out, info
        )  # fmt: skip


def register() -> None:
    """Make ``mobius/Biped-v0`` and ``mobius/Crawl-v0`` known to Gymnasium; once is enough."""
    for body in ("biped", "crawl"):
        name = f"mobius/{body.capitalize()}-v0"
        if name not in gymnasium.registry:
            gymnasium.register(
                name,
                entry_point="mobius.train.gym:RobotEnv",
                vector_entry_point="mobius.train.gym:RobotVectorEnv",
                kwargs={"body": body},
            )


register()
