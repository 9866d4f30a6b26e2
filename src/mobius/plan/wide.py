"""The beam of :mod:`mobius.plan.search` for thousands of states per step, as array operations.

A :class:`Task` says what is searched: the whole problem, or a part of a path while the rest
stays as it is. Nothing depends on how a sort orders equal keys, so equal problems give equal
plans on any machine.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mobius.plan.flatspace import ONE, Bits, FlatSpace, Floats, Ints
from mobius.plan.search import Budget

__all__ = ["Task", "Way", "wide_beam"]

COMPARED = 8
"""States of one cell that a new one is compared with for dominance."""

AROUND = 1e-3
"""Rewards that a bound must differ by to weigh as much as one open cell around."""

PER_STATE = 10
"""States of an array that count as one of the budget, roughly as their times compare."""

MIX = np.uint64(0x9E3779B97F4A7C15)
"""An odd constant (2^64 over the golden ratio) that spreads the bits of a word."""


@dataclass(frozen=True, eq=False)
class Task:
    """A path of ``steps`` steps to be found, and tables that bound what it earns."""

    flat: FlatSpace
    cell: int
    """Numbered cell where it begins."""
    begin: Bits
    """(words,) cells that are counted already, by whatever part of the plan."""
    steps: int
    later: int
    """Steps of the plan that follow and stay as they are."""
    table: Floats
    """(steps + 1, n) bound on what k more steps earn if every visit pays."""
    pay: Floats
    """(none + 1,) what the table pays for a visit of each bit's cell."""
    end: Floats
    """(n,) value of ending on a cell that pays nothing any more."""
    counts_end: bool
    """Whether the last cell counts."""
    stops_early: bool
    rest: Floats | None = None
    """(steps + 1, n) bound on what k more steps earn if no cell pays."""
    reach: Bits | None = None
    """(steps + 1, n, words) cells that k more steps can count."""
    memory: Bits | None = None
    """(n, words) cells that are remembered as counted on arriving at a cell; ``None``: all.
    What is forgotten can earn again, so the search then finds an upper bound."""


@dataclass(frozen=True)
class Way:
    """A path of a task: its value [points], numbered cells and actions."""

    value: float
    cells: tuple[int, ...] = ()
    actions: tuple[int, ...] = ()


@dataclass
class Layer:
    """m states with the same number of steps to go, and how each was reached."""

    cell: Ints
    score: Floats
    sets: Bits
    """(m, words) counted cells."""
    edges: Ints
    """(m,) sides that counted cells share with one another and with walls."""
    last: Ints
    """(m,) the action made last, -1 for none."""
    parent: Ints
    """(m,) row in the layer before."""


@dataclass
class Made:
    """Steps out of a layer that may still lead to something better."""

    n: int
    """Steps looked at, those left out included."""
    parent: Ints
    arc: Ints
    """Flat index into the (n, A) arrays of the flat space."""
    to: Ints
    score: Floats
    bound: Floats


def wide_beam(
    task: Task, width: int, best: Way, budget: Budget, *, compact: float = 0.0
) -> tuple[Way, float]:
    """One beam pass of the given width.

    Args:
        task: What to search.
        width: States kept per step.
        best: The best path known; only better ones are looked for.
        budget: What may be spent.
        compact: Rewards that one more side shared by counted cells and walls is worth when
            states are ranked, >= 0; holes are left less often.

    Returns:
        The best path known, and a bound on every path that the pass did not look at: -inf
        when nothing was cut off for width, +inf when the budget ran out.
    """
    zero = np.zeros(1, dtype=np.int64)
    first = np.array([task.cell], dtype=np.int64)
    layer = Layer(first, np.zeros(1), task.begin[None], zero, zero - 1, zero - 1)
    layers, cut, tol = [layer], -np.inf, task.flat.tol
    for k in range(task.steps, -1, -1):
        if k == 0 or task.stops_early:
            value = task.end[layer.cell] + layer.score + _last_reward(task, layer)
            top = int(np.argmax(value))
            if value[top] > best.value + tol:
                best = _trace(float(value[top]), layers, top)
        if k == 0:
            break
        made = _expand(task, k, layer, best.value + tol)
        if not budget.spend((made.n + len(layer.cell)) // PER_STATE + 1):
            return best, np.inf
        layer, dropped = _select(task, k, layer, made, width, best.value + tol, compact)
        cut = max(cut, dropped)
        if not len(layer.cell):
            break
        layers.append(layer)
    return best, cut


def _has(sets: Bits, rows: Ints, bits: Ints) -> NDArray[np.bool_]:
    """Whether the sets of some rows hold the bits."""
    return (sets[rows, bits >> 6] >> (bits & 63).astype(np.uint64) & ONE).astype(bool)


def _last_reward(task: Task, layer: Layer) -> Floats:
    """(m,) what counting the last cell earns."""
    rows = np.arange(len(layer.cell))
    new = ~_has(layer.sets, rows, task.flat.bit[layer.cell])
    return np.where(new & task.counts_end, task.flat.W, 0.0)


def _expand(task: Task, k: int, layer: Layer, beat: float) -> Made:
    """All steps from a layer whose bound says that they may beat ``beat``."""
    flat = task.flat
    parent, step = np.nonzero(flat.legal(k + task.later)[layer.cell])
    n, S = len(parent), flat.seen.shape[2]
    arc = layer.cell[parent] * flat.to.shape[1] + step
    to = flat.to.ravel()[arc]
    score = layer.score[parent] - flat.cost.ravel()[arc]
    bound = score + task.table[k - 1, to]
    near = np.flatnonzero(bound + flat.W * S > beat)  # a step counts S cells at the most
    parent, arc, to, score, bound = parent[near], arc[near], to[near], score[near], bound[near]
    seen = flat.seen.reshape(-1, S)[arc]
    gain = flat.W * np.count_nonzero(~_has(layer.sets, parent[:, None], seen), axis=1)
    score, bound = score + gain, bound + gain
    if task.counts_end or (k > 1 and not task.stops_early):
        at = flat.bit[to]
        again = _has(layer.sets, parent, at) | (seen == at[:, None]).any(axis=1)
        bound = bound - task.pay[at] * again  # the table pays for this cell again
    good = np.flatnonzero(bound > beat)
    return Made(n, parent[good], arc[good], to[good], score[good], bound[good])


def _select(
    task: Task, k: int, layer: Layer, made: Made, width: int, beat: float, compact: float
) -> tuple[Layer, float]:
    """The best ``width`` states that no other dominates, and the best bound left out.

    States are ranked by the bound of the table alone: what the capacity leaves is the same for
    all that lost nothing yet, and says nothing of which is nearer to a good plan.
    """
    flat, W = task.flat, task.flat.W
    sets, edges = _counted(flat, layer, made)
    if task.memory is not None:
        sets &= task.memory[made.to]
    keep = _distinct(sets, made)
    bound = made.bound
    if task.rest is not None and task.reach is not None:
        left = np.bitwise_count(task.reach[k - 1, made.to] & ~sets).sum(axis=1)
        bound = np.minimum(bound, made.score + W * left + task.rest[k - 1, made.to])
        keep = keep[bound[keep] > beat]
    last = flat.action.ravel()[made.arc[keep]]
    around = np.bitwise_count(flat.around[made.to[keep]] & ~sets[keep]).sum(axis=1)
    changed = last != layer.last[made.parent[keep]]
    rank = made.bound[keep] - W * (AROUND * (around + 0.25 * changed) - compact * edges[keep])
    dropped = -np.inf
    if len(keep) > width:
        limit = -np.partition(-rank, width - 1)[width - 1]
        sure, tied = np.flatnonzero(rank > limit), np.flatnonzero(rank == limit)
        out = np.ones(len(keep), dtype=bool)
        out[sure] = out[tied[: width - len(sure)]] = False
        dropped = float(bound[keep[out]].max())
        keep, last = keep[~out], last[~out]
    alive = _undominated(flat, made.to[keep], made.score[keep], sets[keep])
    keep, last = keep[alive], last[alive]
    return Layer(
        made.to[keep], made.score[keep], sets[keep], edges[keep], last, made.parent[keep]
    ), dropped


def _counted(flat: FlatSpace, layer: Layer, made: Made) -> tuple[Bits, Ints]:
    """Counted cells, and sides shared by them, after each step."""
    sets, edges = layer.sets[made.parent], layer.edges[made.parent]
    rows = np.arange(len(sets))
    seen = flat.seen.reshape(-1, flat.seen.shape[2])[made.arc]
    for bits in seen.T:
        new = ~_has(sets, rows, bits)
        shared = flat.walls[bits] + np.bitwise_count(flat.beside[bits] & sets).sum(axis=1)
        edges = edges + new * shared
        sets[rows, bits >> 6] |= ONE << (bits & 63).astype(np.uint64)
    return sets, edges


def _distinct(sets: Bits, made: Made) -> Ints:
    """Rows of the best state of every (cell, set), in ascending order."""
    key = made.to.astype(np.uint64)
    for word in sets.T:
        key = (key ^ word) * MIX
        key ^= key >> np.uint64(29)
    order = np.lexsort((-made.score, key))
    a, b = order[:-1], order[1:]
    near = np.flatnonzero(key[a] == key[b])
    a, b = a[near], b[near]
    same = (made.to[a] == made.to[b]) & (sets[a] == sets[b]).all(axis=1)
    keep = np.ones(len(order), dtype=bool)
    keep[b[same]] = False
    return np.flatnonzero(keep)


def _undominated(flat: FlatSpace, cell: Ints, score: Floats, sets: Bits) -> Ints:
    """Rows of the states that none of the next better ones on the same cell dominates."""
    order = np.lexsort((-score, cell))
    cell, score, sets = cell[order], score[order], sets[order]
    keep = np.ones(len(order), dtype=bool)
    for s in range(1, min(COMPARED, len(order) - 1) + 1):
        near = np.flatnonzero(cell[s:] == cell[:-s])
        less = np.bitwise_count(sets[near] & ~sets[near + s]).sum(axis=1)
        worse = score[near] - flat.W * less >= score[near + s] - flat.tol
        keep[near[worse] + s] = False
    return np.sort(order[keep])


def _trace(value: float, layers: list[Layer], row: int) -> Way:
    cells, actions = [], []
    for layer in reversed(layers):
        cells.append(int(layer.cell[row]))
        actions.append(int(layer.last[row]))
        row = int(layer.parent[row])
    return Way(value, tuple(cells[::-1]), tuple(actions[::-1][1:]))
