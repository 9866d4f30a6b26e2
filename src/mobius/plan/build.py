"""From a map and two points in metres to a :class:`Problem`, or to what is wrong with them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from itertools import permutations

import numpy as np
from numpy.typing import ArrayLike

from mobius.errors import InvalidInput, MapError, PlanError
from mobius.plan.actions import STEP_LENGTHS, Connectivity
from mobius.plan.bounds import UNREACHED, build_arcs, dp_bound, shortest_steps, steps_from
from mobius.plan.problem import (
    DEFAULT_WEIGHTS,
    Check,
    Count,
    NoPlan,
    Problem,
    Weights,
)
from mobius.plan.reasons import shut_in, what_separates
from mobius.plan.sight import footprint_of
from mobius.plan.travel import plan_mode
from mobius.types import GridMap, Mode

__all__ = ["build_problem", "literal_problem", "why_no_plan"]

FAR = 1e9
"""No map reaches this far [m]."""


def build_problem(
    grid: GridMap,
    *,
    start: ArrayLike | None = None,
    goal: ArrayLike | None = None,
    horizon: int | None = None,
    slack: int = 0,
    modes: Iterable[str | Mode] = ("biped", "crawl", "roll"),
    weights: Weights = DEFAULT_WEIGHTS,
    connectivity: Connectivity = "axis",
    count: Count = "sweep",
    check: Check = "swept",
    count_terminal: bool = True,
    allow_stay: bool = False,
    must_reach: bool = False,
    early_stop: bool = False,
    cell_cost: ArrayLike | None = None,
    seen: ArrayLike | None = None,
    closed: ArrayLike | None = None,
    switch_cost: float | Mapping[tuple[Mode, Mode], float] | None = None,
    last_mode: str | Mode | None = None,
    footprint: float | Iterable[Iterable[int]] | None = None,
) -> Problem:
    """State the planning problem of Table IV on a map.

    Seeing cells is rewarded, so a robot with steps to spare wanders. For a mission, say
    ``must_reach=True`` and leave ``horizon`` out: the plan is then a shortest path (in
    steps), and coverage and ``cell_cost`` choose among the shortest. To let it take a longer
    way round what ``cell_cost`` makes dear, add ``slack`` and ``early_stop=True`` and set
    ``W_exp=0``; a small ``cell_cost`` everywhere then keeps the way short in cells too.

    Args:
        grid: The map; obstacles already inflated.
        start: (2,) [m] in frame M; the map's own start if not given.
        goal: (2,) [m] in frame M; the map's own goal if not given.
        horizon: T, number of steps, >= 0. If not given, the fewest steps in which the goal
            can be reached, plus ``slack``.
        slack: Steps on top of the fewest, >= 0; only where ``horizon`` is not given.
        modes: Names of the modes that may be used.
        weights: Weights of the objective [points].
        connectivity: ``axis``, ``box`` or ``diagonal``, see :mod:`mobius.plan.actions`.
        count: ``sweep`` or ``endpoint``, see :class:`Problem`.
        check: ``swept`` or ``endpoint``, see :class:`Problem`.
        count_terminal: Whether the last cell counts as seen.
        allow_stay: Whether biped and crawl may rest for a step.
        must_reach: Whether the last cell must be the goal.
        early_stop: Whether fewer than T steps may be taken.
        cell_cost: (nx, ny) points >= 0 subtracted for every cell a step enters.
        seen: (nx, ny) cells that were seen before and earn nothing.
        closed: (K, nx, ny) cells that something else occupies at step 0, 1, ..., see
            :class:`Problem`. The fewest steps (``horizon`` left out) do not look at it.
        switch_cost: Points >= 0 for a change of mode: one number for all, or by (from, to).
        last_mode: The mode before the first step; the first step is no change without it.
        footprint: What a place sees: a radius or offsets (di, dj), in cells, less what
            obstacles hide; only itself if not given.

    Raises:
        MapError: Start or goal is off the map, in an obstacle, or on ground that none of
            the modes may use; names the nearest cell that would do.
        NoPlan: ``horizon`` is not given and the goal cannot be reached.
        PlanError: A place is missing, or an argument makes no sense.
    """
    chosen = tuple(plan_mode(m) for m in modes)
    if not chosen:
        raise PlanError("no modes to plan with; pass some of biped, crawl, roll")
    if not slack >= 0:
        raise InvalidInput(f"slack: expected a number of steps >= 0, got {slack}")
    if slack and horizon is not None:
        raise PlanError("slack only adds to the smallest horizon; leave out horizon or slack")
    problem = Problem(
        grid,
        _place(grid, "start", start, chosen),
        _place(grid, "goal", goal, chosen),
        horizon=0 if horizon is None else horizon,
        modes=chosen,
        weights=weights,
        connectivity=connectivity,
        count=count,
        check=check,
        count_terminal=count_terminal,
        allow_stay=allow_stay,
        must_reach=must_reach,
        early_stop=early_stop,
        cell_cost=None if cell_cost is None else np.asarray(cell_cost, dtype=float),
        seen=None if seen is None else np.asarray(seen, dtype=bool),
        closed=None if closed is None else np.asarray(closed, dtype=bool),
        switch_cost=_switches(switch_cost),
        last_mode=None if last_mode is None else plan_mode(last_mode),
        footprint=None if footprint is None else footprint_of(footprint),
    )
    if horizon is not None:
        return problem
    arcs = build_arcs(problem)
    fewest = int(shortest_steps(problem, arcs)[arcs.flat(problem.start)])
    if fewest >= UNREACHED:
        raise NoPlan(_closed_off(problem))
    return replace(problem, horizon=fewest + slack)


def _switches(
    cost: float | Mapping[tuple[Mode, Mode], float] | None,
) -> Mapping[tuple[Mode, Mode], float] | None:
    """One number as a table of every change."""
    if cost is None or isinstance(cost, Mapping):
        return cost
    return {pair: float(cost) for pair in permutations(STEP_LENGTHS, 2)}


def literal_problem(
    grid: GridMap,
    *,
    horizon: int,
    weights: Weights = DEFAULT_WEIGHTS,
    modes: Iterable[str | Mode] = ("biped", "crawl", "roll"),
    connectivity: Connectivity = "axis",
) -> Problem:
    """Table IV as close to its print as is solvable: end points only, x_T not counted.

    The signs of (16)-(19) and the missing half of (5) (6) are repaired; "diagonal" is the
    word-for-word reading of (8)-(10), "axis" the one that fits the paper's Table VI.
    """
    return build_problem(
        grid,
        horizon=horizon,
        weights=weights,
        modes=modes,
        connectivity=connectivity,
        count="endpoint",
        check="endpoint",
        count_terminal=False,
    )


def why_no_plan(problem: Problem) -> NoPlan | None:
    """The reason why a problem has no plan, ready to raise; ``None`` if it has one."""
    arcs = build_arcs(problem)
    here = arcs.flat(problem.start)
    T = problem.horizon
    if np.isfinite(dp_bound(problem, arcs)[T, here]):
        return None
    if problem.closed is not None and why_no_plan(replace(problem, closed=None)) is None:
        return NoPlan(
            f"what moves leaves no path of {T} steps from the start"
            f" {_metres(problem, problem.start)}; pass allow_stay=True to wait, early_stop=True,"
            " or another horizon"
        )
    if not problem.must_reach:
        return NoPlan(
            f"no path of {T} steps exists from the start {_metres(problem, problem.start)}:"
            f" the robot is shut in ({shut_in(problem)}); move the start, or pass allow_stay=True"
            " or early_stop=True"
        )
    fewest = int(shortest_steps(problem, arcs)[here])
    if fewest >= UNREACHED:
        return NoPlan(_closed_off(problem))
    if fewest > T:
        return NoPlan(
            f"horizon {T} is too short: the goal {_metres(problem, problem.goal)} takes at"
            f" least {fewest} steps with {', '.join(problem.modes)}, {fewest - T} more; smallest"
            f" horizon is {fewest}",
            smallest_horizon=fewest,
        )
    longer = _next_exact(problem, T)
    hint = "" if longer is None else f" or use horizon {longer}"
    return NoPlan(
        f"no path of exactly {T} steps ends at the goal (the shortest has {fewest});"
        f" pass early_stop=True{hint}",
        smallest_horizon=longer,
    )


def _next_exact(problem: Problem, T: int) -> int | None:
    """The smallest T' in (T, 2 T + 4] with a path of exactly T' steps to the goal."""
    longer = replace(problem, horizon=2 * T + 4, early_stop=False)
    arcs = build_arcs(longer)
    U = dp_bound(longer, arcs)[:, arcs.flat(problem.start)]
    return next((t for t in range(T + 1, len(U)) if np.isfinite(U[t])), None)


def _closed_off(problem: Problem) -> str:
    """Message for a goal that no number of steps reaches."""
    goal, start = (_metres(problem, c) for c in (problem.goal, problem.start))
    modes = ", ".join(problem.modes)
    for extra in STEP_LENGTHS:
        if extra in problem.modes or extra not in problem.weights.P:
            continue
        more = replace(problem, modes=(*problem.modes, extra))
        arcs = build_arcs(more)
        steps = int(shortest_steps(more, arcs)[arcs.flat(problem.start)])
        if steps < UNREACHED:
            return (
                f"{problem.grid.name}: goal {goal} cannot be reached from the start {start} with"
                f" {modes} alone; add mode '{extra}' ({steps} steps)"
            )
    arcs = build_arcs(problem)
    out = steps_from(problem, arcs)
    reached = np.argwhere(out.reshape(-1, arcs.stride) < UNREACHED) - 3
    d2 = ((reached - np.array(problem.goal)) ** 2).sum(axis=1)
    i, j = (int(v) for v in reached[np.argmin(d2)])
    return (
        f"{problem.grid.name}: goal {goal} lies in an area closed off from the start {start};"
        f" {what_separates(problem, arcs)}; nearest cell that can be reached"
        f" {_metres(problem, (i, j))}"
    )


def _metres(problem: Problem, cell: tuple[int, int]) -> str:
    """A cell's centre as text."""
    return _point(problem.grid.center_of(cell)) + " m"


def _point(xy: ArrayLike) -> str:
    x, y = (round(float(v), 3) + 0.0 for v in np.asarray(xy, dtype=float))
    return f"({x:g}, {y:g})"


def _place(
    grid: GridMap, what: str, xy: ArrayLike | None, modes: tuple[Mode, ...]
) -> tuple[int, int]:
    """The cell of a point, or an error that says where the point is and what would do."""
    if xy is None:
        xy = getattr(grid, what)
    if xy is None:
        raise PlanError(f"{grid.name}: the map names no {what}; give one: {what} = x y in metres")
    point = np.asarray(xy, dtype=float)
    if min(grid.shape) == 0:
        nx, ny = grid.shape
        raise MapError(f"{grid.name}: expected a map of at least 1 x 1 cells, got {nx} x {ny}")
    if point.shape != (2,) or not (np.abs(point) < FAR).all():
        raise InvalidInput(f"{what}: expected two finite numbers x y [m], got {point.tolist()}")
    name = f"{grid.name}: {what} {_point(point)} m"
    cell = grid.cell_of(point)
    if not grid.holds(cell):
        nx, ny = grid.shape
        corners = grid.center_of(np.array([(i, j) for i in (0, nx) for j in (0, ny)]) - 0.5)
        (x0, y0), (x1, y1) = corners.min(axis=0), corners.max(axis=0)
        raise MapError(
            f"{name} lies outside the map, which covers x {x0:g} to {x1:g}, y {y0:g} to {y1:g} m"
        )
    i, j = int(cell[0]), int(cell[1])
    usable = ~grid.blocked & (grid.allowed & sum(m.bit for m in modes) > 0)
    if usable[i, j]:
        return i, j
    if not usable.any():
        raise MapError(f"{name}: no cell of the map is free for {', '.join(modes)}")
    why = "lies in an obstacle" if grid.blocked[i, j] else f"is not open to {', '.join(modes)}"
    if not grid.blocked[i, j] and grid.allowed[i, j] == 0:
        why = "allows no mode: regions that force different modes overlap there"
    centers = grid.center_of(np.argwhere(usable))
    near = centers[np.argmin(((centers - point) ** 2).sum(axis=1))]
    raise MapError(f"{name} {why}; nearest free cell centre {_point(near)} m")
