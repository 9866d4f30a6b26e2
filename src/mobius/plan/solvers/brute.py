"""Ground truth for tiny problems: every path there is, each priced by its definition."""

from __future__ import annotations

import time
from collections.abc import Iterator

from mobius.errors import PlanError
from mobius.plan.check import broken_rule, objective_of
from mobius.plan.problem import Problem
from mobius.plan.solvers.common import (
    PROBLEM_FIELDS,
    Cell,
    finished,
    free_cells,
    kinds_of,
    no_plan,
    refuse_unknown,
)
from mobius.types import Mode, Plan

__all__ = ["MAX_PATHS", "brute", "number_of_paths"]

MAX_PATHS = 200_000
"""Paths that are accepted; each takes some 50 microseconds."""

Moves = list[dict[Cell, list[tuple[Cell, Mode]]]]
"""Legal steps from every free cell at step 0, 1, ...; the last ones hold on."""


def brute(problem: Problem, deadline_s: float | None = None) -> Plan:
    """The best of all paths.

    Args:
        problem: A problem of at most :data:`MAX_PATHS` paths.
        deadline_s: Wall time [s], ``None`` for none. Half an enumeration proves nothing, so
            there is no plan when it runs out.

    Raises:
        PlanError: Too many paths, or out of time.
        NoPlan: Not one path obeys the rules.
    """
    refuse_unknown(problem, "brute", PROBLEM_FIELDS | {"closed"})
    began = time.perf_counter()
    moves = _moves(problem)
    paths = _number_of_paths(problem, moves)
    if paths > MAX_PATHS:
        raise PlanError(
            f"solver 'brute' tries every path, at most {MAX_PATHS}; this problem has {paths:.3g}:"
            " shorten the horizon or use the solver 'exact' or 'didp'"
        )
    best: tuple[float, list[Cell], list[Mode]] | None = None
    for cells, modes in _paths(problem, moves):
        if deadline_s is not None and time.perf_counter() - began > deadline_s:
            raise PlanError(
                f"solver 'brute' has not tried all {paths} paths within {deadline_s:g} s; give it"
                " more time or use the solver 'exact'"
            )
        value = objective_of(problem, cells, modes)
        if best is None or value > best[0]:
            best = (value, cells, modes)
    if best is None:
        raise no_plan("brute")
    value, cells, modes = best
    return finished(problem, cells, modes, claimed=value, bound=value, proven=True, began=began)


def number_of_paths(problem: Problem) -> int:
    """How many paths :func:`brute` would price, those that miss the goal included."""
    return _number_of_paths(problem, _moves(problem))


def _moves(problem: Problem) -> Moves:
    """Every legal step from every free cell, as long as something moves by the step."""
    kinds = kinds_of(problem)
    moves: Moves = []
    for t in range(1 if problem.closed is None else len(problem.closed)):
        moves.append({})
        for a in free_cells(problem):
            ends = [((a[0] + dx, a[1] + dy), mode) for mode, dx, dy in kinds]
            moves[t][a] = [(b, m) for b, m in ends if broken_rule(problem, a, b, m, t) is None]
    return moves


def _number_of_paths(problem: Problem, moves: Moves) -> int:
    """Paths of T steps, or of any number up to T with ``early_stop``."""
    here, total = {problem.start: 1}, 1
    for t in range(problem.horizon):
        after: dict[Cell, int] = {}
        for a, n in here.items():
            for b, _mode in moves[min(t, len(moves) - 1)][a]:
                after[b] = after.get(b, 0) + n
        here = after
        total = sum(here.values()) + (total if problem.early_stop else 0)
    return total


def _paths(problem: Problem, moves: Moves) -> Iterator[tuple[list[Cell], list[Mode]]]:
    """Every path that ends where and when it may."""
    stack: list[tuple[list[Cell], list[Mode]]] = [([problem.start], [])]
    while stack:
        cells, modes = stack.pop()
        t = len(modes)
        may_end = t == problem.horizon or problem.early_stop
        if may_end and (cells[-1] == problem.goal or not problem.must_reach):
            yield cells, modes
        if t < problem.horizon:
            steps = moves[min(t, len(moves) - 1)][cells[-1]]
            stack += [([*cells, b], [*modes, mode]) for b, mode in steps]
