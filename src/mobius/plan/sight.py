"""What is seen from a cell: a footprint of cells, less what obstacles hide.

A cell is seen from another where the straight segment between the two centres is clear: it
runs through the inside of no blocked cell (all cells it crosses are tested, a supercover
line), and through no corner where both cells beside it are blocked. So sight is mutual, and
a diagonal wall hides. Blocked cells are those of the map, inflation included: what an
inflated obstacle hides is more than what the obstacle itself hides, never less.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from mobius.errors import InvalidInput
from mobius.plan.actions import line_between

__all__ = ["MAX_RADIUS", "disc", "footprint_of", "sight_masks"]

Offset = tuple[int, int]

MAX_RADIUS = 30
"""Farthest cell of a footprint, per axis [cells]."""


def disc(radius: float) -> tuple[Offset, ...]:
    """Offsets of the cells whose centres lie within ``radius`` [cells] of a cell's centre."""
    if not (math.isfinite(radius) and 0 <= radius <= MAX_RADIUS):
        raise InvalidInput(
            f"footprint: expected a radius of 0 to {MAX_RADIUS} cells, got {radius:g}"
        )
    n = range(-math.floor(radius), math.floor(radius) + 1)
    return tuple((i, j) for i in n for j in n if i * i + j * j <= radius * radius)


def footprint_of(value: float | Iterable[Iterable[int]]) -> tuple[Offset, ...]:
    """A footprint from a radius [cells] or from offsets (di, dj) [cells].

    The own cell (0, 0) always belongs to it. The order is fixed, so that equal sets are equal
    footprints.
    """
    if isinstance(value, (int, float, np.number)):
        return disc(float(value))
    rows = [tuple(row) for row in value]
    for row in rows:
        if len(row) != 2 or any(int(v) != v or abs(v) > MAX_RADIUS for v in row):
            raise InvalidInput(
                f"footprint: expected offsets of two whole cells up to {MAX_RADIUS}, got {row}"
            )
    return tuple(sorted({(0, 0), *((int(i), int(j)) for i, j in rows)}))


def sight_masks(
    blocked: NDArray[np.bool_], offsets: tuple[Offset, ...]
) -> dict[Offset, NDArray[np.bool_]]:
    """Per offset the (nx, ny) free cells from which the cell there is free and in sight."""
    nx, ny = blocked.shape
    pad = max((abs(v) for o in offsets for v in o), default=0)
    wall = np.pad(blocked, pad, constant_values=True)

    def at(o: Offset) -> NDArray[np.bool_]:
        return wall[pad + o[0] : pad + o[0] + nx, pad + o[1] : pad + o[1] + ny]

    masks = {}
    for o in offsets:
        hidden = blocked | at(o)
        crossed, touched = line_between(o)
        for c in crossed:
            hidden |= at(c)
        for one, other in zip(touched[::2], touched[1::2], strict=True):
            hidden |= at(one) & at(other)
        masks[o] = ~hidden
    return masks
