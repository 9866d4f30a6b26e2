"""Problem -> Plan: exact search with a certificate, or an honest gap.

1. Cells that every plan sees are taken out (:mod:`mobius.plan.sure`).
2. The memoryless table gives a bound and steers everything after it. Large maps go on in
   :mod:`mobius.plan.large`.
3. A depth-first search, then a narrow beam, look for a path that attains the bound: optimal,
   done.
4. Over a long horizon windows of the plan are searched again (:mod:`mobius.plan.windows`).
5. A beam of width 1, 2, 4, ... improves the plan until nothing is cut off any more
   (optimal), the plan meets a bound (optimal), or the budget is spent (feasible, with the
   best bound known).
6. Beams wider than 16 work on arrays, with stretches that improve plans and a relaxation that
   lowers the bound (:mod:`mobius.plan.deepen`); where the arrays do not know an option of the
   problem, or it is too large for them, step 5 goes on.
"""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from mobius.plan.bounds import build_arcs, capacity_bound, dp_bound
from mobius.plan.build import why_no_plan
from mobius.plan.check import check
from mobius.plan.deepen import Deepening
from mobius.plan.flatspace import FlatSpace
from mobius.plan.large import LONG, is_large, polish, solve_large
from mobius.plan.problem import Problem
from mobius.plan.progress import OnProgress, Teller
from mobius.plan.search import (
    Budget,
    Found,
    Link,
    Space,
    beam,
    checked_deadline,
    greedy,
    path_of,
)
from mobius.plan.stretches import known_way
from mobius.plan.sure import with_points, without_sure_cells
from mobius.types import Plan

__all__ = ["solve"]

MAX_STATES = 150_000
"""Default budget in search states, well under a second on a laptop core."""

GREEDY_STATES_PER_STEP = 4
"""Budget of the first search, per step of the horizon."""

TIGHT_WIDTHS = (8, 32)
"""Widths of the beams that look for a path that attains the bound, and for nothing else."""

NARROW = 16
"""Width of the widest beam state by state; beyond it arrays pay."""

LEAST_LEFT_S = 0.1
"""Time left [s] below which it does not pay to set up the arrays."""

POLISH_SHARE = 0.4
"""Part of the time left and of the states that windows may take where arrays come after."""


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
        deadline_s: Wall time [s] >= 0, the bound table included; ``None`` or inf for none. The
            table and a first plan are made in any case, however short it is.
        max_states: States the search may generate; ten states of an array count as one.
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
        InvalidInput: ``deadline_s`` is negative or no number.
    """
    deadline_s = checked_deadline(deadline_s)
    if incumbent is not None:
        check(problem, incumbent)
    rest, points = without_sure_cells(problem)
    known = None if incumbent is None else with_points(incumbent, -points)
    plan = _solve(
        rest,
        deadline_s=deadline_s,
        max_states=max_states,
        raise_infeasible=raise_infeasible,
        incumbent=known,
        on_progress=_shifted(on_progress, points),
    )
    return with_points(plan, points)


def _shifted(on_progress: OnProgress | None, points: float) -> OnProgress | None:
    """Tells of the whole problem what is told of the rest."""
    if on_progress is None:
        return None
    return lambda seconds, objective, bound: on_progress(
        seconds, objective + points, bound + points
    )


def _solve(
    problem: Problem,
    *,
    deadline_s: float | None,
    max_states: int,
    raise_infeasible: bool,
    incumbent: Plan | None,
    on_progress: OnProgress | None,
) -> Plan:
    """:func:`solve` without the cells that every plan sees."""
    began = time.perf_counter()
    arcs = build_arcs(problem)
    U = dp_bound(problem, arcs, window=True)
    space = Space(problem, arcs, U)
    if space.root == -np.inf:
        if raise_infeasible and (reason := why_no_plan(problem)) is not None:
            raise reason
        return _plan(problem, space, Found(-np.inf, None), -np.inf, began)
    tell = Teller(on_progress, began)
    tell(-np.inf, space.root)
    ends_s = None if deadline_s is None else began + deadline_s
    if is_large(problem):
        plan = solve_large(
            problem, arcs, U, deadline_s=_left(ends_s), max_states=max_states, incumbent=incumbent
        )
        tell(plan.objective, plan.bound)
        return replace(plan, solve_s=time.perf_counter() - began)
    best = greedy(space, Budget(GREEDY_STATES_PER_STEP * (problem.horizon + 1), _left(ends_s)))
    if best.link is not None:
        tell(best.value, best.value)
        return _plan(problem, space, best, best.value, began)
    best = _known(space, incumbent)
    tell(best.value, space.root)
    budget = Budget(max_states, _left(ends_s))
    for width in TIGHT_WIDTHS:  # only states that may still attain the bound: cheap, often enough
        found, _ = beam(space, width, Found(space.root - 2 * space.tol, None), budget)
        if found.link is not None:
            tell(found.value, found.value)
            return _plan(problem, space, found, found.value, began)
    bound = min(space.root, capacity_bound(problem, arcs))
    tell(best.value, bound)
    best, bound = _widened(space, best, bound, budget, ends_s, tell)
    return _plan(problem, space, best, bound, began)


def _left(ends_s: float | None) -> float | None:
    """Time left [s] until a moment of :func:`time.perf_counter`; ``None`` for ever."""
    return None if ends_s is None else ends_s - time.perf_counter()


def _widened(
    space: Space, best: Found, bound: float, budget: Budget, ends_s: float | None, tell: Teller
) -> tuple[Found, float]:
    """The best path and bound that wider and wider beams, windows and arrays find."""
    width, cut = 1, -np.inf
    while bound - best.value > space.tol and cut < np.inf:
        if width == 2 * NARROW and (flat := _flat_space(space, ends_s)) is not None:
            return _deepened(flat, best, bound, budget, ends_s, tell)
        # One state per step is affordable whatever the deadline, so there is always a plan.
        best, cut = beam(space, width, best, Budget(2**62, None) if width == 1 else budget)
        bound = min(bound, max(cut, best.value))
        tell(best.value, bound)
        if width == 1 and space.T >= LONG and bound - best.value > space.tol:
            best = _polished(space, best, bound, budget, ends_s)
            tell(best.value, bound)
        width *= 2
    return best, bound


def _polished(
    space: Space, best: Found, bound: float, budget: Budget, ends_s: float | None
) -> Found:
    """The path with its windows searched again."""
    began = time.perf_counter()
    share = POLISH_SHARE if FlatSpace.fits(space) else 1.0
    left = None if ends_s is None else share * (ends_s - began)
    states = int(share * budget.left)
    plan = _plan(space.problem, space, best, bound, began)
    plan = polish(space.problem, space.arcs, space.table, plan, deadline_s=left, max_states=states)
    return _known(space, plan)


def _flat_space(space: Space, ends_s: float | None) -> FlatSpace | None:
    """The space as arrays, if it is of a kind and size for them and there is time."""
    if ends_s is not None and ends_s - time.perf_counter() < LEAST_LEFT_S:
        return None
    return FlatSpace.of(space)


def _deepened(
    flat: FlatSpace,
    best: Found,
    bound: float,
    budget: Budget,
    ends_s: float | None,
    tell: Teller,
) -> tuple[Found, float]:
    """The searches of :mod:`mobius.plan.deepen`, from the path of the narrow beams."""
    way = known_way(flat, path_of(best.link)[0])
    way, bound = Deepening(flat, way, bound, budget, ends_s, tell).run()
    if way.value <= best.value + flat.tol:
        return best, bound
    return Found(way.value, flat.link(way.cells, way.actions)), bound


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
