"""Bounds from paths with a short memory, which grows where the best of them cheats.

Let a state forget, on arriving at a cell, every counted cell that this cell does not
remember. What is forgotten pays again, so the best such path bounds every plan; but far fewer
states are told apart, and all of them can be looked at. Where the best path is paid twice for
a cell, every cell it passed in between is made to remember that one, and the search is
repeated (ng-routes with a growing memory). When the best path cheats no more it is an optimal
plan.

Each search asks only for paths above a target just below the bound: few states pass.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mobius.plan.flatspace import ONE, Bits, FlatSpace
from mobius.plan.search import Budget
from mobius.plan.stretches import worth
from mobius.plan.wide import Task, Way, wide_beam

__all__ = ["ShortMemory"]

NEAREST = 13
"""About as many cells are remembered from the beginning: those that the fewest unit steps
lead to. In the open they lie within two steps, in a corridor within six."""

FRACTION = 0.05
"""How far below the bound the target lies, as a part of the gap ..."""

LEAST_STEP = 0.05
"""... and, where the gap allows, at least so many rewards of a cell."""


class ShortMemory:
    """The relaxation of one problem; each :meth:`step` may tighten its bound."""

    def __init__(self, task: Task) -> None:
        self.task = task
        self.memory = _nearby(task.flat)
        """(n, words) cells that each cell remembers."""
        self.stuck = False
        """Whether the last search dropped states that keep the bound where it is."""

    def step(
        self, bound: float, best: float, budget: Budget, width: int
    ) -> tuple[float, Way | None]:
        """Search once with the memory there is, and let it grow.

        Args:
            bound: The best bound known [points].
            best: The best objective known [points].
            budget: What may be spent.
            width: States kept per step.

        Returns:
            A bound no worse than before, and the relaxed path with its value as a plan; no
            path where the search found none above its target.
        """
        tol = self.task.flat.tol
        below = max(FRACTION * (bound - best), LEAST_STEP * self.task.flat.W, 4 * tol)
        target = max(best, bound - below)
        task = replace(self.task, memory=self.memory)
        found, cut = wide_beam(task, width, Way(target), budget)
        if cut == np.inf:
            self.stuck = True
            return bound, None
        bound = max(best, min(bound, max(found.value, cut)))
        self.stuck = cut > -np.inf and bound <= cut
        if not found.cells:
            return bound, None
        self._remember(found)
        return bound, replace(found, value=worth(self.task, found.cells))

    def _remember(self, way: Way) -> None:
        """Let no cell pay twice on this path."""
        flat = self.task.flat
        steps = zip(way.cells, flat.arcs_of(way.cells), strict=False)
        counted = [flat.seen[c, a].tolist() for c, a in steps]
        if self.task.counts_end:
            counted.append([int(flat.bit[way.cells[-1]])])
        when: dict[int, int] = {}
        for t, bits in enumerate(counted):
            for b in bits:
                if b in when and b != flat.none:
                    between = list(way.cells[when[b] + 1 : t + 1])
                    self.memory[between, b >> 6] |= ONE << np.uint64(b & 63)
                when[b] = t


def _nearby(flat: FlatSpace) -> Bits:
    """(n, words) bits of each cell and of the cells nearest to it, ring by ring."""
    stride = flat.space.arcs.stride
    near = {f: (f - stride, f - 1, f + 1, f + stride) for f in flat.paying.tolist()}
    bit = {f: b for b, f in enumerate(near)}
    rows = []
    for f in flat.cells.tolist():
        known, ring = {f}, [f]
        while ring and len(known) < NEAREST:
            ring = sorted({g for c in ring for g in near.get(c, ()) if g in near} - known)
            known.update(ring)
        rows.append(flat.set_of([flat.none, *(bit[g] for g in known if g in bit)]))
    return np.stack(rows)
