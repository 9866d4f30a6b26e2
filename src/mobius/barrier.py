"""What stands between two areas of a map: where it is thinnest, and how far it goes on.

For messages: whoever finds that a goal cannot be reached says which wall is in the way.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mobius.types import GridMap

__all__ = ["Barrier", "thinnest", "wall_between", "wall_of"]

Cell = tuple[int, int]
Mask = NDArray[np.bool_]

_SIDES = ((1, 0), (-1, 0), (0, 1), (0, -1))
_AROUND = tuple((i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if (i, j) != (0, 0))


@dataclass(frozen=True, eq=False)
class Barrier:
    """The shortest line of neighbouring cells from one area to another."""

    near: Cell
    """Cell of the first area where the line begins."""
    far: Cell
    """Cell of the second area where it ends."""
    between: tuple[Cell, ...]
    """Cells between the two, in order; none where the areas touch."""
    thin: Mask
    """(nx, ny) cells that lie on any line as short as this one, ends included."""


def thinnest(near: Mask, far: Mask) -> Barrier:
    """The shortest way between two areas over cells of any kind.

    Args:
        near: (nx, ny) cells of one area, at least one.
        far: (nx, ny) cells of the other, at least one, none of them in ``near``.
    """
    if not (near.any() and far.any()):
        raise ValueError("expected two areas of at least one cell each")
    out = np.where(near, 0, -1)
    k = 0
    while not (met := far & (out == k)).any():
        _widen(out, k)
        k += 1
    home = np.where(met, 0, -1)
    for wave in range(k):
        _widen(home, wave)
    thin = (out >= 0) & (home >= 0) & (out + home == k)
    where = np.argwhere(met)
    middle = where[((where - where.mean(axis=0)) ** 2).sum(axis=1).argmin()]
    line = [(int(middle[0]), int(middle[1]))]
    while out[line[-1]] > 0:
        line.append(_next(out, line[-1]))
    return Barrier(line[-1], line[0], tuple(line[-2:0:-1]), thin)


def _widen(steps: NDArray[np.int64], k: int) -> None:
    """Number the unnumbered neighbours of the cells at k steps."""
    front = steps == k
    new = np.zeros_like(front)
    new[1:] |= front[:-1]
    new[:-1] |= front[1:]
    new[:, 1:] |= front[:, :-1]
    new[:, :-1] |= front[:, 1:]
    steps[new & (steps < 0)] = k + 1


def _next(steps: NDArray[np.int64], cell: Cell) -> Cell:
    """A neighbour one step nearer to where the steps are counted from."""
    i, j = cell
    return next(
        (i + di, j + dj)
        for di, dj in _SIDES
        if 0 <= i + di < steps.shape[0]
        and 0 <= j + dj < steps.shape[1]
        and steps[i + di, j + dj] == steps[cell] - 1
    )


def wall_of(blocked: Mask, cell: Cell) -> tuple[Cell, Cell]:
    """Lowest and highest cell of the box round the wall that holds a blocked cell.

    Args:
        blocked: (nx, ny); cells that touch by a side or a corner are one wall.
        cell: A blocked one.
    """
    nx, ny = blocked.shape
    left = blocked.copy()
    left[cell] = False
    stack, low, high = [cell], cell, cell
    while stack:
        i, j = stack.pop()
        low, high = (min(low[0], i), min(low[1], j)), (max(high[0], i), max(high[1], j))
        for di, dj in _AROUND:
            a, b = i + di, j + dj
            if 0 <= a < nx and 0 <= b < ny and left[a, b]:
                left[a, b] = False
                stack.append((a, b))
    return low, high


def wall_between(grid: GridMap, line: Barrier) -> str | None:
    """Which wall the line crosses, in words; ``None`` where none of its cells is blocked.

    Names the place where it is thinnest, how thick it is there, and the box [m] round the
    part of it that is no thicker.
    """
    walls = [c for c in line.between if grid.blocked[c]]
    if not walls:
        return None
    x, y = grid.center_of(walls[len(walls) // 2]).tolist()
    low, high = wall_of(grid.blocked & line.thin, walls[len(walls) // 2])
    box = [(i, j) for i in (low[0], high[0] + 1) for j in (low[1], high[1] + 1)]
    corners = grid.center_of(np.array(box) - 0.5)
    (x0, y0), (x1, y1) = corners.min(axis=0) + 0.0, corners.max(axis=0) + 0.0
    n = len(walls)
    return (
        f"the wall in between (x {_short(x0)} to {_short(x1)}, y {_short(y0)} to {_short(y1)} m) is"
        f" {n} cell{'s' if n > 1 else ''} thick at ({_short(x)}, {_short(y)}) m"
    )


def _short(metres: float) -> str:
    return f"{round(metres, 2) + 0.0:g}"
