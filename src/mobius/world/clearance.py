"""How far every point of the floor is from the nearest obstacle, exactly.

Obstacles are the closed squares of the blocked pixels, and everything off the map. Seen
from a point of the *half-pixel lattice* (pixel corners, edge middles and centres), the
nearest point of an axis-aligned unit square is again on that lattice: each coordinate is
either the point's own or that of an edge. So one Euclidean distance transform of the
lattice, with the 3 x 3 lattice points of each blocked pixel marked, gives the true
distance at every lattice point, not an approximation by pixel centres. By the same
argument the least distance along a straight lattice line is taken at a lattice point.

Between lattice points distance changes by at most one metre per metre, so
``value at the nearest lattice point - distance to it`` never promises too much.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


class Clearance:
    """Distance to the nearest obstacle [m], in the raster's own axes.

    Attributes:
        step: Spacing of the lattice [m], half a pixel.
        values: (2h+1, 2w+1) distance [m]; ``values[i, j]`` belongs to x = j step, y = i step.
    """

    def __init__(self, blocked: Mask, resolution: float) -> None:
        """Measure a raster (h, w) of blocked pixels, ``resolution`` [m] wide, row 0 at y = 0."""
        h, w = blocked.shape
        free = np.ones((2 * h + 1, 2 * w + 1), dtype=bool)
        for di in range(3):
            for dj in range(3):
                free[di : di + 2 * h - 1 : 2, dj : dj + 2 * w - 1 : 2] &= ~blocked
        free[[0, -1], :] = False
        free[:, [0, -1]] = False
        self.step = resolution / 2
        self.values: Array = ndimage.distance_transform_edt(free) * self.step

    def at(self, xy: ArrayLike) -> Array:
        """Distance (...) [m] at points (..., 2) [m]; exact on the lattice, never too large."""
        xy = np.asarray(xy, dtype=float)
        j, on_x, dx = self._nearest(xy[..., 0], axis=0)
        i, on_y, dy = self._nearest(xy[..., 1], axis=1)
        value = np.maximum(self.values[i, j] - np.hypot(dx, dy), 0.0)
        return np.asarray(np.where(on_x & on_y, value, 0.0))

    def along(self, a: ArrayLike, b: ArrayLike) -> float:
        """Least distance [m] on the straight line from a (2,) to b (2,) [m], never too large."""
        a, b = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
        pieces = max(1, int(np.ceil(np.linalg.norm(b - a) / self.step)))
        points = a + np.arange(pieces + 1)[:, None] * ((b - a) / pieces)
        slack = 0.5 * float(np.linalg.norm(b - a)) / pieces
        return max(0.0, float(self.at(points).min()) - slack)

    def ahead(self, length: float, *, axis: int) -> Array:
        """Least distance [m] on the line of ``length`` [m] that starts at each lattice point.

        ``axis`` 0 looks along +x, 1 along +y; beyond the map the distance is 0.
        """
        n = int(np.ceil(length / self.step - 1e-9))
        lattice_axis = 1 - axis
        # a window of n + 1 points that starts at its own index instead of being centred on it
        return np.asarray(
            ndimage.minimum_filter1d(
                self.values,
                n + 1,
                axis=lattice_axis,
                origin=-((n + 1) // 2),
                mode="constant",
                cval=0.0,
            )
        )

    def sample_grid(self, table: Array, x: Array, y: Array) -> Array:
        """Values (nx, ny) of a lattice table at the crossings of x (nx,) and y (ny,) [m]."""
        (j, on_x, dx), (i, on_y, dy) = self._nearest(x, axis=0), self._nearest(y, axis=1)
        value = np.maximum(table[np.ix_(i, j)].T - np.hypot(dx[:, None], dy), 0.0)
        return np.where(on_x[:, None] & on_y, value, 0.0)

    def _nearest(self, x: Array, *, axis: int) -> tuple[NDArray[np.int64], Mask, Array]:
        """Lattice index, whether on the map, and distance to it [m], along one axis."""
        count = self.values.shape[1 - axis]
        index = np.rint(x / self.step).astype(np.int64)
        off = np.abs(x - index * self.step)
        on_map = (index >= 0) & (index < count)
        return np.clip(index, 0, count - 1), on_map, np.where(off < 1e-9, 0.0, off)
