"""Large maps and long horizons: a plan stretch by stretch, windows of it searched again.

The bound is that of the whole problem: the memoryless table, or what there is to see where
that is less than the steps could see.
"""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mobius.plan.bounds import Arcs, capacity_bound, steps_from
from mobius.plan.check import objective_of
from mobius.plan.problem import Problem
from mobius.plan.rollout import roll_out
from mobius.plan.search import Budget, Found, Space, beam, path_of
from mobius.plan.windows import improve
from mobius.types import Mode, Plan

__all__ = ["LONG", "is_large", "polish", "solve_large"]

LARGE = 4_000_000
"""Entries of the bound table from which a search over the whole horizon is too slow."""
LONG = 40
"""Steps from which windows are worth it."""
ROLLOUT_SHARE = 0.4
"""Part of the time left that the first plan may take before it hurries."""


def is_large(problem: Problem) -> bool:
    """Whether :func:`solve_large` should take the problem."""
    nx, ny = problem.grid.shape
    return (problem.horizon + 1) * nx * ny > LARGE


class _LeanSpace(Space):
    """A space that reads the table in place: as lists it would take four times the memory."""

    def row(self, k: int, mode: int = 0) -> memoryview:  # type: ignore[override]  # indexed alike
        """Bound table with k steps to go, per flat cell."""
        return memoryview(self._tables[mode][k])


def solve_large(
    problem: Problem,
    arcs: Arcs,
    U: NDArray[np.float64],
    *,
    deadline_s: float | None,
    max_states: int,
    incumbent: Plan | None = None,
) -> Plan:
    """A plan and a bound for a problem that has a plan and is too large for one search.

    Args:
        problem: The problem.
        arcs: Its arcs.
        U: Its :func:`mobius.plan.bounds.dp_bound`.
        deadline_s: Wall time [s] from now on, ``None`` for none.
        max_states: States the windows may search.
        incumbent: A plan to start from; what is returned is never worse.
    """
    began = time.perf_counter()
    plan = _rolled(problem, arcs, U, deadline_s)
    if plan is None:
        space = _LeanSpace(problem, arcs, U)
        found, _ = beam(space, 1, Found(-np.inf, None), Budget(2**62, None))
        flat, actions = path_of(found.link)
        modes = [problem.actions[a].mode for a in actions]
        plan = _plan(problem, [arcs.cell(c) for c in flat], modes, space.root)
    if incumbent is not None and incumbent.objective >= plan.objective:
        plan = replace(incumbent, bound=min(plan.bound, incumbent.bound))
    if plan.gap > 0:
        plan = replace(plan, bound=_least_bound(problem, arcs, plan))
        plan = improve(problem, plan, deadline_s=_left(deadline_s, began), max_states=max_states)
    return replace(plan, solve_s=time.perf_counter() - began)


def polish(
    problem: Problem,
    arcs: Arcs,
    U: NDArray[np.float64],
    plan: Plan,
    *,
    deadline_s: float | None,
    max_states: int,
) -> Plan:
    """A plan that the search left with a gap, made better if its horizon is long.

    Args:
        problem: The problem.
        arcs: Its arcs.
        U: Its :func:`mobius.plan.bounds.dp_bound`.
        plan: A plan of the problem, with a valid bound.
        deadline_s: Wall time [s] from now on, ``None`` for none.
        max_states: States the windows may search.
    """
    if plan.status != "feasible" or (deadline_s is not None and deadline_s <= 0):
        return plan
    began = time.perf_counter()
    other = _rolled(problem, arcs, U, deadline_s)
    if other is not None and other.objective > plan.objective:
        plan = replace(other, bound=min(plan.bound, other.bound), solve_s=plan.solve_s)
    return improve(problem, plan, deadline_s=_left(deadline_s, began), max_states=max_states)


def _rolled(
    problem: Problem, arcs: Arcs, U: NDArray[np.float64], deadline_s: float | None
) -> Plan | None:
    """The plan made stretch by stretch; none where it may stop before the horizon is over."""
    if problem.early_stop:
        return None
    hurry = None if deadline_s is None else ROLLOUT_SHARE * deadline_s
    path = roll_out(problem, arcs, U, deadline_s=hurry)
    root = float(U[problem.horizon, arcs.flat(problem.start)])
    return None if path is None else _plan(problem, *path, root)


def _plan(problem: Problem, cells: list[tuple[int, int]], modes: list[Mode], bound: float) -> Plan:
    """A path as a plan, proven if it meets the bound."""
    where = np.array(cells, dtype=np.int64).reshape(-1, 2)
    value = objective_of(problem, where, modes)
    proven = bound - value <= 1e-9 * max(1.0, abs(bound))
    return Plan(
        cells=where,
        modes=tuple(modes),
        xy_M=problem.grid.center_of(where),
        status="optimal" if proven else "feasible",
        objective=value,
        bound=value if proven else bound,
        solve_s=0.0,
    )


def _least_bound(problem: Problem, arcs: Arcs, plan: Plan) -> float:
    """The plan's bound, or the capacity bound where that can be less.

    It cannot where more cells can be reached than T steps can see.
    """
    most = 1 + max((len(seen) for seen in arcs.seen), default=0)
    reached = (steps_from(problem, arcs) <= problem.horizon) & arcs.pays
    if np.count_nonzero(reached) > most * (problem.horizon + 1):
        return plan.bound
    return max(min(plan.bound, capacity_bound(problem, arcs)), plan.objective)


def _left(deadline_s: float | None, began: float) -> float | None:
    """What is left [s] of a time that began then."""
    return None if deadline_s is None else deadline_s - (time.perf_counter() - began)
