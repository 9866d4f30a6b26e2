"""What is done when the easy searches have neither met the bound nor looked at everything.

Rounds of growing width, each of three parts: beams over arrays (:mod:`mobius.plan.wide`) find
plans, windows (:mod:`mobius.plan.stretches`) improve them, and the relaxation with a short
memory (:mod:`mobius.plan.ng`) lowers the bound; its paths, as far as they are worth
something, are improved by windows as well.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from mobius.plan.flatspace import FlatSpace
from mobius.plan.ng import ShortMemory
from mobius.plan.search import Budget
from mobius.plan.stretches import improve, whole_task
from mobius.plan.wide import Way, wide_beam

__all__ = ["Deepening"]

FIRST_WIDTH = 256
"""Width of the beams of the first round; every round's is four times the one before."""

MAX_WORDS = 2**18
"""Words of 64 bits in the sets of one layer; the beams get no wider (some 300 MB in all)."""

FRESH_WIDTH = 1024
"""Up to this width a beam looks for its own best plan, not only for better ones: windows may
get further from there."""

COMPACT = (0.0, 0.1)
"""Weights of compactness that the beams of a round take turns with."""

WINDOWS = ((12, 1 / 2), (18, 1), (25, 1))
"""Steps of a window, and the width of its beam as a part of the round's."""

MAX_WINDOW_WIDTH = 2048
MEMORY_WIDTH = 16
"""Width of the relaxed searches as a multiple of the round's."""

MAX_MEMORY_WIDTH = 65_536
"""Largest width of the relaxed searches."""

SCARCE = 0.1
"""Where the capacity bound is lower than the table's by more than this part, cells are so few
that too many paths with a short memory beat it; nothing is to be learnt from them."""

HINT = 0.15
"""A relaxed path is worth improving if it lacks no more than this part of the best value."""

HINT_WINDOW = (18, 256)
"""Steps and width of the windows on relaxed paths."""

LEAST_WIDTH = 64
"""Beams that the deadline would make narrower than this are left out."""

SAFETY = 0.7
"""Part of the time left that a beam may be expected to take."""

Tell = Callable[[float, float], None]


class Deepening:
    """The state of the search: the best path and the best bound so far.

    Args:
        flat: The space.
        best: The best path known, not empty.
        bound: The best bound known [points].
        budget: What may be spent.
        ends_s: Time on :func:`time.perf_counter` at which to stop, ``None`` for never.
        tell: Called with the objective and the bound after every part of a round.
    """

    def __init__(
        self,
        flat: FlatSpace,
        best: Way,
        bound: float,
        budget: Budget,
        ends_s: float | None = None,
        tell: Tell | None = None,
    ) -> None:
        self.flat, self.best, self.bound, self.budget = flat, best, bound, budget
        self._ends_s, self._tell = ends_s, tell
        self._task = whole_task(flat)
        self._memory = ShortMemory(self._task)
        root = float(self._task.table[flat.T, 0])
        self._scarce = root - bound > SCARCE * abs(root)
        self._rate_s = 0.0
        """Seconds per width of the last beam."""

    def run(self) -> tuple[Way, float]:
        """Search until the bound is met, all was looked at, or the budget is spent."""
        width = FIRST_WIDTH
        while self._open() and width * self.flat.words <= MAX_WORDS:
            before = self.budget.left
            for compact in COMPACT:
                if self._open():
                    self._beam(width, compact)
            self._memorise(
                min(MEMORY_WIDTH * width, MAX_MEMORY_WIDTH), 2 * self.budget.left - before
            )
            width *= 4
        if self._open():
            self._memorise(MAX_MEMORY_WIDTH, 0)
        return self.best, self.bound

    def _open(self) -> bool:
        """Whether there is something left to do, and to spend."""
        return self.bound - self.best.value > self.flat.tol and self.budget.spend(0)

    def _take(self, way: Way) -> None:
        if way.value > self.best.value + self.flat.tol:
            self.best = way
        self.bound = max(self.bound, self.best.value)
        if self._tell is not None:
            self._tell(self.best.value, self.bound)

    def _beam(self, width: int, compact: float) -> None:
        """A beam, no wider than the time left allows, and windows on what it finds."""
        if self._ends_s is not None and self._rate_s > 0:
            left_s = self._ends_s - time.perf_counter()
            width = min(width, int(SAFETY * left_s / self._rate_s))
            if width < LEAST_WIDTH:
                return
        start = Way(-np.inf) if width <= FRESH_WIDTH else self.best
        began = time.perf_counter()
        own, cut = wide_beam(self._task, width, start, self.budget, compact=compact)
        self._rate_s = (time.perf_counter() - began) / width
        self.bound = min(self.bound, max(cut, own.value, self.best.value))
        self._take(own)
        for length, part in WINDOWS:
            if own.cells and self._open():
                window = min(int(width * part), MAX_WINDOW_WIDTH)
                own = improve(self.flat, own, length, window, self.budget)
                self._take(own)

    def _memorise(self, width: int, keep: int) -> None:
        """Tighten the bound until the budget is down to ``keep`` or the width is too small."""
        if self._scarce:
            return
        self._memory.stuck = False
        while not self._memory.stuck and self.budget.left > keep and self._open():
            self.bound, path = self._memory.step(self.bound, self.best.value, self.budget, width)
            if path is None:
                continue
            if path.value < self.best.value and path.value > self.best.value - HINT * abs(
                self.best.value
            ):
                path = improve(self.flat, path, *HINT_WINDOW, self.budget)
            self._take(path)
