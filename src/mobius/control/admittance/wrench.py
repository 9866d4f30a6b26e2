"""From what the wrists' sensors say to the wrench the law hears.

Frames: S the sensor's own, G the closed fingertips (same axes as S, shifted by ``tip``), B
``base_link``, W gravity's frame with z up. The steps, in order:

1. minus the zero of the sensor, found by taring in S;
2. minus the weight of what hangs on it, gravity turned from W into S;
3. moved from the sensor's point to the fingertips, turned into the law's axes C;
4. minus the load that was there at the start, found by taring in C (the robot's own weight,
   when it hangs);
5. clip, exponential filter, deadband. Clipped first, one wild reading counts as one reading at
   the limit, not as many.

A reading, times the sensor's sign, is what the environment and gravity together do to the
gripper: pushed up by the floor with 10 N, f_z in W is +10. A reading with a
NaN, or older than the time-out, or whose frames are not finite, is not used: the last result stays
and is marked.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from mobius.control.admittance.config import AdmittanceConfig
from mobius.errors import InvalidInput
from mobius.geometry import cross

__all__ = ["Wrenches", "WrenchConditioner"]

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Wrenches:
    """Conditioned wrenches of n grippers at one tick."""

    wrench_C: Array
    """(n, 6) by the environment on the gripper at the fingertips, axes C [N, N m]."""
    raw_C: Array
    """(n, 6) the same before clip, filter and deadband, for whoever identifies or tunes."""
    fresh: Flags
    """(n,) False where the reading was NaN or stale; ``wrench_C`` is then the last good one."""
    clipped: Flags
    """(n, 6) where the reading went beyond ``wrench_min`` and ``wrench_max``."""


class WrenchConditioner:
    """Conditions the wrenches of n grippers, each with its own parameters."""

    def __init__(self, configs: Sequence[AdmittanceConfig]) -> None:
        if not configs:
            raise InvalidInput("WrenchConditioner: expected at least one configuration, got none")
        self.n = len(configs)
        sensors = [c.ft_sensor for c in configs]
        tools = [c.gravity_compensation for c in configs]
        self._sign = np.array([[float(s.sign)] for s in sensors])
        self._alpha = np.array([[s.filter_coefficient] for s in sensors])
        self._deadband = np.stack([s.deadband for s in sensors])
        self._tip = np.stack([s.tip for s in sensors])
        self._timeout = np.array([s.timeout for s in sensors])
        self._weight = np.array([[t.cog_force] for t in tools])
        self._cog = np.stack([t.cog_pos for t in tools])
        self._low = np.stack([c.wrench_min for c in configs])
        self._high = np.stack([c.wrench_max for c in configs])
        self.zero_S = np.zeros((self.n, 6))
        """(n, 6) zero of each sensor [N, N m]."""
        self.load_C = np.zeros((self.n, 6))
        """(n, 6) load that counts as none [N, N m]."""
        self.reset()

    def reset(self) -> None:
        """Forget the filter; zero and load stay."""
        self._filtered = np.zeros((self.n, 6))
        self._seen = np.zeros(self.n, dtype=bool)

    @property
    def filtered_C(self) -> Array:
        """(n, 6) output of the filter, before the deadband [N, N m]; a copy."""
        return self._filtered.copy()

    def tare_sensor(self, wrench_S: Array, up_S: Array) -> None:
        """Take readings with nothing touched as the sensors' zeros.

        Args:
            wrench_S: (t, n, 6) or (n, 6) readings; their mean counts.
            up_S: (n, 3) world's z axis in each sensor's axes.
        """
        weight = self._tool(np.asarray(up_S, dtype=float))
        self.zero_S = self._mean(wrench_S) - self._sign * weight

    def tare_load(self, wrench_S: Array, up_S: Array, R_CS: Array) -> None:
        """Take what readings still hold as the load that counts as none.

        Args:
            wrench_S: (t, n, 6) or (n, 6) readings; their mean counts.
            up_S: (n, 3) world's z axis in each sensor's axes.
            R_CS: (n, 3, 3) sensor to law axes.
        """
        self.load_C = self._moved(self._mean(wrench_S), np.asarray(up_S, dtype=float), R_CS)
        self.reset()

    def update(
        self, wrench_S: Array, up_S: Array, R_CS: Array, *, age: Array | float = 0.0
    ) -> Wrenches:
        """One tick.

        Args:
            wrench_S: (n, 6) readings [N, N m]; NaN where there is none.
            up_S: (n, 3) world's z axis in each sensor's axes.
            R_CS: (n, 3, 3) sensor to law axes.
            age: (n,) of the readings [s].
        """
        wrench_S = np.asarray(wrench_S, dtype=float)
        if wrench_S.shape != (self.n, 6):
            raise InvalidInput(
                f"wrench_S: expected shape ({self.n}, 6), a row a gripper, got {wrench_S.shape}"
            )
        fresh = np.isfinite(wrench_S).all(axis=1) & (age <= self._timeout)
        if fresh.all():
            raw = self._moved(wrench_S, up_S, R_CS) - self.load_C
        else:
            raw = self._moved(np.where(fresh[:, None], wrench_S, 0.0), up_S, R_CS) - self.load_C
            raw = np.where(fresh[:, None], raw, self._filtered)
        if not isfinite(raw.sum()):  # an attitude or an arm's angle was not
            fresh = fresh & np.isfinite(raw).all(axis=1)
            raw = np.where(fresh[:, None], raw, self._filtered)
        new = np.where((fresh & ~self._seen)[:, None], 1.0, self._alpha)
        within = np.minimum(np.maximum(raw, self._low), self._high)
        clipped = within != raw
        clean = self._filtered = self._filtered + new * (within - self._filtered)
        self._seen = self._seen | fresh
        clean = clean - np.minimum(np.maximum(clean, -self._deadband), self._deadband)
        return Wrenches(clean, raw, fresh, clipped)

    def _mean(self, wrench_S: Array) -> Array:
        readings = np.asarray(wrench_S, dtype=float).reshape(-1, self.n, 6)
        if not np.isfinite(readings).all():
            raise InvalidInput("taring wants finite readings; a sensor said NaN")
        mean: Array = readings.mean(axis=0)
        return mean

    def _tool(self, up_S: Array) -> Array:
        """(n, 6) what the weight alone does to each sensor."""
        f = -self._weight * up_S
        return np.concatenate([f, cross(self._cog, f)], axis=1)

    def _moved(self, wrench_S: Array, up_S: Array, R_CS: Array) -> Array:
        w = self._sign * (wrench_S - self.zero_S) - self._tool(up_S)
        f, tau = w[:, :3], w[:, 3:]
        pair = np.stack([f, tau - cross(self._tip, f)], axis=1)  # (n, 2, 3)
        return (pair @ np.swapaxes(R_CS, -1, -2)).reshape(self.n, 6)
