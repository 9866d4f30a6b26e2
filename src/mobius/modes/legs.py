"""A plan cut where its mode changes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mobius.types import Mode, Plan

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Leg:
    """A stretch of a plan in one mode."""

    mode: Mode
    xy: Array
    """(k + 1, 2) points of the plan [m], k >= 1; a point where the plan rests is there once."""

    @property
    def length(self) -> float:
        """[m]."""
        return float(np.linalg.norm(np.diff(self.xy, axis=0), axis=1).sum())

    @property
    def heading(self) -> float:
        """Of its first step [rad]."""
        return heading_of(self.xy[0], self.xy[1])

    def as_plan(self) -> Plan:
        """The stretch alone, for a follower; its cells are numbers without a grid."""
        n = len(self.xy)
        cells = np.column_stack([np.arange(n), np.zeros(n, dtype=np.int64)])
        return Plan(cells, (self.mode,) * (n - 1), self.xy, "feasible", 0.0, 0.0, 0.0)

    def distance(self, p: Array) -> float:
        """Distance [m] of a point (2,) [m] to the stretch."""
        a, step = self.xy[:-1], np.diff(self.xy, axis=0)
        along = np.clip(((p - a) * step).sum(axis=1) / (step * step).sum(axis=1), 0.0, 1.0)
        return float(np.linalg.norm(a + along[:, None] * step - p, axis=1).min())


def heading_of(a: Array, b: Array) -> float:
    """Direction from a (2,) to b (2,) [rad]."""
    return float(np.arctan2(b[1] - a[1], b[0] - a[0]))


def legs_of(plan: Plan) -> list[Leg]:
    """The plan's stretches of equal mode, in order; rests are left out."""
    legs: list[Leg] = []
    points: list[Array] = []
    before: Mode | None = None
    for a, b, mode in zip(plan.xy_M[:-1], plan.xy_M[1:], plan.modes, strict=True):
        if np.linalg.norm(b - a) < 1e-9:
            continue
        if mode is not before:
            if before is not None:
                legs.append(Leg(before, np.array(points)))
            points, before = [a], mode
        points.append(b)
    if before is not None:
        legs.append(Leg(before, np.array(points)))
    return legs
