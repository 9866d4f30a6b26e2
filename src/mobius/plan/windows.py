"""Making a long plan better: search a stretch of it again, keep the rest as it is.

A window is 20 to 40 steps of the plan. What the steps before and after it see is taken as
seen; what is left is a small problem of the same kind from the window's first cell to its
last (or to the plan's end), on a cut-out of the map. Its beam search either finds more than the
window earned or does not. A stretch that earns the same by other cells is taken too: it
moves slack along the plan, to where another window can use it.

Every new plan is judged by the objective's definition in :mod:`mobius.plan.check`, so nothing
is ever made worse.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mobius.plan.bounds import build_arcs, dp_bound
from mobius.plan.check import cells_seen, objective_of
from mobius.plan.problem import Problem
from mobius.plan.search import Budget, Found, Space, beam, path_of
from mobius.types import GridMap, Mode, Plan

__all__ = ["LENGTHS", "Path", "Windows", "improve"]

Cell = tuple[int, int]

LENGTHS = (20, 40)
"""Steps of a window: short ones first, they are cheap."""
WIDTHS = (4, 16, 64)
"""Widths of the beam in a window, each tried over the whole plan before the next."""
MARGIN = 8
"""Cells around a window's old path that its new one may use."""
MAX_STATES = 400_000
"""Default budget in search states, about a second on a laptop core."""


@dataclass(frozen=True)
class Path:
    """A plan while it is being worked on."""

    cells: tuple[Cell, ...]
    modes: tuple[Mode, ...]
    value: float
    """Its objective [points]."""


def improve(
    problem: Problem,
    plan: Plan,
    *,
    deadline_s: float | None = None,
    max_states: int = MAX_STATES,
) -> Plan:
    """Search windows of a plan again until none gives more, the bound is met or time is up.

    Args:
        problem: The problem the plan solves.
        plan: A plan that obeys it, with a valid bound.
        deadline_s: Wall time [s], ``None`` for none. The result is the same on every machine
            unless it cuts the search off.
        max_states: States the search may generate.

    Returns:
        A plan that is at least as good, with the same bound; "optimal" if it meets it.
    """
    began = time.perf_counter()
    tol = 1e-9 * max(1.0, abs(plan.objective))
    path = Path(tuple((int(i), int(j)) for i, j in plan.cells), plan.modes, plan.objective)
    if plan.bound - path.value > tol and path.modes:
        windows = Windows(problem, Budget(max_states, deadline_s))
        new = windows.improve(path, plan.bound - tol)
        path = new if new.value > path.value else path
    cells = np.array(path.cells, dtype=np.int64).reshape(-1, 2)
    proven = plan.bound - path.value <= tol
    return Plan(
        cells=cells,
        modes=path.modes,
        xy_M=problem.grid.center_of(cells),
        status="optimal" if proven else "feasible",
        objective=path.value,
        bound=path.value if proven else plan.bound,
        solve_s=plan.solve_s + time.perf_counter() - began,
    )


class Windows:
    """The windows of one problem, and what may still be spent on them."""

    def __init__(self, problem: Problem, budget: Budget) -> None:
        self.problem, self.budget = problem, budget
        self._underway = replace(problem, count_terminal=False)
        """The problem as it counts a path that goes on."""
        self._sees: dict[tuple[Cell, Cell, Mode], set[Cell]] = {}
        """What each step made so far sees."""
        self._tol = 1e-9 * max(1.0, problem.weights.W_exp * (problem.horizon + 1))
        self._tried: set[tuple] = set()

    def improve(self, path: Path, aim: float) -> Path:
        """Sweep over the plan with wider and wider beams until nothing changes for the better."""
        for width in WIDTHS:
            better = True
            while better and path.value < aim and self.budget.left > 0:
                before = path.value
                for length in LENGTHS:
                    path = self.sweep(path, length, width, aim)
                better = path.value > before
        return path

    def sweep(self, path: Path, length: int, width: int, aim: float) -> Path:
        """Every window of one length, half overlapping, from the plan's start to its end."""
        a = 0
        while a < len(path.modes) and path.value < aim and self.budget.spend(1):
            b = min(a + length, len(path.modes))
            path = self.research(path, a, b, b - a, width) or path
            if b == len(path.modes):
                break
            a += length // 2
        return path

    def research(self, path: Path, a: int, b: int, steps: int, width: int) -> Path | None:
        """The plan with its steps a to b searched anew.

        Args:
            path: The plan.
            a: First step of the window.
            b: One past its last step; the plan's end is free if the problem leaves it free.
            steps: How many steps the new stretch takes.
            width: Of the beam.

        Returns:
            A plan that earns as much or more; ``None`` if none was found.
        """
        key = (a, b, steps, width, hash((path.cells, path.modes)))
        if key in self._tried:
            return None
        self._tried.add(key)
        part, corner = self.part(path, a, b, steps)
        old = objective_of(part, np.array(path.cells[a : b + 1]) - corner, path.modes[a:b])
        found = _search(part, old, width, self.budget)
        if found is None:
            return None
        cells = [(i + corner[0], j + corner[1]) for i, j in found[0]]
        return self.joined(path, a, b, cells, found[1])

    def part(self, path: Path, a: int, b: int, steps: int) -> tuple[Problem, Cell]:
        """The window as a problem on a cut-out of the map, and the cut-out's corner."""
        p = self.problem
        low, high = self._box(path.cells[a : b + 1])
        ends = b == len(path.modes)
        free_end = ends and bool(np.all(low <= p.goal) and np.all(high > p.goal))
        seen = self._seen_beside(path, a, b)
        box = (slice(low[0], high[0]), slice(low[1], high[1]))
        corner = (int(low[0]), int(low[1]))
        grid = GridMap(
            p.grid.name, p.grid.cell, np.zeros(3), p.grid.blocked[box], p.grid.allowed[box]
        )
        part = replace(
            p,
            grid=grid,
            start=_less(path.cells[a], corner),
            goal=_less(p.goal if free_end else path.cells[b], corner),
            horizon=steps,
            must_reach=p.must_reach or not free_end,
            early_stop=p.early_stop and free_end,
            count_terminal=p.count_terminal and ends,
            cell_cost=p.costs[box],
            seen=seen[box],
            closed=None if p.closed is None else p.closed[min(a, len(p.closed) - 1) :, *box],
        )
        return part, corner

    def _seen_beside(self, path: Path, a: int, b: int) -> NDArray[np.bool_]:
        """(nx, ny) cells seen before the plan, by its steps before a and by those from b on."""
        p, T = self.problem, len(path.modes)
        seen = np.zeros(p.grid.shape, bool) if p.seen is None else p.seen.copy()
        for t in (*range(a), *range(b, T)):
            step = (path.cells[t], path.cells[t + 1], path.modes[t])
            if step not in self._sees:
                self._sees[step] = cells_seen(self._underway, step[:2], step[2:])
            for c in self._sees[step]:
                seen[c] = True
        if b < T and p.count_terminal:
            for c in cells_seen(p, path.cells[-1:], ()):
                seen[c] = True
        return seen

    def _box(self, cells: Sequence[Cell]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Lowest and one past the highest cell of the cut-out round some cells.

        A goal that is near is taken in, so that the end can be chosen anew.
        """
        nx, ny = self.problem.grid.shape
        inside = np.array(cells)
        low, high = inside.min(axis=0) - MARGIN, inside.max(axis=0) + MARGIN
        goal = np.array(self.problem.goal)
        if np.all(low - MARGIN <= goal) and np.all(goal <= high + MARGIN):
            low, high = np.minimum(low, goal), np.maximum(high, goal)
        return np.maximum(low, 0), np.minimum(high + 1, (nx, ny))

    def joined(
        self, path: Path, a: int, b: int, cells: Sequence[Cell], modes: Sequence[Mode]
    ) -> Path | None:
        """The plan with another stretch in place of its steps a to b.

        ``None`` if it is no other plan, breaks a rule or earns less.
        """
        whole = (*path.cells[:a], *cells, *path.cells[b + 1 :])
        ways = (*path.modes[:a], *modes, *path.modes[b:])
        if (whole, ways) == (path.cells, path.modes):
            return None
        value = objective_of(self.problem, np.array(whole), ways)
        return Path(whole, ways, value) if value >= path.value - self._tol else None


def _less(cell: Cell, corner: Cell) -> Cell:
    """A cell as the cut-out numbers it."""
    return cell[0] - corner[0], cell[1] - corner[1]


def _search(
    part: Problem, old: float, width: int, budget: Budget
) -> tuple[list[Cell], list[Mode]] | None:
    """A path of the window that earns ``old`` or more, if the beam meets one."""
    arcs = build_arcs(part)
    space = Space(part, arcs, dp_bound(part, arcs))
    if space.root < old - space.tol:
        return None
    found, _ = beam(space, width, Found(old - 2 * space.tol, None), budget)
    if found.link is None:
        return None
    flat, actions = path_of(found.link)
    return [arcs.cell(f) for f in flat], [part.actions[a].mode for a in actions]
