"""The steps that leave each cell, as the search counts them.

What an action sees and touches is worked out once, and moved to a cell by a shift of bits.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import compress

import numpy as np
from numpy.typing import NDArray

from mobius.plan.arcs import PAD, Arcs

__all__ = ["Steps", "Successor"]


Successor = tuple[int, int, int, float, int, float]
"""One step from a known cell:

- number of the action, flat cell it leads to,
- bits counted by it: what the departure and the places crossed see,
- cost [points],
- bits of the cells that must be open while it is made,
- the most it can earn, its cost taken off [points]: what it does if all it sees is new.
"""


class Steps:
    """The steps of a problem by the cell they leave.

    Args:
        arcs: The arcs of the problem.
        mode_of: Number of each action's mode as far as it matters; of steps alike in all but
            cost only the cheapest is kept.
        W: Reward per cell [points].
        look: Bits of the cells seen from a cell; ``None`` where that is the cell itself.
        swept: Whether steps only cross free cells.
        moving: Whether it is asked what steps touch; all zero otherwise.
    """

    def __init__(
        self,
        arcs: Arcs,
        mode_of: Sequence[int],
        W: float,
        look: Callable[[int], int] | None,
        *,
        swept: bool,
        moving: bool,
    ) -> None:
        self._arcs, self._W, self._look, self._swept = arcs, W, look, swept
        self._up = PAD * (arcs.stride + 1)
        """Places that the bits of ``_moved`` lie higher than a cell's own, so that none is
        negative."""
        packed = np.packbits(arcs.free, bitorder="little")
        self._free = int.from_bytes(packed.tobytes(), "little")
        self._moved = [
            (a, o, self._bits((0, *seen)), self._bits(touch if moving else ()), 1 + len(seen))
            for a, (o, seen, touch) in enumerate(
                zip(arcs.offset, arcs.seen, arcs.touch, strict=True)
            )
        ]
        """Per action: its number, offset, bits counted, bits touched, how many are counted."""
        self._landing = [self._bits((o,)) for o in arcs.offset]
        self._kept = _cheapest(arcs, mode_of).T.copy()
        self._made: dict[int, list[Successor]] = {}
        self._around: dict[int, int] = {}

    def of(self, cell: int) -> list[Successor]:
        """Steps from a cell."""
        made = self._made.get(cell)
        if made is None:
            made = self._made[cell] = self._from(cell)
        return made

    def landings(self, cell: int) -> int:
        """Bits of the cells that one step from a cell can land on."""
        around = self._around.get(cell)
        if around is None:
            around = 0
            for bit in compress(self._landing, self._kept[cell].tolist()):
                around |= bit
            around = self._around[cell] = around << (cell - self._up)
        return around

    def _from(self, cell: int) -> list[Successor]:
        up, W, costs = cell - self._up, self._W, self._arcs.cost[:, cell].tolist()
        moved = compress(self._moved, self._kept[cell].tolist())
        if (look := self._look) is not None:
            return [
                (a, cell + o, seen := self._views(look, cell, a), costs[a], touch << up,
                 W * seen.bit_count() - costs[a])
                for a, o, _, touch, _ in moved
            ]  # fmt: skip
        free, swept = self._free, self._swept
        return [
            (a, cell + o, seen << up if swept else seen << up & free, costs[a],
             touch and touch << up, W * n - costs[a])
            for a, o, seen, touch, n in moved
        ]  # fmt: skip

    def _views(self, look: Callable[[int], int], cell: int, action: int) -> int:
        """Bits of the cells in sight of the departure and the places crossed."""
        seen = look(cell)
        for o in self._arcs.seen[action]:
            if self._arcs.free[cell + o]:
                seen |= look(cell + o)
        return seen

    def _bits(self, offsets: tuple[int, ...]) -> int:
        bits = 0
        for o in offsets:
            bits |= 1 << (self._up + o)
        return bits


def _cheapest(arcs: Arcs, mode_of: Sequence[int]) -> NDArray[np.bool_]:
    """(A, N) legal steps without those that another one equals at no higher cost."""
    kept = arcs.valid.copy()
    alike: dict[tuple[int, tuple[int, ...], int], list[int]] = {}
    for b, (offset, seen) in enumerate(zip(arcs.offset, arcs.seen, strict=True)):
        for a in alike.setdefault((offset, seen, mode_of[b]), []):
            both = kept[a] & kept[b]
            dearer = arcs.cost[b] >= arcs.cost[a]
            kept[b] &= ~(both & dearer)
            kept[a] &= ~(both & ~dearer)
        alike[offset, seen, mode_of[b]].append(b)
    return kept
