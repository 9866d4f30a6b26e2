"""Algorithm 3: the admissible set by sampling, as printed and repaired, all samples at once.

As printed (one axis): every sample (x, v, x_ref, W, W_ref) is rolled out by second-order Euler
under (22); it is kept if position and velocity stay within limits for T seconds. In print

- what is stored is the *propagated* state, not the sample;
- the integrals are reset and never integrated;
- the wrench is neither propagated nor checked, although the text says so.

Repaired: the sample is stored; the integrals are integrated; the wrench follows the contact,
``W = W_0 - k_env (x - x_0)``, at both ends of the stiffness interval, and is checked; all
limits are tightened by a share, for what lies between samples and in the integrals, which are
no coordinate of the set.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mobius.control.governor.plant import REFERENCE_REACH, Axis
from mobius.errors import InvalidInput

__all__ = ["Grid", "SampledSet", "algorithm_3", "grid_of"]

Array = NDArray[np.float64]

COUNTS = (17, 13, 17, 7, 3)
"""Samples of x, v, x_ref, W, W_ref: 78,897 in all."""
HORIZON_S = 2.0
"""T [s]."""
TIGHTEN = 0.125
"""Share of the limits that the repaired version keeps free: one cell of x."""


@dataclass(frozen=True, eq=False)
class Grid:
    """Samples of every coordinate, rising, evenly spaced."""

    x: Array
    """[m]."""
    v: Array
    """[m/s]."""
    x_ref: Array
    """[m]."""
    W: Array
    """[N]."""
    W_ref: Array
    """[N]."""

    @property
    def axes(self) -> tuple[Array, ...]:
        """In the order of the tuple o."""
        return self.x, self.v, self.x_ref, self.W, self.W_ref

    @property
    def steps(self) -> Array:
        """(5,) distance of neighbouring samples; 1 where there is one only."""
        return np.array([a[1] - a[0] if len(a) > 1 else 1.0 for a in self.axes])

    def points(self) -> Array:
        """(N, 5) all samples."""
        return np.stack(np.meshgrid(*self.axes, indexing="ij"), axis=-1).reshape(-1, 5)


def grid_of(axis: Axis, counts: tuple[int, ...] = COUNTS) -> Grid:
    """Samples over the limits of an axis; references a little beyond position, half the wrench.

    Args:
        axis: Its limits.
        counts: Samples of x, v, x_ref, W, W_ref, >= 1.
    """
    if len(counts) != 5 or min(counts) < 1:
        raise InvalidInput(f"counts: expected five whole numbers >= 1, got {counts}")
    reach = min(REFERENCE_REACH, 1.5) * axis.position_max
    ends = (axis.position_max, axis.velocity_max, reach, axis.wrench_max, 0.5 * axis.wrench_max)
    x, v, x_ref, W, W_ref = (
        np.linspace(-e, e, n) if n > 1 else np.zeros(1) for e, n in zip(ends, counts, strict=True)
    )
    return Grid(x, v, x_ref, W, W_ref)


@dataclass(frozen=True, eq=False)
class SampledSet:
    """What Algorithm 3 returns."""

    points: Array
    """(N, 5) x, v, x_ref, W, W_ref."""
    grid: Grid
    repaired: bool

    @property
    def share(self) -> float:
        """Admissible share of the samples."""
        return len(self.points) / float(np.prod([len(a) for a in self.grid.axes]))


def algorithm_3(
    axis: Axis, grid: Grid | None = None, *, repaired: bool = False, horizon_s: float = HORIZON_S
) -> SampledSet:
    """Algorithm 3 on all samples of a grid at once.

    Args:
        axis: Gains, limits, stiffness interval; servo lag and disturbance are not in Alg. 3.
        grid: Of samples; :func:`grid_of` the axis if left out.
        repaired: See the head of this file.
        horizon_s: T [s], > 0.

    Raises:
        InvalidInput: T is shorter than a step, or no sample is admissible.
    """
    grid = grid_of(axis) if grid is None else grid
    steps = round(horizon_s / axis.dt)
    if steps < 1:
        raise InvalidInput(f"horizon_s: expected at least one step of {axis.dt:g} s")
    points = grid.points()
    kept = _repaired(axis, points, steps) if repaired else _printed(axis, points, steps)
    if not len(kept):
        raise InvalidInput(
            f"axis {axis.name}: none of {len(points)} samples is admissible; widen the limits"
        )
    return SampledSet(kept, grid, repaired)


def _printed(axis: Axis, points: Array, steps: int) -> Array:
    x, v, x_ref, W, W_ref = points.T.copy()
    dt, M = axis.dt, axis.mass
    push = axis.force_gain * (W - W_ref) + axis.stiffness * x_ref
    for _ in range(steps + 1):
        u = (push - axis.damping * v - axis.stiffness * x) / M
        x = x + v * dt + 0.5 * u * dt**2
        v = v + u * dt
        valid = (np.abs(x) <= axis.position_max) & (np.abs(v) <= axis.velocity_max)
        if not valid.all():
            x, v, x_ref, W, W_ref, push = (a[valid] for a in (x, v, x_ref, W, W_ref, push))
    return np.stack([x, v, x_ref, W, W_ref], axis=1)


def _repaired(axis: Axis, points: Array, steps: int) -> Array:
    keep = 1.0 - TIGHTEN
    for k_env in axis.environment:
        points = _stays(axis, points, steps, k_env, keep)
    return points


def _stays(axis: Axis, points: Array, steps: int, k_env: float, keep: float) -> Array:
    """Those samples (N, 5) whose rollout against a stiffness stays within limits."""
    dt, M = axis.dt, axis.mass
    limits = keep * np.array([axis.position_max, axis.velocity_max, axis.wrench_max])
    alive = np.arange(len(points))
    x, v, x_ref, W0, W_ref = points.T.copy()
    x0, z, W = x.copy(), np.zeros(len(points)), W0
    for _ in range(steps + 1):
        u = (
            axis.force_gain * (W - W_ref) + z - axis.damping * v - axis.stiffness * (x - x_ref)
        ) / M
        z = z + dt * (axis.integral_force * (W - W_ref) - axis.integral_position * (x - x_ref))
        x = x + v * dt + 0.5 * u * dt**2
        v = v + u * dt
        W = W0 - k_env * (x - x0)
        valid = (np.abs(x) <= limits[0]) & (np.abs(v) <= limits[1]) & (np.abs(W) <= limits[2])
        if not valid.all():
            alive = alive[valid]
            x, v, x_ref, W0, W_ref, x0, z, W = (
                a[valid] for a in (x, v, x_ref, W0, W_ref, x0, z, W)
            )
    return points[alive]
