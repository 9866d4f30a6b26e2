"""Sets of cells as the shapes of Table IV: discs for ground, rectangles for obstacles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["discs_over", "rectangles_over"]

Cell = tuple[int, int]


def discs_over(cells: NDArray[np.bool_], *, spare: NDArray[np.bool_]) -> list[tuple[Cell, int]]:
    """Discs around cell centres that hold all of a set of cells and no cell outside it.

    Largest first: of all discs the one that holds most cells not held yet. A disc drawn
    around a cell's centre is found again as one disc.

    Args:
        cells: (nx, ny) the set.
        spare: (nx, ny) cells that may lie in a disc or not.

    Returns:
        Centre and squared radius [cells^2] of each.
    """
    inside, outside = np.argwhere(cells), np.argwhere(~cells & ~spare)
    if not len(inside):
        return []
    d2 = _squares(inside, inside)
    limit = np.min(_squares(inside, outside), axis=1, initial=2 * d2.max() + 1)
    held = d2 < limit[:, None]
    radii = np.where(held, d2, 0).max(axis=1)
    left, discs = np.ones(len(inside), dtype=bool), []
    while left.any():
        k = int(np.argmax((held & left).sum(axis=1)))
        discs.append(((int(inside[k, 0]), int(inside[k, 1])), int(radii[k])))
        left &= ~held[k]
    return discs


def _squares(a: NDArray[np.int64], b: NDArray[np.int64]) -> NDArray[np.int64]:
    """(len(a), len(b)) squared distances."""
    return ((a[:, None, :] - b[None, :, :]) ** 2).sum(axis=2)


def rectangles_over(cells: NDArray[np.bool_]) -> list[tuple[Cell, Cell]]:
    """Rectangles that hold exactly a set of cells: lowest and highest cell of each.

    From the first cell left, as far as it goes along y, then along x.
    """
    left, found = cells.copy(), []
    while left.any():
        i, j = (int(v) for v in np.argwhere(left)[0])
        width = int(np.argmin(np.append(left[i, j:], False)))
        rows = np.append(left[i:, j : j + width].all(axis=1), False)
        height = int(np.argmin(rows))
        left[i : i + height, j : j + width] = False
        found.append(((i, j), (i + height - 1, j + width - 1)))
    return found
