"""What a plan takes in time and energy: Table V and Table VI of the paper.

The planner counts steps, though a step of one mode lasts longer than that of another. These
functions say what a plan means in seconds and joules. To let the planner itself weigh them, give
``Weights`` a price per second or joule; :func:`read_costs` takes measured numbers from a file.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from types import MappingProxyType

import numpy as np

from mobius import paper
from mobius.plan.actions import PLANNABLE
from mobius.plan.check import cells_seen
from mobius.plan.problem import Problem
from mobius.plan.travel import MAX_SPEED as MAX_SPEED
from mobius.plan.travel import Travel
from mobius.plan.travel import read_costs as read_costs
from mobius.types import Mode, Plan

__all__ = ["J_PER_CELL", "MAX_SPEED", "PlanCost", "plan_cost", "read_costs", "step_duration"]

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
    """Time at the given speeds, without mode changes and rests [s]."""
    energy_J: float
    """Sum over the cells seen, each at the price of the mode that saw it [J]."""
    energy_per_cell_J: float
    """``energy_J`` over the number of cells seen after the start [J]."""
    cells_seen: int
    """Cells seen, the start included where it counts."""
    mode_switches: int
    """How often the mode changes along the plan."""
    travel_J: float = 0.0
    """Energy by the metre, at the J per metre of the problem's weights, without mode changes
    [J]."""


def step_duration(
    mode: Mode, length: float, *, max_speed: Mapping[Mode, float] = MAX_SPEED
) -> float:
    """Time [s] that one step of ``length`` [m] takes at the mode's top speed."""
    return Travel(max_speed, {}, source="max_speed").seconds(mode, length)


def plan_cost(
    problem: Problem,
    plan: Plan,
    *,
    max_speed: Mapping[Mode, float] | None = None,
    J_per_cell: Mapping[Mode, float] = J_PER_CELL,
) -> PlanCost:
    """Length, duration and energy of a plan.

    Args:
        problem: Says which cells count as seen.
        plan: A plan of that problem.
        max_speed: [m/s] per mode; those of the problem's weights if not given.
        J_per_cell: [J] per cell seen, per mode.
    """
    lengths = np.hypot(*np.diff(plan.xy_M, axis=0).T) if len(plan.modes) else np.zeros(0)
    travel = problem.weights.travel
    max_speed = travel.m_per_s if max_speed is None else max_speed
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
        travel_J=sum(
            travel.joules(mode, float(length))
            for mode, length in zip(plan.modes, lengths, strict=True)
            if mode in travel.J_per_m
        ),
    )
