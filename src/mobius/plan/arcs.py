"""Every legal step of a problem as flat arrays: where it leads, what it sees and costs.

Cells are numbered row by row in a frame three cells wider on every side, so that a step is
one fixed offset in the flat index and nothing wraps round.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mobius.plan.actions import Action
from mobius.plan.problem import Problem
from mobius.plan.sight import sight_masks
from mobius.types import Mode

__all__ = ["Arcs", "Sight", "build_arcs", "closed_cells", "price_of", "terminal_value"]

Array = NDArray[np.float64]
Offset = tuple[int, int]
PAD = 3
"""Longest step per axis."""


@dataclass(frozen=True, eq=False)
class Sight:
    """What a footprint adds to the arcs. N padded cells, A actions, flat indices."""

    masks: dict[int, NDArray[np.bool_]]
    """Flat offset -> (N,) whether the free cell there is in sight."""
    own: Array
    """(N,) cells that may earn in sight of a cell."""
    again: Array
    """(A, N) cells that may earn in sight of departure or crossed places and of the landing."""


@dataclass(frozen=True, eq=False)
class Arcs:
    """Every legal step of a problem. N padded cells, A actions, flat indices."""

    stride: int
    lo: int
    """First flat index of a free cell; a step from it stays within the frame."""
    hi: int
    """One past the last flat index of a free cell."""
    offset: tuple[int, ...]
    """A flat landing offsets."""
    seen: tuple[tuple[int, ...], ...]
    """A tuples of flat offsets of cells counted between departure and landing."""
    valid: NDArray[np.bool_]
    """(A, N) whether the step is legal from the cell."""
    n_seen: Array
    """(A, N) cells that may earn between departure and landing (a blocked one never does)."""
    cost: Array
    """(A, N) P[mode] plus the cell costs entered [points]."""
    free: NDArray[np.bool_]
    """(N,)."""
    pays: NDArray[np.bool_]
    """(N,) free cells that were not seen before."""
    touch: tuple[tuple[int, ...], ...]
    """A tuples of flat offsets of cells that must be open while the step is made."""
    sight: Sight | None = None
    """Set where the problem has a footprint; ``n_seen`` is then what crossed places see beyond
    the departure's own sight, ``pays`` still one cell each."""

    def flat(self, cell: tuple[int, int]) -> int:
        """Flat index of a cell."""
        return (cell[0] + PAD) * self.stride + cell[1] + PAD

    def cell(self, flat: int) -> tuple[int, int]:
        """Cell of a flat index."""
        return flat // self.stride - PAD, flat % self.stride - PAD


def build_arcs(problem: Problem) -> Arcs:
    """Legality, reward and cost of every action from every cell."""
    grid = problem.grid
    stride = grid.shape[1] + 2 * PAD

    def pad(a: NDArray, fill: float | bool) -> NDArray:
        return np.pad(a, PAD, constant_values=fill).ravel()

    free, pays = pad(~grid.blocked, False), pad(problem.pays, False)
    N = len(free)
    lo, hi = int(np.argmax(free)), N - int(np.argmax(free[::-1]))
    inside = slice(lo, hi)
    allowed = {m: free & pad((grid.allowed & m.bit) > 0, False) for m in problem.modes}
    costs = pad(problem.costs, 0.0)
    costly = bool(costs.any())
    actions = problem.actions
    offset, seen, touch = [], [], []
    valid = np.zeros((len(actions), N), dtype=bool)
    n_seen, cost = np.zeros((len(actions), N)), np.zeros((len(actions), N))
    for a, act in enumerate(actions):
        ok = allowed[act.mode]
        between = [i * stride + j for i, j in act.crossed]
        corners = [i * stride + j for i, j in act.touched]
        to = act.d[0] * stride + act.d[1]
        legal = ok[inside].copy()
        if problem.check == "swept":
            for o in (*between, *corners, to):
                legal &= ok[lo + o : hi + o]
        else:
            legal &= free[lo + to : hi + to]
        counted = between if problem.count == "sweep" and act.mode is not Mode.ROLL else []
        for o in counted:
            n_seen[a, inside] += pays[lo + o : hi + o]
        cost[a] = price_of(problem, act)
        for o in (*between, to) if costly and act.d != (0, 0) else ():
            cost[a, inside] += costs[lo + o : hi + o]
        valid[a, inside] = legal
        offset.append(to)
        seen.append(tuple(counted))
        touch.append((*between, *corners, to) if problem.check == "swept" else (to,))
    arcs = Arcs(
        stride, lo, hi, tuple(offset), tuple(seen), valid, n_seen, cost, free, pays, tuple(touch)
    )
    return arcs if problem.footprint is None else _with_sight(problem, arcs)


def price_of(problem: Problem, action: Action) -> float:
    """P of a step's mode plus its time and energy [points]."""
    w, mode = problem.weights, action.mode
    points = w.P[mode]
    length = problem.grid.cell * float(np.hypot(*action.d))
    if w.per_s:
        points += w.per_s * w.travel.seconds(mode, length or problem.grid.cell)
    if w.per_J:
        points += w.per_J * w.travel.joules(mode, length)
    return points


def _with_sight(problem: Problem, arcs: Arcs) -> Arcs:
    """The arcs with what every place sees."""
    N = len(arcs.free)

    def pad(a: NDArray[np.bool_]) -> NDArray[np.bool_]:
        return np.pad(a, PAD).ravel()

    masks = sight_masks(problem.grid.blocked, problem.footprint or ())
    flat = {o: o[0] * arcs.stride + o[1] for o in masks}
    view = {o: pad(mask) for o, mask in masks.items()}
    nothing = np.zeros(N, dtype=bool)

    def sees(place: Offset, cell: Offset) -> NDArray[np.bool_]:
        """(N,) whether ``cell`` is in sight of ``place``, both relative to a departure."""
        mask = view.get((cell[0] - place[0], cell[1] - place[1]))
        if mask is None:
            return nothing
        return np.roll(mask, -(place[0] * arcs.stride + place[1]))

    def earns(cell: Offset) -> NDArray[np.bool_]:
        return np.roll(arcs.pays, -(cell[0] * arcs.stride + cell[1]))

    own = np.zeros(N)
    for o, mask in view.items():
        own += mask & earns(o)
    n_seen, again = np.zeros(arcs.valid.shape), np.zeros(arcs.valid.shape)
    for a, action in enumerate(problem.actions):
        places = [(0, 0), *(action.crossed if arcs.seen[a] else ())]
        cells = {(p[0] + o[0], p[1] + o[1]) for p in places for o in view}
        for c in sorted(cells):
            now = nothing.copy()
            for place in places:
                now |= sees(place, c)
            now &= earns(c)
            n_seen[a] += now
            again[a] += now & sees(action.d, c)
        n_seen[a] -= own
    sight = Sight({flat[o]: view[o] for o in view}, own, again)
    return replace(arcs, n_seen=n_seen, sight=sight)


def closed_cells(problem: Problem, arcs: Arcs, k: int) -> NDArray[np.bool_] | None:
    """(N,) cells that the step with ``k`` steps to go may not enter, or ``None``."""
    occupied = problem.closed_between(problem.horizon - k)
    return None if occupied is None else np.pad(occupied, PAD).ravel()


def terminal_value(problem: Problem, arcs: Arcs) -> Array:
    """(N,) value of ending on a cell, without its own reward [points]."""
    nx, ny = problem.grid.shape
    i, j = np.indices((nx + 2 * PAD, ny + 2 * PAD)) - PAD
    d2 = (i - problem.goal[0]) ** 2 + (j - problem.goal[1]) ** 2
    value = -problem.weights.W_goal * d2.ravel().astype(float)
    if problem.must_reach:
        value[d2.ravel() > 0] = -np.inf
    value[~arcs.free] = -np.inf
    return value
