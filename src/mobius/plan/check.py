"""Proof that a plan obeys its problem, without any solver.

Nothing here is shared with the search: legality and objective are worked out again from
the problem's data, cell by cell, in plain Python.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.errors import PlanError
from mobius.plan.problem import Problem
from mobius.types import Mode, Plan

__all__ = ["broken_rule", "cells_seen", "check", "in_sight", "objective_of"]

Cell = tuple[int, int]

_SEEN_FROM: WeakKeyDictionary[Problem, dict[Cell, frozenset[Cell]]] = WeakKeyDictionary()
"""What was worked out once, for as long as the problem lives."""

REL_TOL = 1e-6
"""Relative tolerance on stated objectives and bounds."""


def check(problem: Problem, plan: Plan) -> None:
    """Return if the plan obeys every rule of the problem; else say which it breaks, and where.

    Raises:
        PlanError: The first broken rule, in the order: ends, length, steps, claims.
    """
    cells = [(int(i), int(j)) for i, j in plan.cells]
    _check_ends(problem, plan, cells)
    _check_length(problem, len(plan.modes))
    for t, mode in enumerate(plan.modes):
        broken = broken_rule(problem, cells[t], cells[t + 1], mode, t)
        if broken:
            raise PlanError(f"step {t}: {broken}")
    _check_claims(problem, plan, cells)


def broken_rule(problem: Problem, a: Cell, b: Cell, mode: Mode, t: int = 0) -> str | None:
    """The rule that a single step from cell ``a`` at time ``t`` to ``b`` breaks, or ``None``."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    if mode not in problem.modes:
        return f"mode '{mode}' is not among the problem's modes {', '.join(problem.modes)}"
    if not problem.grid.holds(b):
        return f"cell {b} is off the grid of {problem.grid.shape} cells"
    if problem.grid.blocked[b]:
        return f"lands in an obstacle at cell {b}"
    return (
        _broken_length(problem, dx, dy, mode)
        or _broken_ground(problem, a, b, mode)
        or _broken_meeting(problem, a, b, t)
    )


def _broken_meeting(problem: Problem, a: Cell, b: Cell, t: int) -> str | None:
    """What moves: nothing may be entered that is closed before or after the step."""
    if problem.closed is None:
        return None
    crossed, touched = _between(a, b) if problem.check == "swept" else ([], [])
    for when in (t, t + 1):
        closed = problem.closed[min(when, len(problem.closed) - 1)]
        for c in (*crossed, *touched, b):
            if closed[c]:
                return f"enters cell {c}, which is closed at step {when}"
    return None


def _broken_length(problem: Problem, dx: int, dy: int, mode: Mode) -> str | None:
    """Table IV (8)-(10) and how the axes share a step."""
    if (dx, dy) == (0, 0):
        if not problem.allow_stay:
            return "stays on its cell, but the problem has allow_stay=False"
        return "a roll cannot stay on its cell" if mode is Mode.ROLL else None
    if problem.connectivity == "axis" and dx != 0 and dy != 0:
        return f"moves by ({dx}, {dy}), on both axes, but connectivity is 'axis'"
    if problem.connectivity == "diagonal" and (dx == 0 or dy == 0):
        return f"moves by ({dx}, {dy}), on one axis, but connectivity is 'diagonal'"
    moved = [abs(v) for v in (dx, dy) if v != 0]
    if mode is Mode.BIPED and any(n != 1 for n in moved):
        return f"biped moves exactly 1 cell, got ({dx}, {dy})"
    if mode is Mode.CRAWL and any(n > 2 for n in moved):
        return f"crawl moves 1 or 2 cells, got ({dx}, {dy})"
    if mode is Mode.ROLL and any(n != 3 for n in moved):
        return f"roll moves exactly 3 cells, got ({dx}, {dy})"
    return None


def _broken_ground(problem: Problem, a: Cell, b: Cell, mode: Mode) -> str | None:
    """Table IV (12)-(20): what the ground allows."""
    blocked, allowed = problem.grid.blocked, problem.grid.allowed
    if not allowed[a] & mode.bit:
        return f"cell {a} does not allow leaving in mode '{mode}'"
    if problem.check == "endpoint":
        return None
    crossed, touched = _between(a, b)
    for c in crossed:
        if blocked[c]:
            return f"passes through an obstacle at cell {c}"
        if not allowed[c] & mode.bit:
            return f"passes over cell {c}, which does not allow mode '{mode}'"
    for c in touched:
        if blocked[c]:
            return f"cuts the corner of an obstacle at cell {c}"
        if not allowed[c] & mode.bit:
            return f"cuts the corner of cell {c}, which does not allow mode '{mode}'"
    if not allowed[b] & mode.bit:
        return f"lands on cell {b}, which does not allow mode '{mode}'"
    return None


def _between(a: Cell, b: Cell) -> tuple[list[Cell], list[Cell]]:
    """Cells other than a and b that the straight segment crosses, or touches in a corner.

    A cell centre (i, j) away from ``a`` is |dx j - dy i| / sqrt(dx^2 + dy^2) off the line,
    and half a cell's width across the line is (|dx| + |dy|) / (2 sqrt(dx^2 + dy^2)).
    """
    dx, dy = b[0] - a[0], b[1] - a[1]
    crossed, touched = [], []
    for i in range(min(dx, 0), max(dx, 0) + 1):
        for j in range(min(dy, 0), max(dy, 0) + 1):
            if (i, j) in ((0, 0), (dx, dy)):
                continue
            off, half = 2 * abs(dx * j - dy * i), abs(dx) + abs(dy)
            if off < half:
                crossed.append((a[0] + i, a[1] + j))
            elif off == half:
                touched.append((a[0] + i, a[1] + j))
    return crossed, touched


def cells_seen(problem: Problem, cells: ArrayLike, modes: Sequence[Mode]) -> set[Cell]:
    """The cells that count as seen along a path, those seen before it left out.

    Args:
        problem: Says what counts (``count``, ``count_terminal``, ``footprint``).
        cells: (T+1, 2) cells.
        modes: T modes.
    """
    path = [(int(i), int(j)) for i, j in np.asarray(cells)]
    seen = set(path if problem.count_terminal else path[:-1])
    if problem.count == "sweep":
        for a, b, mode in zip(path[:-1], path[1:], modes, strict=True):
            if mode is not Mode.ROLL:
                seen.update(c for c in _between(a, b)[0] if not problem.grid.blocked[c])
    if problem.footprint is not None:
        seen = {c for place in seen for c in in_sight(problem, place)}
    return seen if problem.seen is None else {c for c in seen if not problem.seen[c]}


def in_sight(problem: Problem, place: Cell) -> frozenset[Cell]:
    """Free cells of the footprint that nothing hides from a free cell."""
    known = _SEEN_FROM.setdefault(problem, {})
    if place not in known:
        blocked = problem.grid.blocked
        offsets = ((0, 0),) if problem.footprint is None else problem.footprint
        cells = ((place[0] + i, place[1] + j) for i, j in offsets)
        known[place] = frozenset(
            c
            for c in cells
            if problem.grid.holds(c) and not blocked[c] and not _hidden(blocked, place, c)
        )
    return known[place]


def _hidden(blocked: NDArray[np.bool_], a: Cell, b: Cell) -> bool:
    """Whether the segment runs through a blocked cell, or a corner between two of them."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    crossed, touched = _between(a, b)
    if any(blocked[c] for c in crossed):
        return True
    walls = [(c[0] - a[0], c[1] - a[1]) for c in touched if blocked[c]]
    return any(
        abs(i - m) == abs(j - n) == 1 and dx * (j + n) == dy * (i + m)  # across one corner
        for i, j in walls
        for m, n in walls
    )


def objective_of(problem: Problem, cells: ArrayLike, modes: Sequence[Mode]) -> float:
    """Objective of a path [points], recomputed from its definition.

    Args:
        problem: The problem with its weights.
        cells: (T+1, 2) cells.
        modes: T modes.
    """
    path = [(int(i), int(j)) for i, j in np.asarray(cells)]
    w, cost = problem.weights, problem.costs
    value = w.W_exp * len(cells_seen(problem, path, modes))
    gx, gy = problem.goal
    value -= w.W_goal * ((path[-1][0] - gx) ** 2 + (path[-1][1] - gy) ** 2)
    before = problem.last_mode
    for a, b, mode in zip(path[:-1], path[1:], modes, strict=True):
        value -= w.P[mode]
        if a != b:
            value -= sum(float(cost[c]) for c in [*_between(a, b)[0], b])
        if w.per_s or w.per_J:
            value -= _price_of_way(problem, a, b, mode)
        if problem.switch_cost is not None and before is not None and mode is not before:
            value -= problem.switch_cost.get((before, mode), 0.0)
        before = mode
    return value


def _price_of_way(problem: Problem, a: Cell, b: Cell, mode: Mode) -> float:
    """Points for the time and the energy of a step; a rest takes the time of one cell."""
    w = problem.weights
    metres = problem.grid.cell * math.hypot(b[0] - a[0], b[1] - a[1])
    points = 0.0
    if w.per_s:
        points += w.per_s * (metres if a != b else problem.grid.cell) / w.travel.m_per_s[mode]
    if w.per_J:
        points += w.per_J * metres * w.travel.J_per_m[mode]
    return points


def _check_ends(problem: Problem, plan: Plan, cells: list[Cell]) -> None:
    if not cells:
        raise PlanError(f"the plan is empty (status '{plan.status}'): there is nothing to follow")
    if cells[0] != problem.start:
        raise PlanError(f"the plan starts at cell {cells[0]}, the problem at {problem.start}")
    if problem.must_reach and cells[-1] != problem.goal:
        raise PlanError(f"the plan ends at cell {cells[-1]}, short of the goal {problem.goal}")


def _check_length(problem: Problem, steps: int) -> None:
    T = problem.horizon
    if steps > T:
        raise PlanError(f"the plan takes {steps} steps, more than the horizon of {T}")
    if steps < T and not problem.early_stop:
        raise PlanError(f"the plan takes {steps} steps, but must take all {T} (early_stop=False)")


def _check_claims(problem: Problem, plan: Plan, cells: list[Cell]) -> None:
    off = np.abs(plan.xy_M - problem.grid.center_of(plan.cells)).max(axis=1)
    if off.max() > REL_TOL * problem.grid.cell:
        t = int(np.argmax(off))
        x, y = plan.xy_M[t]
        raise PlanError(f"xy_M of step {t}, ({x:g}, {y:g}) m, is not the centre of {cells[t]}")
    if plan.status == "infeasible":
        raise PlanError(
            "the plan calls itself infeasible, but it holds a path that obeys the rules"
        )
    if not math.isfinite(plan.objective):
        raise PlanError(f"the objective is not a number: {plan.objective}")
    if math.isnan(plan.bound):
        raise PlanError("the bound is not a number")
    value = objective_of(problem, cells, plan.modes)
    tol = REL_TOL * max(1.0, abs(value))
    if abs(plan.objective - value) > tol:
        raise PlanError(f"the plan claims an objective of {plan.objective:g}, it earns {value:g}")
    if plan.bound < value - tol:
        raise PlanError(f"the bound {plan.bound:g} is below the objective {value:g} it should cap")
    if plan.status == "optimal" and plan.bound > value + tol:
        raise PlanError(
            f"the plan calls itself optimal, but its bound {plan.bound:g} leaves a gap of"
            f" {plan.bound - value:g}"
        )
