"""Forward search under the bound table: a greedy path first, then a beam that widens.

The states are those of :mod:`mobius.plan.space`; its bound table completes a score to a bound.

The order of everything is fixed by the problem, so equal problems give equal paths.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from mobius.errors import InvalidInput
from mobius.plan.space import Space as Space
from mobius.plan.space import Successor as Successor

__all__ = ["Budget", "Found", "Space", "beam", "checked_deadline", "greedy"]

Link = tuple["Link | None", int, int]
"""(link of the previous cell, flat cell, action that led here or -1)."""

COMPARED = 32
"""States of one cell that a new one is compared with for dominance."""


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


def checked_deadline(deadline_s: float | None) -> float | None:
    """A deadline [s] as it was given; ``None`` for one that never comes.

    Raises:
        InvalidInput: It is no time that can be waited for.
    """
    if deadline_s is None:
        return None
    try:
        seconds = float(deadline_s)
    except (TypeError, ValueError):
        seconds = float("nan")
    if not seconds >= 0:
        raise InvalidInput(
            f"deadline_s: expected seconds >= 0, or None for no deadline, got {deadline_s}"
        )
    return seconds if seconds < float("inf") else None


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
    completed, mode_of = space.completed, space.mode_of

    def tight(k: int, cell: int, visited: int, score: float, last: int) -> Iterator[tuple]:
        fits = []
        extra, rows = space.extra(last), space.rows(k - 1)
        for action, to, seen, cost, _, most in space.open_steps(k, cell):
            mode = mode_of[action]
            if score + most + rows[mode][to] < aim:
                continue  # not even if all it sees were new
            now = visited | seen
            value = score + space.W * (now ^ visited).bit_count() - cost
            if extra is not None:
                value -= extra[action]
            if completed(k - 1, to, now, value, mode) >= aim:
                fits.append((to, now, value, action))
        fits.sort(key=lambda f: (space.turns(last, f[3]), space.length[f[3]]))
        return iter(fits)

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

Pool = dict[tuple[int, int, int], State]
"""(cell, visited, number of the mode it came in) -> the best such state."""


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
        pool: Pool = {}
        for state in layer:
            made = _expand(space, k, state, best.value + space.tol, pool)
            if not budget.spend(made + 1):
                return best, np.inf
        layer, dropped = _select(space, pool, width)
        cut = max(cut, dropped)
        if not layer:
            break
    return best, cut


def _expand(space: Space, k: int, state: State, beat: float, pool: Pool) -> int:
    """Put the successors that may still beat ``beat`` into the pool; how many there were."""
    _, _, _, minus_score, cell, visited, link = state
    rows, W, last = space.rows(k - 1), space.W, link[2]
    completed: Callable[..., float] = space.completed
    extra, mode_of = space.extra(last), space.mode_of
    steps = space.open_steps(k, cell)
    made = 0
    for action, to, seen, cost, _, most in steps:
        made += 1
        if rows[mode_of[action]][to] + most - minus_score <= beat:
            continue  # not even if all it sees were new
        now = visited | seen
        score = -minus_score + W * (now ^ visited).bit_count() - cost
        if extra is not None:
            score -= extra[action]
        mode = mode_of[action]
        bound = completed(k - 1, to, now, score, mode)
        if bound <= beat:
            continue
        old = pool.get((to, now, mode))
        if old is None or score > -old[3]:
            around = (space.neighbours(to) & ~now).bit_count()
            changed = int(action != last)
            pool[to, now, mode] = (-bound, around, changed, -score, to, now, (link, to, action))
    return made


def _select(space: Space, pool: Pool, width: int) -> tuple[list[State], float]:
    """The best ``width`` states that no other dominates, and the best bound left out.

    A dominates B on the same cell at the same time, come there in the same mode where changes
    of mode cost, if score_A - W |visited_A - visited_B|
    >= score_B: whatever B does next, A can do too, and loses at most that reward.
    """
    W, tol, mode_of = space.W, space.tol, space.mode_of
    kept: list[State] = []
    by_cell: dict[tuple[int, int], list[State]] = {}
    for state in sorted(pool.values(), key=lambda s: s[:6]):
        if len(kept) == width:
            return kept, -state[0]
        _, _, _, minus_score, cell, visited, link = state
        same = by_cell.setdefault((cell, mode_of[link[2]]), [])
        if any(
            -other[3] - W * (other[5] & ~visited).bit_count() >= -minus_score - tol
            for other in same[:COMPARED]
        ):
            continue
        same.append(state)
        kept.append(state)
    return kept, -np.inf
