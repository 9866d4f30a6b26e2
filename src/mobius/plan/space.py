"""The state space of the search: steps, scores and completion bounds.

A state is (cell, set of counted cells, score so far), and with switch costs the mode of the
last step; sets are Python integers, one bit per cell, so union and difference are single
operations.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mobius.plan.bounds import (
    Arcs,
    closed_cells,
    coverable_cells,
    dp_bound,
    mode_bounds,
    terminal_value,
)
from mobius.plan.problem import Problem
from mobius.plan.steps import Steps
from mobius.plan.steps import Successor as Successor
from mobius.types import Mode

__all__ = ["Space", "Successor"]


class Space:
    """The state space of a problem: successors, scores and completion bounds."""

    def __init__(
        self,
        problem: Problem,
        arcs: Arcs,
        U: NDArray[np.float64],
        *,
        end: NDArray[np.float64] | None = None,
    ) -> None:
        """``end`` (N,) replaces the value of ending on a cell, without its own reward."""
        self.problem, self.arcs = problem, arcs
        self.W = problem.weights.W_exp
        self.T = problem.horizon
        self.start = arcs.flat(problem.start)
        self.root = float(U[self.T, self.start])
        self.table = U
        """(T + 1, N) the bound table it was made with."""
        self._tables = U[np.newaxis]
        """(M, T + 1, N) bounds per mode of the last step; M is 1 where it does not matter."""
        self._rows: list[list[list[float] | None]] = [[None] * (self.T + 1)]
        steps = [a.d for a in problem.actions]
        self.heading = [math.atan2(dy, dx) for dx, dy in steps]
        """Direction of each action [rad]."""
        self.length = [math.hypot(dx, dy) for dx, dy in steps]
        """Length of each action [cells]."""
        self._end: list[float] = (terminal_value(problem, arcs) if end is None else end).tolist()
        self._pays: list[bool] = arcs.pays.tolist()
        self._closed = [self._bits(closed_cells(problem, arcs, k)) for k in range(self.T + 1)]
        self.before = self._bits(arcs.free & ~arcs.pays)
        """Bits of the cells that were seen before the plan."""
        self.mode_of = [0] * (len(steps) + 1)
        """Number of each action's mode in ``problem.modes``, at -1 that before the first step;
        all 0 where changes of mode are free."""
        self._extra: list[list[float]] | None = None
        self._look: dict[int, int] | None = None
        if problem.switch_cost is not None:
            self._price_switches()
        if arcs.sight is not None:
            self._look_round()
        steps_by_cell = Steps(
            arcs,
            self.mode_of,
            self.W,
            None if arcs.sight is None else self.look,
            swept=problem.check == "swept",
            moving=any(self._closed),
        )
        self.successors = steps_by_cell.of
        """Steps from a cell; of steps alike in all but cost only the cheapest."""
        self.neighbours = steps_by_cell.landings
        """Bits of the cells one step from a cell can land on."""
        self.tol = 1e-9 * max(1.0, abs(self.root))

    def _price_switches(self) -> None:
        """Make the mode of the last step part of the state."""
        p = self.problem
        self._tables, self.root = mode_bounds(p, self.arcs)
        self._rows = [[None] * (self.T + 1) for _ in p.modes]
        self.mode_of = [*(p.modes.index(a.mode) for a in p.actions), len(p.modes)]
        self._extra = [
            [p.switch_points(before, action.mode) for action in p.actions]
            for before in (*p.modes, p.last_mode)
        ]

    def _look_round(self) -> None:
        """Let places see their footprint, and cap the reward by what is left to see."""
        p, self._look = self.problem, {}
        self._paying = self._bits(self.arcs.pays)
        self._coverable = self._bits(coverable_cells(p, self.arcs))
        self._rest = dp_bound(replace(p, count_terminal=False), self.arcs, W_exp=0.0)
        self._rest_rows: dict[int, list[float]] = {}
        rest = float(self._rest[self.T, self.start])
        self.root = min(self.root, rest + self.W * self._coverable.bit_count())

    def row(self, k: int, mode: int = 0) -> list[float]:
        """Bound table with k steps to go, per flat cell, as Python floats.

        Args:
            k: Steps to go.
            mode: :attr:`mode_of` the last step.
        """
        row = self._rows[mode][k]
        if row is None:
            row = self._rows[mode][k] = self._tables[mode][k].tolist()
        return row

    def rows(self, k: int) -> list[list[float]]:
        """:meth:`row` of every mode that matters."""
        return [self._rows[m][k] or self.row(k, m) for m in range(len(self._rows))]

    def extra(self, last: int) -> list[float] | None:
        """Points that each action costs on top after the action ``last`` (-1: at the start)."""
        return None if self._extra is None else self._extra[self.mode_of[last]]

    def look(self, cell: int) -> int:
        """Bits of the cells seen from a cell."""
        if self._look is None or self.arcs.sight is None:
            return 1 << cell
        bits = self._look.get(cell)
        if bits is None:
            bits = 0
            for o, mask in self.arcs.sight.masks.items():
                if mask[cell]:
                    bits |= 1 << (cell + o)
            self._look[cell] = bits
        return bits

    @staticmethod
    def _bits(cells: NDArray[np.bool_] | None) -> int:
        if cells is None:
            return 0
        packed = np.packbits(cells, bitorder="little")
        return int.from_bytes(packed.tobytes(), "little")

    def open_steps(self, k: int, cell: int) -> list[Successor]:
        """Steps from a cell with k steps to go."""
        closed = self._closed[k]
        steps = self.successors(cell)
        return steps if not closed else [s for s in steps if not s[4] & closed]

    def action(self, cell: int, to: int, mode: Mode) -> int:
        """The action of that mode from a cell to another."""
        return next(
            a
            for a in np.flatnonzero(self.arcs.valid[:, cell]).tolist()
            if cell + self.arcs.offset[a] == to and self.problem.actions[a].mode is mode
        )

    def turns(self, last: int, action: int) -> bool:
        """Whether an action changes the direction of the one before (-1: none before)."""
        return last < 0 or self.heading[last] != self.heading[action]

    def can_stop(self, k: int) -> bool:
        """Whether a path may end with k steps to go."""
        return k == 0 or self.problem.early_stop

    def ended(self, cell: int, visited: int, score: float) -> float:
        """Objective of a path that ends here."""
        score += self._end[cell]
        if not self.problem.count_terminal:
            return score
        if self._look is not None:
            return score + self.W * (self.look(cell) & ~visited).bit_count()
        return score if visited >> cell & 1 else score + self.W

    def completed(self, k: int, cell: int, visited: int, score: float, mode: int = 0) -> float:
        """Bound on the objective of a path that is here with k steps to go.

        Args:
            k: Steps to go.
            cell: Flat cell.
            visited: Bits of the cells counted so far.
            score: Points so far.
            mode: :attr:`mode_of` the last step.
        """
        bound = score + (self._rows[mode][k] or self.row(k, mode))[cell]
        if self._look is not None:
            return self._completed_wide(k, cell, visited, score, bound)
        if (
            visited >> cell & 1
            and self._pays[cell]
            and (self.problem.count_terminal or (k > 0 and not self.problem.early_stop))
        ):
            bound -= self.W  # the table pays for this cell again; it surely will not pay
        return bound

    def _completed_wide(self, k: int, cell: int, visited: int, score: float, bound: float) -> float:
        """The same with a footprint; also at most what is left to see."""
        if self.problem.count_terminal or (k > 0 and not self.problem.early_stop):
            bound -= self.W * (self.look(cell) & visited & self._paying).bit_count()
        rest = self._rest_rows.get(k)
        if rest is None:
            rest = self._rest_rows[k] = self._rest[k].tolist()
        left = (self._coverable & ~visited).bit_count()
        return min(bound, score + rest[cell] + self.W * left)
