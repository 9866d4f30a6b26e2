"""The closed loop of an axis with a contact: the very law that runs, and a spring.

The environment answers W = -k (y - p) to the servo's position y, the wrench is read once a
tick and passes the exponential filter of the conditioning. One more state, the filtered
wrench w, closes the loop; everything is linear, so stability is a spectral radius.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.control.admittance.law import DT, SERVO_LAG, AxisGains, batch_steps
from mobius.errors import InvalidInput

__all__ = ["Interval", "Loop", "as_rows", "closed_loops", "damping", "spectral_radius"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Interval:
    """Contact stiffnesses and servo lags that a loop must bear."""

    low: float
    """Softest contact [N/m]."""
    high: float
    """Stiffest contact [N/m]."""
    lag: tuple[float, ...] = (0.8, 1.25)
    """Factors on the nominal servo lag."""
    points: int = 9
    """Stiffnesses tried, spaced in the logarithm, both ends among them."""

    def __post_init__(self) -> None:
        if not 0 < self.low <= self.high < np.inf:
            raise InvalidInput(
                "Interval: expected stiffnesses 0 < low <= high [N/m], got"
                f" {self.low:g} and {self.high:g}"
            )
        if not self.lag or min(self.lag) <= 0 or self.points < 2:
            raise InvalidInput("Interval: expected lag factors > 0 and at least 2 points")

    @property
    def stiffness(self) -> Array:
        """(points,) [N/m]."""
        return np.geomspace(self.low, self.high, self.points)


@dataclass(frozen=True)
class Loop:
    """What stands between law and contact."""

    tau: float = SERVO_LAG
    """Nominal servo lag [s]."""
    dt: float = DT
    """Tick [s]."""
    filter_coefficient: float = 0.3
    """Of the wrench filter: share of the new reading, (0, 1]."""
    delay: int = 1
    """Ticks from a command to the servo, 0 or 1."""

    def __post_init__(self) -> None:
        if not 0 < self.filter_coefficient <= 1:
            raise InvalidInput(
                f"Loop.filter_coefficient: expected (0, 1], got {self.filter_coefficient}"
            )
        if self.delay not in (0, 1):
            raise InvalidInput(f"Loop.delay: expected 0 or 1 tick, got {self.delay}")


def as_rows(gains: AxisGains | ArrayLike) -> Array:
    """Gains (k, 6) from one set or an array (6,) or (k, 6)."""
    if isinstance(gains, AxisGains):
        g = gains
        return np.array([[g.M, g.D, g.K, g.K_f, g.K_fi, g.K_pi]])
    return np.atleast_2d(np.asarray(gains, dtype=float))


def closed_loops(gains: Array, stiffness: Array, loop: Loop, *, tau: float | None = None) -> Array:
    """Closed-loop matrices (k, s, 6, 6) of states (x, v, z, y, w, x before).

    Args:
        gains: (k, 6).
        stiffness: (s,) [N/m].
        loop: Lag, tick, filter, delay.
        tau: Another servo lag than the loop's [s].
    """
    tau, a = loop.tau if tau is None else tau, loop.filter_coefficient
    A, _B, E = batch_steps(gains, tau, loop.dt)
    k, s = len(gains), len(stiffness)
    out = np.zeros((k, s, 6, 6))
    # w+ = (1 - a) w - a k y: read first, then the law steps with what was read
    w_row = np.zeros((s, 6))
    w_row[:, 3], w_row[:, 4] = -a * stiffness, 1 - a
    out[:, :, :4, :4] = A[:, None]
    if loop.delay:
        keep = float(np.exp(-loop.dt / tau)) if tau > 0 else 0.0
        out[:, :, 3] = 0.0
        out[:, :, 3, 3], out[:, :, 3, 5] = keep, 1 - keep
        E = E.copy()
        E[:, 3] = 0.0
    out[:, :, :4] += E[:, None] * w_row[None, :, None]
    out[:, :, 4] = w_row
    out[:, :, 5, 0] = 1.0
    return out


def _reachable(gains: Array) -> NDArray[np.bool_]:
    """(k,) whether the integral takes part."""
    return (gains[:, 4] > 0) | (gains[:, 5] > 0)


def _eigenvalues(gains: Array, interval: Interval, loop: Loop) -> Array:
    """(k, n) eigenvalues over stiffnesses and lags; that of an unused integral is left out."""
    stiffness = interval.stiffness
    found = []
    for factor in interval.lag:
        A = closed_loops(gains, stiffness, loop, tau=factor * loop.tau)
        A[~_reachable(gains), :, 2, 2] = 0.0
        found.append(np.linalg.eigvals(A).reshape(len(gains), -1))
    return np.concatenate(found, axis=1)


def spectral_radius(gains: AxisGains | ArrayLike, interval: Interval, loop: Loop) -> Array:
    """Largest |eigenvalue| (k,) of the loop over stiffnesses and lags; below 1 is stable."""
    radius: Array = np.abs(_eigenvalues(as_rows(gains), interval, loop)).max(axis=1)
    return radius


def damping(gains: AxisGains | ArrayLike, interval: Interval, loop: Loop) -> Array:
    """Smallest damping ratio (k,) of a pole over stiffnesses and lags; negative is unstable.

    Poles on the negative real axis of the discrete plane alternate their sign at each tick;
    they count by their logarithm like all others.
    """
    poles = _eigenvalues(as_rows(gains), interval, loop)
    s = np.log(np.where(np.abs(poles) < 1e-12, 1e-12, poles).astype(complex))
    ratio: Array = (-s.real / np.maximum(np.abs(s), 1e-12)).min(axis=1)
    return ratio
