"""What every independent solver needs: a problem's steps, and a checked plan at the end.

Nothing here comes from the search or its bounds: the steps are asked of the checker, cell by
cell, so that a wrong step there cannot be wrong here in the same way.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import MISSING, dataclass, fields, replace
from typing import Any

import numpy as np

from mobius.errors import PlanError
from mobius.plan.check import broken_rule, cells_seen, check, objective_of
from mobius.plan.problem import NoPlan, Problem
from mobius.types import ALL_MODES_BITS, GridMap, Mode, Plan

__all__ = [
    "Cell",
    "Kind",
    "Step",
    "finished",
    "free_cells",
    "kinds_of",
    "looks_of",
    "no_plan",
    "refuse_unknown",
    "steps_of",
]

Cell = tuple[int, int]
Kind = tuple[Mode, int, int]
"""Mode, dx, dy [cells]."""

REACH = 3
"""Longest step per axis [cells]."""

PROBLEM_FIELDS = {
    "grid", "start", "goal", "horizon", "modes", "weights", "connectivity", "count", "check",
    "count_terminal", "allow_stay", "must_reach", "early_stop", "cell_cost", "switch_cost",
    "last_mode", "footprint", "seen",
}  # fmt: skip
"""Fields of a problem that the solvers here state."""

WEIGHT_FIELDS = {"W_exp", "W_goal", "P", "per_s", "per_J", "travel"}
"""Fields of its weights that they state."""


@dataclass(frozen=True)
class Step:
    """One legal step from a known cell."""

    kind: Kind
    to: Cell
    seen: frozenset[Cell]
    """Cells counted by taking the step: what the departure and the places crossed see."""
    cost: float
    """P of the mode, time, energy and the cell costs entered, no change of mode [points]."""


def refuse_unknown(
    problem: Problem, solver: str, stated: frozenset[str] | set[str] = PROBLEM_FIELDS
) -> None:
    """Raise if the problem uses an option that the solver would leave out without a word."""
    for thing, known in ((problem, stated), (problem.weights, WEIGHT_FIELDS)):
        for field in fields(thing):
            if field.name in known:
                continue
            if not _is_default(field, getattr(thing, field.name)):
                raise PlanError(
                    f"solver '{solver}' cannot state the option {type(thing).__name__}"
                    f".{field.name}; leave it at its default or use the solver 'exact'"
                )


def _is_default(field: Any, value: Any) -> bool:
    """Whether a field holds what it holds when nothing is said."""
    default = field.default if field.default_factory is MISSING else field.default_factory()
    if default is None:
        return value is None or (isinstance(value, np.ndarray) and not value.any())
    return bool(np.array_equal(value, default))


def free_cells(problem: Problem) -> list[Cell]:
    """Every cell that is not blocked, in row order."""
    return [(int(i), int(j)) for i, j in np.argwhere(~problem.grid.blocked)]


def kinds_of(problem: Problem) -> list[Kind]:
    """Every kind of step the problem's modes have, (8)-(10), found by asking the checker."""
    side = 2 * REACH + 1
    free, allowed = np.zeros((side, side), bool), np.full((side, side), ALL_MODES_BITS)
    grid = GridMap("open ground", problem.grid.cell, np.zeros(3), free, allowed)
    middle = (REACH, REACH)
    ground = replace(
        problem,
        grid=grid,
        start=middle,
        goal=middle,
        horizon=1,
        cell_cost=None,
        seen=None,
        closed=None,
    )
    reach = range(-REACH, REACH + 1)
    return [
        (mode, dx, dy)
        for mode in problem.modes
        for dx in reach
        for dy in reach
        if broken_rule(ground, middle, (REACH + dx, REACH + dy), mode) is None
    ]


def steps_of(problem: Problem) -> dict[Cell, list[Step]]:
    """Every legal step from every free cell, with what it earns and costs."""
    kinds = kinds_of(problem)
    weights = replace(problem.weights, W_exp=0.0, W_goal=0.0)
    bare = replace(problem, weights=weights, count_terminal=False, last_mode=None)
    steps: dict[Cell, list[Step]] = {}
    for a in free_cells(problem):
        steps[a] = []
        for mode, dx, dy in kinds:
            b = (a[0] + dx, a[1] + dy)
            if broken_rule(problem, a, b, mode) is None:
                seen = frozenset(cells_seen(bare, [a, b], [mode]))
                cost = -objective_of(bare, [a, b], [mode])
                steps[a].append(Step((mode, dx, dy), b, seen, cost))
    return steps


def looks_of(problem: Problem) -> dict[Cell, frozenset[Cell]]:
    """What counts when a place looks, for every free cell."""
    looking = replace(problem, count_terminal=True)
    return {c: frozenset(cells_seen(looking, [c], [])) for c in free_cells(problem)}


def no_plan(solver: str) -> NoPlan:
    """The error for a problem of which a solver has proven that it has no plan."""
    return NoPlan(
        f"no path obeys every rule of the problem (proven by the solver '{solver}'); the solver"
        " 'exact' says what stands in the way"
    )


def finished(
    problem: Problem,
    cells: Sequence[Cell],
    modes: Sequence[Mode],
    *,
    claimed: float,
    tol: float = 1e-6,
    bound: float,
    proven: bool,
    began: float,
) -> Plan:
    """The plan of a path, checked; its objective is worked out again from its definition.

    Args:
        problem: What was solved.
        cells: (T+1,) cells.
        modes: T modes.
        claimed: The solver's own objective [points].
        tol: How far it may be off, relative.
        bound: The solver's bound [points]; not used where optimality is proven.
        proven: Whether the solver calls the path optimal.
        began: ``time.perf_counter()`` at the start [s].

    Raises:
        PlanError: The path breaks a rule, or earns something else than claimed.
    """
    value = objective_of(problem, cells, modes)
    if abs(claimed - value) > tol * max(1.0, abs(value)):
        raise PlanError(
            f"the solver claims an objective of {claimed:g}, but its path earns {value:g}: it is"
            " not accurate enough on this problem; use the solver 'exact'"
        )
    path = np.array(cells, dtype=np.int64).reshape(-1, 2)
    plan = Plan(
        cells=path,
        modes=tuple(modes),
        xy_M=problem.grid.center_of(path),
        status="optimal" if proven else "feasible",
        objective=value,
        bound=value if proven else max(bound, value),
        solve_s=time.perf_counter() - began,
    )
    check(problem, plan)
    return plan
