"""Cells that every plan sees, taken out of the problem before the search.

The start is seen by whoever leaves it, the goal by whoever must end there. Such a cell earns
its points once, whatever the plan; the bound table, which has no memory, would pay for it on
every visit. So it is marked as seen before, and its points are added at the end: the same
problem, with a tighter bound, above all for a tour that ends where it began.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mobius.plan.check import cells_seen
from mobius.plan.problem import Problem
from mobius.types import Plan

__all__ = ["with_points", "without_sure_cells"]


def without_sure_cells(problem: Problem) -> tuple[Problem, float]:
    """The problem with what every plan sees marked as seen, and the points that are worth.

    A plan of either problem is one of the other; its objective there is the one here less the
    points, and so is any bound.
    """
    ends = []
    if problem.count_terminal or (problem.horizon > 0 and not problem.early_stop):
        ends.append(problem.start)
    if problem.count_terminal and problem.must_reach:
        ends.append(problem.goal)
    counted = replace(problem, count_terminal=True)
    sure = set().union(*(cells_seen(counted, [cell], ()) for cell in ends))
    if not sure:
        return problem, 0.0
    seen = np.zeros(problem.grid.shape, bool) if problem.seen is None else problem.seen.copy()
    for cell in sure:
        seen[cell] = True
    return replace(problem, seen=seen), problem.weights.W_exp * len(sure)


def with_points(plan: Plan, points: float) -> Plan:
    """The plan with some points added to its objective and its bound."""
    return replace(plan, objective=plan.objective + points, bound=plan.bound + points)
