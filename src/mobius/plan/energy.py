"""What a plan takes in time and energy: Table V and Table VI of the paper.

The planner counts steps, though a step of one mode lasts longer than that of another. These
functions say what a plan means in seconds and joules.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from types import MappingProxyType

import numpy as np

from mobius import paper
from mobius.errors import PlanError
from mobius.plan.actions import PLANNABLE
from mobius.plan.check import cells_seen
from mobius.plan.problem import Problem
from mobius.types import Mode, Plan

__all__ = ["J_PER_CELL", "MAX_SPEED", "PlanCost", "plan_cost", "step_duration"]

MAX_SPEED: Mapping[Mode, float] = MappingProxyType(
    {mode: paper.MAX_SPEED[mode] for mode in PLANNABLE}
)
"""Top speed of each mode [m/s], Table V."""

J_PER_CELL: Mapping[Mode, float] = MappingProxyType(
    {mode: paper.TABLE_VI_SINGLE[mode].energy for mode in PLANNABLE}
)
"""Energy per visited cell [J], Table VI (the paper's text swaps biped and roll)."""


@dataclass(frozen=True)
class PlanCost:
    """A plan in physical units."""

    length_m: float
    """Path length [m]."""
    duration_s: float
    """Time at the given speeds, without mode changes [s]."""
    energy_J: float
    """Sum over the cells seen, each at the price of the mode that saw it [J]."""
    energy_per_cell_J: float
    """``energy_J`` over the number of cells seen after the start [J]."""
    cells_seen: int
    """Cells seen, the start included where it counts."""
    mode_switches: int
    """How often the mode changes along the plan."""


def step_duration(
    mode: Mode, length: float, *, max_speed: Mapping[Mode, float] = MAX_SPEED
) -> float:
    """Time [s] that one step of ``length`` [m] takes at the mode's top speed."""
    if mode not in max_speed:
        raise PlanError(f"no speed for mode '{mode}'; add it to max_speed")
    return length / max_speed[mode]


def plan_cost(
    problem: Problem,
    plan: Plan,
    *,
    max_speed: Mapping[Mode, float] = MAX_SPEED,
    J_per_cell: Mapping[Mode, float] = J_PER_CELL,
) -> PlanCost:
    """Length, duration and energy of a plan.

    Args:
        problem: Says which cells count as seen.
        plan: A plan of that problem.
        max_speed: [m/s] per mode.
        J_per_cell: [J] per cell seen, per mode.
    """
    lengths = np.hypot(*np.diff(plan.xy_M, axis=0).T) if len(plan.modes) else np.zeros(0)
    duration = sum(
        step_duration(mode, float(length), max_speed=max_speed)
        for mode, length in zip(plan.modes, lengths, strict=True)
    )
    energy, paid = 0.0, 0
    before: set[tuple[int, int]] = cells_seen(problem, plan.cells[:1], ())
    for t, mode in enumerate(plan.modes):
        now = cells_seen(problem, plan.cells[: t + 2], plan.modes[: t + 1])
        energy += J_per_cell[mode] * len(now - before)
        paid += len(now - before)
        before = now
    return PlanCost(
        length_m=float(lengths.sum()),
        duration_s=float(duration),
        energy_J=energy,
        energy_per_cell_J=energy / paid if paid else 0.0,
        cells_seen=len(before),
        mode_switches=sum(a != b for a, b in pairwise(plan.modes)),
    )
