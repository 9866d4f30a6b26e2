"""Which cells go so that no straight line comes too close, and no lane must be turned in."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Cell = tuple[int, int]


def keep_lanes(blocked: Mask, narrow: Mask, value: Array) -> None:
    """Block narrow cells (in place) until those left can only be passed straight.

    Of neighbours that fail, the one with less clearance goes first (then the smaller index).
    """
    if not (narrow & ~blocked).any():
        return
    rank = np.empty(value.shape)
    rank.flat[np.argsort(value, axis=None, kind="stable")] = np.arange(value.size)
    plus = ndimage.generate_binary_structure(2, 1)
    while True:
        free = np.pad(~blocked, 1)
        along_x = free[:-2, 1:-1].astype(int) + free[2:, 1:-1]
        along_y = free[1:-1, :-2].astype(int) + free[1:-1, 2:]
        straight = (along_x - along_y == 2) | (along_y - along_x == 2)
        fails = narrow & ~blocked & ~straight
        if not fails.any():
            return
        order = np.where(fails, rank, np.inf)
        first = ndimage.minimum_filter(order, footprint=plus, mode="constant", cval=np.inf)
        blocked |= fails & (order == first)


def cut(blocked: Mask, bad_x: Mask, bad_y: Mask, value: Array) -> None:
    """Block cells (in place) until no bad line joins two free neighbours.

    ``bad_x`` (nx-1, ny) marks lines from (i, j) to (i+1, j), ``bad_y`` (nx, ny-1) to (i, j+1).
    """
    free = ~blocked
    lines: dict[Cell, set[Cell]] = {}
    for bad, step in (
        (bad_x & free[:-1] & free[1:], (1, 0)),
        (bad_y & free[:, :-1] & free[:, 1:], (0, 1)),
    ):
        for i, j in np.argwhere(bad).tolist():
            a, b = (i, j), (i + step[0], j + step[1])
            lines.setdefault(a, set()).add(b)
            lines.setdefault(b, set()).add(a)
    while lines:
        worst = max(lines, key=lambda cell: (len(lines[cell]), -value[cell], cell))
        blocked[worst] = True
        for other in lines.pop(worst):
            lines[other].discard(worst)
            if not lines[other]:
                del lines[other]
