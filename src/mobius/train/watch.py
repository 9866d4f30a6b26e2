"""The environment under watch: the first number that is not finite stops it, and can be replayed.

MuJoCo resets a simulation that blows up and goes on; in training that would look like a fall.
Here it stops the training, unless the configuration allows for a few (``EnvConfig.blow_ups``).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from mujoco.batch import SimulationError
from numpy.typing import NDArray

from mobius.train.env import LocomotionEnv, StepResult
from mobius.train.rewards import Signals

Array = NDArray[np.float64]
Ids = NDArray[np.int64]


class NotFinite(FloatingPointError):
    """A number of some robots is not finite.

    Attributes:
        robots: (m,) which.
        what: Where it was seen: action, physics, observation, privileged or reward.
    """

    def __init__(self, robots: Ids, what: str) -> None:
        self.robots, self.what = robots, what
        some = ", ".join(map(str, robots[:8])) + (", ..." if len(robots) > 8 else "")
        super().__init__(f"{what} of robot {some}")


class WatchedEnv(LocomotionEnv):
    """A :class:`LocomotionEnv` that raises :class:`NotFinite`."""

    _marked: dict[str, Any] | None = None
    _taken: list[Array]

    def mark(self) -> None:
        """Remember the present state; actions are recorded from here on."""
        self._marked, self._taken = self.state(), []

    def step(self, action: Array) -> StepResult:
        """As :meth:`LocomotionEnv.step`. Raises :class:`NotFinite`."""
        if self._marked is not None:
            self._taken.append(np.array(action))
        _demand_finite(action, "action")
        try:
            result = super().step(action)
        except SimulationError as error:
            raise NotFinite(np.asarray(error.ids, dtype=np.int64), "physics") from error
        for name in ("observation", "privileged", "reward"):
            _demand_finite(getattr(result, name), name)
        return result

    def before(self) -> tuple[dict[str, Any], Array]:
        """State before the last step, and its action; found by going there again from the mark."""
        assert self._marked is not None and self._taken, "mark() and step() come first"
        self.load_state(self._marked)
        for action in self._taken[:-1]:
            super().step(action)
        return self.state(), self._taken[-1]

    def _signals(self) -> Signals:
        """Comes right after the physics, before blown-up robots are placed anew."""
        blown = self.sim.blown_up
        if blown.mean() > self.cfg.blow_ups:
            raise NotFinite(np.flatnonzero(blown), "physics")
        signals = super()._signals()
        signals.fallen[blown] = 1.0
        return signals


def _demand_finite(value: Array, what: str) -> None:
    if not np.isfinite(value).all():
        bad = ~np.isfinite(value).reshape(len(value), -1).all(axis=1)
        raise NotFinite(np.flatnonzero(bad), what)
