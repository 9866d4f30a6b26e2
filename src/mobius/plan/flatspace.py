"""The state space as arrays: what every step from every cell does.

Only cells that a path from the start can reach within the horizon are numbered. A set of cells
is a row of 64-bit words with one bit per cell that pays; one more bit, always set, stands for
every cell that pays nothing.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import fields
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from mobius.plan.problem import Problem
from mobius.plan.search import Link, Space, Successor

__all__ = ["FlatSpace", "treats"]

Bits = NDArray[np.uint64]
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MAX_CELLS = 1024
"""Cells within reach beyond which the arrays are not made: windows get further there."""

PLAIN = frozenset(
    (
        *("grid", "start", "goal", "horizon", "modes", "weights", "connectivity", "count"),
        *("check", "count_terminal", "allow_stay", "must_reach", "early_stop", "cell_cost"),
        *("seen", "closed"),
    )
)
"""Fields of a problem that a :class:`FlatSpace` understands."""

ONE = np.uint64(1)


def treats(problem: Problem) -> bool:
    """Whether :class:`FlatSpace` understands the problem: other options are at their default."""
    others = (f for f in fields(problem) if f.name not in PLAIN)
    return all(getattr(problem, f.name) == f.default for f in others)


def _members(bits: int) -> Iterator[int]:
    """Positions of the bits that are set, in order."""
    while bits:
        low = bits & -bits
        yield low.bit_length() - 1
        bits ^= low


class FlatSpace:
    """n cells, at most A steps from each, at most S cells counted by a step."""

    def __init__(self, space: Space, cells: list[int]) -> None:
        self.space = space
        self.W, self.T, self.tol = space.W, space.T, space.tol
        self.cells = np.array(cells, dtype=np.int64)
        """(n,) flat index of each cell in the frame of :class:`mobius.plan.bounds.Arcs`."""
        number = {f: c for c, f in enumerate(cells)}
        steps = [[s for s in space.successors(f) if s[1] in number] for f in cells]
        counted = 0
        for f, row in zip(cells, steps, strict=True):
            counted |= 1 << f
            for _, _, seen, *_ in row:
                counted |= seen
        paying = [f for f in _members(counted) if space.arcs.pays[f]]
        bit = {f: b for b, f in enumerate(paying)}
        self.none = len(paying)
        """The bit of all cells that pay nothing; bits below it belong to one cell each."""
        self.words = self.none // 64 + 1
        """64-bit words per set."""
        self.paying = np.array(paying, dtype=np.int64)
        """(none,) flat index of the cell of each bit."""
        self.bit = np.array([bit.get(f, self.none) for f in cells], dtype=np.int64)
        """(n,) the bit of each cell."""
        self._fill(number, steps, bit)
        self.end = np.array([space.ended(f, -1, 0.0) for f in cells])
        """(n,) value of ending on a cell that pays nothing any more."""
        self.begin = self.set_of([self.none])
        """(words,) the set a path begins with."""
        self.around = np.stack([self._bits_of(row[row >= 0]) for row in self.to])
        """(n, words) bits of the cells that one step can land on."""
        self.beside, self.walls = self._beside(bit)
        self.touch = [[touch for *_, touch, _ in row] for row in steps]
        self._rows: dict[int, Floats] = {}
        self._open: dict[int, NDArray[np.bool_]] = {}

    @classmethod
    def of(cls, space: Space) -> FlatSpace | None:
        """The arrays of a space, or ``None`` for options or sizes they are not made for."""
        cells = cls._within_reach(space)
        return None if cells is None else cls(space, cells)

    @classmethod
    def fits(cls, space: Space) -> bool:
        """Whether :meth:`of` makes the arrays of a space."""
        return cls._within_reach(space) is not None

    @staticmethod
    def _within_reach(space: Space) -> list[int] | None:
        """The cells that a path can reach, by steps from the start; ``None`` if too many."""
        if not treats(space.problem):
            return None
        cells, new = [space.start], [space.start]
        known = {space.start}
        for _ in range(space.T):
            front, new = new, []
            for f in front:
                for _, to, *_ in space.successors(f):
                    if to not in known:
                        known.add(to)
                        new.append(to)
            cells += new
            if len(cells) > MAX_CELLS:
                return None
        return cells

    def _fill(
        self, number: dict[int, int], steps: list[list[Successor]], bit: dict[int, int]
    ) -> None:
        """The arrays of the steps."""
        n, A = len(steps), max(1, max(len(row) for row in steps))
        seen = [[[bit[f] for f in _members(s[2]) if f in bit] for s in row] for row in steps]
        S = max((len(c) for row in seen for c in row), default=1)
        self.to = np.full((n, A), -1, dtype=np.int64)
        """(n, A) landing, -1 where there is no step."""
        self.action = np.full((n, A), -1, dtype=np.int64)
        """(n, A) index of the action in ``problem.actions``."""
        self.cost = np.zeros((n, A))
        """(n, A) [points]."""
        self.seen = np.full((n, A, max(1, S)), self.none, dtype=np.int64)
        """(n, A, S) bits that the step counts."""
        for c, row in enumerate(steps):
            for a, (action, to, _, cost, _, _) in enumerate(row):
                self.to[c, a], self.action[c, a], self.cost[c, a] = number[to], action, cost
                self.seen[c, a, : len(seen[c][a])] = seen[c][a]

    def set_of(self, bits: list[int]) -> Bits:
        """(words,) a set of bits."""
        made = 0
        for b in bits:
            made |= 1 << b
        return np.frombuffer(made.to_bytes(8 * self.words, "little"), dtype="<u8").astype(np.uint64)

    def holds(self, bits: Bits) -> NDArray[np.bool_]:
        """(none + 1,) whether a set holds each bit."""
        b = np.arange(self.none + 1)
        return (bits[b >> 6] >> (b & 63).astype(np.uint64) & ONE).astype(bool)

    def arcs_of(self, cells: Sequence[int]) -> list[int]:
        """Index of the step from each cell of a path to the next (there is never but one)."""
        return [int(np.argmax(self.to[a] == b)) for a, b in pairwise(cells)]

    def _bits_of(self, cells: Ints) -> Bits:
        """(words,) the bits of some cells, those that pay nothing left out."""
        return self.set_of([b for b in self.bit[cells].tolist() if b != self.none])

    def row(self, k: int) -> Floats:
        """(n,) the bound table with k steps to go."""
        if k not in self._rows:
            self._rows[k] = np.array(self.space.row(k))[self.cells]
        return self._rows[k]

    def legal(self, k: int) -> NDArray[np.bool_]:
        """(n, A) steps that may be made with k steps to go."""
        closed = self.space._closed[k]
        if closed not in self._open:
            made = self.to >= 0
            for c, row in enumerate(self.touch if closed else []):
                for a, touch in enumerate(row):
                    made[c, a] &= not touch & closed
            self._open[closed] = made
        return self._open[closed]

    def _beside(self, bit: dict[int, int]) -> tuple[Bits, Ints]:
        """(none + 1, words) bits of the four cells around each; (none + 1,) how many are not."""
        stride = self.space.arcs.stride
        sets = np.zeros((self.none + 1, self.words), dtype=np.uint64)
        walls = np.zeros(self.none + 1, dtype=np.int64)
        for b, f in enumerate(self.paying.tolist()):
            near = [bit[g] for g in (f - stride, f - 1, f + 1, f + stride) if g in bit]
            sets[b], walls[b] = self.set_of(near), 4 - len(near)
        return sets, walls

    def table(self, pay: Floats, stop: Floats, steps: int, later: int, *, early: bool) -> Floats:
        """(steps + 1, n) the most that k more steps earn if bit b pays ``pay[b]`` every visit.

        Args:
            pay: (none + 1,) points per visit of each bit's cell.
            stop: (n,) value of ending on a cell.
            steps: Largest k.
            later: Steps that follow, for what is closed when.
            early: Whether the path may end with steps to go.
        """
        gain = pay[self.seen].sum(axis=2) - self.cost
        V = np.empty((steps + 1, len(self.cells)))
        V[0] = stop
        for k in range(1, steps + 1):
            legal = self.legal(k + later)
            V[k] = np.where(legal, gain + V[k - 1][self.to], -np.inf).max(axis=1)
            if early:
                np.maximum(V[k], stop, out=V[k])
        return V

    def within(self) -> Bits:
        """(T + 1, n, words) bits of the cells that k more steps can count."""
        n, A, _ = self.seen.shape
        step = np.zeros((n, A, self.words), dtype=np.uint64)
        rows = np.ix_(range(n), range(A))
        for s in range(self.seen.shape[2]):
            bits = self.seen[:, :, s]
            step[rows[0], rows[1], bits >> 6] |= ONE << (bits & 63).astype(np.uint64)
        reach = np.zeros((self.T + 1, n, self.words), dtype=np.uint64)
        if self.space.problem.count_terminal:
            for c in range(n):
                reach[0, c] = self.set_of([int(self.bit[c])])
        for k in range(1, self.T + 1):
            after = step | reach[k - 1][self.to]
            after[~self.legal(k)] = 0
            reach[k] = np.bitwise_or.reduce(after, axis=1)
            reach[k] |= reach[0]
        return reach & ~self.begin

    def numbers(self, flat: Sequence[int]) -> list[int]:
        """The numbers of flat cells."""
        number = {f: c for c, f in enumerate(self.cells.tolist())}
        return [number[f] for f in flat]

    def link(self, cells: Sequence[int], actions: Sequence[int]) -> Link:
        """A path of numbered cells, as the search keeps it."""
        flat = self.cells[list(cells)].tolist()
        link: Link = (None, flat[0], -1)
        for f, a in zip(flat[1:], actions, strict=True):
            link = (link, f, a)
        return link
