"""Problem -> Plan: exact search with a certificate, or an honest gap.

1. The memoryless table gives a bound and steers everything after it.
2. A depth-first search, then a narrow beam, look for a path that attains the bound: optimal,
   done.
3. Otherwise a beam of width 1, 2, 4, ... improves the plan until nothing is cut off any
   more (optimal), the plan meets a bound (optimal), or the budget is spent (feasible, with
   the best bound known).
"""

from __future__ import annotations

import time

import numpy as np

from mobius.plan.bounds import build_arcs, capacity_bound, dp_bound
from mobius.plan.build import why_no_plan
from mobius.plan.check import check
from mobius.plan.problem import Problem
from mobius.plan.progress import OnProgress, Teller
from mobius.plan.search import Budget, Found, Link, Space, beam, greedy, path_of
from mobius.types import Plan

__all__ = ["solve"]

MAX_STATES = 150_000
"""Default budget in search states, well under a second on a laptop core."""

GREEDY_STATES_PER_STEP = 10
"""Budget of the first search, per step of the horizon."""

TIGHT_WIDTHS = (8, 32)
"""Widths of the beams that look for a path that attains the bound, and for nothing else."""


def solve(
    problem: Problem,
    *,
    deadline_s: float | None = 1.0,
    max_states: int = MAX_STATES,
    raise_infeasible: bool = True,
    incumbent: Plan | None = None,
    on_progress: OnProgress | None = None,
) -> Plan:
    """Find the best plan of a problem and prove how good it is.

    The same problem gives the same plan bit for bit, on any machine, as long as the
    deadline does not cut the search off before ``max_states`` does.

    Args:
        problem: From :func:`mobius.plan.build_problem`.
        deadline_s: Wall time [s] for the search after the bound table; ``None`` for none.
            A plan is returned in any case, however short it is.
        max_states: States the search may generate.
        raise_infeasible: If false, a problem without a plan gives an empty plan of status
            "infeasible" (objective and bound -inf) instead of an error.
        incumbent: A plan of this very problem to start from; what is returned is never worse.
        on_progress: Called with seconds since the start, best objective and bound [points]
            whenever one of them gets better, see :mod:`mobius.plan.progress`.

    Returns:
        A plan of status "optimal" (``bound == objective``) or "feasible" (``gap > 0``).

    Raises:
        NoPlan: There is none; says whether area, horizon or modes stand in the way.
        PlanError: ``incumbent`` breaks a rule of the problem.
    """
    if incumbent is not None:
        check(problem, incumbent)
    began = time.perf_counter()
    arcs = build_arcs(problem)
    U = dp_bound(problem, arcs)
    space = Space(problem, arcs, U)
    if space.root == -np.inf:
        if raise_infeasible and (reason := why_no_plan(problem)) is not None:
            raise reason
        return _plan(problem, space, Found(-np.inf, None), -np.inf, began)
    tell = Teller(on_progress, began)
    tell(-np.inf, space.root)
    best = greedy(space, Budget(GREEDY_STATES_PER_STEP * (problem.horizon + 1), deadline_s))
    if best.link is not None:
        tell(best.value, best.value)
        return _plan(problem, space, best, best.value, began)
    best = _known(space, incumbent)
    tell(best.value, space.root)
    budget = Budget(max_states, deadline_s)
    for width in TIGHT_WIDTHS:  # only states that may still attain the bound: cheap, often enough
        found, _ = beam(space, width, Found(space.root - 2 * space.tol, None), budget)
        if found.link is not None:
            tell(found.value, found.value)
            return _plan(problem, space, found, found.value, began)
    bound = min(space.root, capacity_bound(problem, arcs))
    tell(best.value, bound)
    width, cut = 1, -np.inf
    while bound - best.value > space.tol and cut < np.inf:
        # One state per step is affordable whatever the deadline, so there is always a plan.
        best, cut = beam(space, width, best, Budget(2**62, None) if width == 1 else budget)
        bound = min(bound, max(cut, best.value))
        tell(best.value, bound)
        width *= 2
    return _plan(problem, space, best, bound, began)


def _known(space: Space, plan: Plan | None) -> Found:
    """A plan that was checked, as a path of the search."""
    if plan is None:
        return Found(-np.inf, None)
    cells = [space.arcs.flat((int(i), int(j))) for i, j in plan.cells]
    link: Link = (None, cells[0], -1)
    for here, to, mode in zip(cells[:-1], cells[1:], plan.modes, strict=True):
        link = (link, to, space.action(here, to, mode))
    return Found(plan.objective, link)


def _plan(problem: Problem, space: Space, best: Found, bound: float, began: float) -> Plan:
    """The finished plan of the best path."""
    flat, actions = path_of(best.link)
    cells = np.array([space.arcs.cell(f) for f in flat], dtype=np.int64).reshape(-1, 2)
    proven = bound - best.value <= space.tol if best.link is not None else False
    return Plan(
        cells=cells,
        modes=tuple(problem.actions[a].mode for a in actions),
        xy_M=problem.grid.center_of(cells),
        status="infeasible" if best.link is None else "optimal" if proven else "feasible",
        objective=float(best.value),
        bound=float(best.value if proven or best.link is None else bound),
        solve_s=time.perf_counter() - began,
    )
