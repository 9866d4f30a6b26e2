"""Forward search under the bound table: a greedy path first, then a beam that widens.

A state is (cell, set of counted cells, score so far); sets are Python integers, one bit per
cell, so union and difference are single operations. ``U`` completes a score to a bound.

The order of everything is fixed by the problem, so equal problems give equal paths.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobius.plan.bounds import Arcs, closed_cells, terminal_value
from mobius.plan.problem import Problem
from mobius.types import Mode

__all__ = ["Budget", "Found", "Space", "beam", "greedy"]

Link = tuple["Link | None", int, int]
"""(link of the previous cell, flat cell, action that led here or -1)."""

COMPARED = 32
"""States of one cell that a new one is compared with for dominance."""


class Successor(NamedTuple):
    """One step from a known cell."""

    action: int
    to: int
    seen: int
    """Bits counted by the step: the departure and what lies between."""
    cost: float
    touch: int
    """Bits of the cells that must be open while the step is made."""


class Found(NamedTuple):
    """The best path so far."""

    value: float
    link: Link | None


class Budget:
    """How much may still be spent: states (the same everywhere) and time (a safety net)."""

    def __init__(self, states: int, deadline_s: float | None) -> None:
        self.left = states
        self._end = None if deadline_s is None else time.perf_counter() + deadline_s

    def spend(self, states: int) -> bool:
        """Take some states off; whether anything is left."""
        self.left -= states
        return self.left > 0 and (self._end is None or time.perf_counter() < self._end)


class Space:
    """The state space of a problem: successors, scores and completion bounds."""

    def __init__(self, problem: Problem, arcs: Arcs, U: NDArray[np.float64]) -> None:
        self.problem, self.arcs = problem, arcs
        self.W = problem.weights.W_exp
        self.T = problem.horizon
        self.start = arcs.flat(problem.start)
        self.root = float(U[self.T, self.start])
        self.tol = 1e-9 * max(1.0, abs(self.root))
        self._U = U
        self._rows: dict[int, list[float]] = {}
        steps = [a.d for a in problem.actions]
        self.heading = [math.atan2(dy, dx) for dx, dy in steps]
        """Direction of each action [rad]."""
        self.length = [math.hypot(dx, dy) for dx, dy in steps]
        """Length of each action [cells]."""
        self._end: list[float] = terminal_value(problem, arcs).tolist()
        self._next: dict[int, tuple[Successor, ...]] = {}
        self._around: dict[int, int] = {}
        self._pays: list[bool] = arcs.pays.tolist()
        self._closed = [self._bits(closed_cells(problem, arcs, k)) for k in range(self.T + 1)]
        self.before = self._bits(arcs.free & ~arcs.pays)
        """Bits of the cells that were seen before the plan."""

    def row(self, k: int) -> list[float]:
        """Bound table with k steps to go, per flat cell, as Python floats."""
        if k not in self._rows:
            self._rows[k] = self._U[k].tolist()
        return self._rows[k]

    @staticmethod
    def _bits(cells: NDArray[np.bool_] | None) -> int:
        if cells is None:
            return 0
        packed = np.packbits(cells, bitorder="little")
        return int.from_bytes(packed.tobytes(), "little")

    def open_steps(self, k: int, cell: int) -> Iterable[Successor]:
        """Steps from a cell with k steps to go."""
        closed = self._closed[k]
        steps = self.successors(cell)
        return steps if not closed else [s for s in steps if not s.touch & closed]

    def successors(self, cell: int) -> tuple[Successor, ...]:
        """Steps from a cell; of steps alike in all but cost only the cheapest."""
        if cell not in self._next:
            arcs, best = self.arcs, dict[tuple[int, int], Successor]()
            for a in np.flatnonzero(arcs.valid[:, cell]).tolist():
                seen = 1 << cell
                for o in arcs.seen[a]:
                    if arcs.free[cell + o]:
                        seen |= 1 << (cell + o)
                touch = 0
                for o in arcs.touch[a]:
                    touch |= 1 << (cell + o)
                step = Successor(a, cell + arcs.offset[a], seen, float(arcs.cost[a, cell]), touch)
                old = best.get((step.to, seen))
                if old is None or step.cost < old.cost:
                    best[step.to, seen] = step
            self._next[cell] = tuple(best.values())
        return self._next[cell]

    def action(self, cell: int, to: int, mode: Mode) -> int:
        """The action of that mode from a cell to another."""
        return next(
            a
            for a in np.flatnonzero(self.arcs.valid[:, cell]).tolist()
            if cell + self.arcs.offset[a] == to and self.problem.actions[a].mode is mode
        )

    def neighbours(self, cell: int) -> int:
        """Bits of the cells one step can land on."""
        if cell not in self._around:
            bits = 0
            for step in self.successors(cell):
                bits |= 1 << step.to
            self._around[cell] = bits
        return self._around[cell]

    def turns(self, last: int, action: int) -> bool:
        """Whether an action changes the direction of the one before (-1: none before)."""
        return last < 0 or self.heading[last] != self.heading[action]

    def can_stop(self, k: int) -> bool:
        """Whether a path may end with k steps to go."""
        return k == 0 or self.problem.early_stop

    def ended(self, cell: int, visited: int, score: float) -> float:
        """Objective of a path that ends here."""
        new = self.problem.count_terminal and not visited >> cell & 1
        return score + self._end[cell] + (self.W if new else 0.0)

    def completed(self, k: int, cell: int, visited: int, score: float) -> float:
        """Bound on the objective of a path that is here with k steps to go."""
        bound = score + self.row(k)[cell]
        if (
            visited >> cell & 1
            and self._pays[cell]
            and (self.problem.count_terminal or (k > 0 and not self.problem.early_stop))
        ):
            bound -= self.W  # the table pays for this cell again; it surely will not pay
        return bound


def path_of(link: Link | None) -> tuple[list[int], list[int]]:
    """Flat cells and actions of a linked path, from the start on."""
    cells: list[int] = []
    actions: list[int] = []
    while link is not None:
        link, cell, action = link
        cells.append(cell)
        actions.append(action)
    return cells[::-1], actions[::-1][1:]


def greedy(space: Space, budget: Budget) -> Found:
    """A path that attains the bound at the root, by depth-first search along tight steps.

    Of several tight steps those that go straight on are tried first, then the shorter ones.
    Gives up (value -inf) when the budget is spent or no such path exists.
    """
    aim = space.root - space.tol
    completed = space.completed

    def tight(k: int, cell: int, visited: int, score: float, last: int) -> Iterator[tuple]:
        fits = []
        for step in space.open_steps(k, cell):
            now = visited | step.seen
            value = score + space.W * (now ^ visited).bit_count() - step.cost
            if completed(k - 1, step.to, now, value) >= aim:
                fits.append((step, now, value))
        fits.sort(key=lambda f: (space.turns(last, f[0].action), space.length[f[0].action]))
        return iter([(step.to, now, value, step.action) for step, now, value in fits])

    link: Link = (None, space.start, -1)
    begin = space.before
    if space.can_stop(space.T) and space.ended(space.start, begin, 0.0) >= aim:
        return Found(space.ended(space.start, begin, 0.0), link)
    stack = [(link, tight(space.T, space.start, begin, 0.0, -1))] if space.T else []
    while stack and budget.spend(1):
        link, choices = stack[-1]
        choice = next(choices, None)
        if choice is None:
            stack.pop()
            continue
        cell, visited, value, action = choice
        link = (link, cell, action)
        k = space.T - len(stack)
        if space.can_stop(k):
            end = space.ended(cell, visited, value)
            if end >= aim:
                return Found(end, link)
        if k > 0:
            stack.append((link, tight(k, cell, visited, value, action)))
    return Found(-np.inf, None)


State = tuple[float, int, int, float, int, int, Link]
"""(-bound, open cells around, new action 0/1, -score, cell, visited, link); smaller is better."""


def beam(space: Space, width: int, best: Found, budget: Budget) -> tuple[Found, float]:
    """One beam pass of the given width.

    Returns:
        The best path known, and a bound on every plan that the pass did not look at: -inf
        when nothing was cut off for width, +inf when the budget ran out.
    """
    cut = -np.inf
    link: Link = (None, space.start, -1)
    layer: list[State] = [(-space.root, 0, 0, 0.0, space.start, space.before, link)]
    for k in range(space.T, -1, -1):
        if space.can_stop(k):
            for _, _, _, minus_score, cell, visited, link in layer:
                value = space.ended(cell, visited, -minus_score)
                if value > best.value + space.tol:
                    best = Found(value, link)
        if k == 0:
            break
        pool: dict[tuple[int, int], State] = {}
        for state in layer:
            made = _expand(space, k, state, best.value + space.tol, pool)
            if not budget.spend(made + 1):
                return best, np.inf
        layer, dropped = _select(space, pool, width)
        cut = max(cut, dropped)
        if not layer:
            break
    return best, cut


def _expand(
    space: Space, k: int, state: State, beat: float, pool: dict[tuple[int, int], State]
) -> int:
    """Put the successors that may still beat ``beat`` into the pool; how many there were."""
    _, _, _, minus_score, cell, visited, link = state
    row, W, last = space.row(k - 1), space.W, link[2]
    completed: Callable[..., float] = space.completed
    steps = space.open_steps(k, cell)
    made = 0
    for action, to, seen, cost, _ in steps:
        made += 1
        if row[to] == -np.inf:
            continue
        now = visited | seen
        score = -minus_score + W * (now ^ visited).bit_count() - cost
        bound = completed(k - 1, to, now, score)
        if bound <= beat:
            continue
        old = pool.get((to, now))
        if old is None or score > -old[3]:
            around = (space.neighbours(to) & ~now).bit_count()
            changed = int(action != last)
            pool[to, now] = (-bound, around, changed, -score, to, now, (link, to, action))
    return made


def _select(
    space: Space, pool: dict[tuple[int, int], State], width: int
) -> tuple[list[State], float]:
    """The best ``width`` states that no other dominates, and the best bound left out.

    A dominates B on the same cell at the same time if score_A - W |visited_A - visited_B|
    >= score_B: whatever B does next, A can do too, and loses at most that reward.
    """
    W, tol = space.W, space.tol
    kept: list[State] = []
    by_cell: dict[int, list[State]] = {}
    for state in sorted(pool.values(), key=lambda s: s[:6]):
        if len(kept) == width:
            return kept, -state[0]
        _, _, _, minus_score, cell, visited, _ = state
        same = by_cell.setdefault(cell, [])
        if any(
            -other[3] - W * (other[5] & ~visited).bit_count() >= -minus_score - tol
            for other in same[:COMPARED]
        ):
            continue
        same.append(state)
        kept.append(state)
    return kept, -np.inf
