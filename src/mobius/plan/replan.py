"""Planning again while the robot moves: what changed goes in, a plan by a deadline comes out.

    planner = Planner(problem, keep_horizon=True)
    plan = planner.plan(deadline_s=0.05)
    planner.update(at=cell, seen=seen, closed=closed)   # what happened meanwhile
    plan = planner.plan(deadline_s=0.05)

The bound table is worked out anew for each plan: at 20 x 20 cells that takes a few
milliseconds. What is kept is the last
plan: its rest, shifted to the present and repaired where it broke, is the incumbent of the
next search, so a plan is there whatever the deadline.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.errors import PlanError
from mobius.plan.check import broken_rule, cells_seen, objective_of
from mobius.plan.problem import NoPlan, Problem
from mobius.plan.solve import MAX_STATES, solve
from mobius.plan.travel import plan_mode
from mobius.types import GridMap, Mode, Plan

__all__ = ["Planner"]

Cell = tuple[int, int]


class Planner:
    """Keeps a problem up to date and plans it again and again.

    The horizon shrinks by the steps made (``keep_horizon=False``), or recedes with the robot.
    """

    def __init__(self, problem: Problem, *, keep_horizon: bool = False) -> None:
        self.problem, self.keep_horizon = problem, keep_horizon
        self._last: Plan | None = None

    def update(
        self,
        *,
        at: ArrayLike | None = None,
        steps: int = 1,
        grid: GridMap | None = None,
        blocked: dict[Cell, bool] | None = None,
        seen: ArrayLike | None = None,
        closed: ArrayLike | None = None,
        mode: str | Mode | None = None,
    ) -> None:
        """Take in what happened since the last plan.

        Args:
            at: (2,) cell where the robot is now; nothing was walked if not given.
            steps: Steps made to get there, >= 0.
            grid: A new map of the same size.
            blocked: Cells of the map that changed: blocked or not.
            seen: (nx, ny) cells seen so far; if not given, those of the old plan's first
                ``steps`` steps are added.
            closed: (K, nx, ny) what moves, from now on; nothing if not given.
            mode: The mode the robot is in now; if not given, that of the last step it made
                along the old plan. It matters where changes of mode cost.

        Raises:
            PlanError: The robot is off the map or in an obstacle.
        """
        old = self.problem
        change: dict[str, Any] = {"closed": None if closed is None else np.asarray(closed, bool)}
        if grid is not None or blocked:
            change["grid"] = _patched(grid or old.grid, blocked or {})
        if at is not None:
            i, j = (int(v) for v in np.asarray(at))
            change["start"] = (i, j)
            if not self.keep_horizon:
                change["horizon"] = max(old.horizon - steps, 0)
            change["seen"] = self._seen(steps) if seen is None else np.asarray(seen, bool)
            if self._last is not None:
                if 0 < steps <= len(self._last.modes):
                    change["last_mode"] = self._last.modes[steps - 1]
                self._last = _rest(self._last, steps)
        elif seen is not None:
            change["seen"] = np.asarray(seen, bool)
        if mode is not None:
            change["last_mode"] = plan_mode(mode)
        self.problem = replace(old, **change)

    def plan(self, deadline_s: float | None = 0.1, *, max_states: int = MAX_STATES) -> Plan:
        """The best plan by the deadline [s] (``None`` or inf: none), with an honest bound.

        Raises:
            NoPlan: There is none; the last plan is forgotten.
            InvalidInput: The deadline is negative or no number; the last plan is kept.
        """
        try:
            self._last = solve(
                self.problem,
                deadline_s=deadline_s,
                max_states=max_states,
                incumbent=self._incumbent(),
            )
        except NoPlan:
            self._last = None
            raise
        return self._last

    def _seen(self, steps: int) -> NDArray[np.bool_]:
        """What was seen before and what the steps made saw; the cell it stands on not yet."""
        problem, seen = self.problem, np.zeros(self.problem.grid.shape, dtype=bool)
        if problem.seen is not None:
            seen |= problem.seen
        if self._last is not None and steps:
            before = replace(problem, seen=None, count_terminal=False)
            path, modes = self._last.cells[: steps + 1], self._last.modes[:steps]
            for c in cells_seen(before, path, modes):
                seen[c] = True
        return seen

    def _incumbent(self) -> Plan | None:
        """The rest of the last plan where it still obeys, made as long as it must be."""
        if self._last is None:
            return None
        p = self.problem
        cells = [(int(i), int(j)) for i, j in self._last.cells]
        modes = list(self._last.modes)
        if not cells or cells[0] != p.start:
            return None
        for t, mode in enumerate(modes):
            if broken_rule(p, cells[t], cells[t + 1], mode, t):
                cells, modes = cells[: t + 1], modes[:t]
                break
        cells, modes = cells[: p.horizon + 1], modes[: p.horizon]
        while len(modes) < p.horizon and not p.early_stop:
            step = _any_step(p, cells[-1], len(modes))
            if step is None:
                return None
            cells.append(step[0])
            modes.append(step[1])
        if p.must_reach and cells[-1] != p.goal:
            return None
        where = np.array(cells, dtype=np.int64)
        value = objective_of(p, where, modes)
        xy = p.grid.center_of(where)
        return Plan(where, tuple(modes), xy, "feasible", value, float("inf"), 0.0)


def _any_step(p: Problem, cell: Cell, t: int) -> tuple[Cell, Mode] | None:
    """A legal step towards the goal, if there is a legal step."""
    fits = []
    for action in p.actions:
        to = (cell[0] + action.d[0], cell[1] + action.d[1])
        if not broken_rule(p, cell, to, action.mode, t):
            far = (to[0] - p.goal[0]) ** 2 + (to[1] - p.goal[1]) ** 2
            fits.append((far, p.weights.P[action.mode], to, action.mode))
    return min(fits)[2:] if fits else None


def _rest(plan: Plan, steps: int) -> Plan | None:
    """The plan without its first steps; ``None`` if it is over."""
    if steps > len(plan.modes):
        return None
    return Plan(
        plan.cells[steps:],
        plan.modes[steps:],
        plan.xy_M[steps:],
        "feasible",
        plan.objective,
        plan.bound,
        plan.solve_s,
    )


def _patched(grid: GridMap, blocked: dict[Cell, bool]) -> GridMap:
    """The map with some cells changed."""
    cells = np.array(grid.blocked)
    for cell, value in blocked.items():
        if not grid.holds(cell):
            raise PlanError(f"cell {cell} is off the grid of {grid.shape} cells")
        cells[cell] = value
    return replace(grid, blocked=cells)
