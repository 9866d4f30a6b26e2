"""A smooth way through key poses that overshoots none of them: monotone cubic (PCHIP)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


class Way:
    """Evenly spaced points (n, k), joined by cubics whose slopes never overshoot.

    The slopes are those of Fritsch and Carlson in the form of Fritsch and Butland: the harmonic
    mean of the two neighbouring steps where they have one sign, else 0; one-sided at the ends.
    """

    def __init__(self, points: ArrayLike) -> None:
        """Args: points (n, k), n >= 3; the way goes from the first (0) to the last (1)."""
        self.points = np.array(points, dtype=float)
        step = np.diff(self.points, axis=0)
        before, after = step[:-1], step[1:]
        same = before * after > 0.0
        total = np.where(same, before + after, 1.0)
        inner = np.where(same, 2.0 * before * after / total, 0.0)
        self.slopes = np.vstack([_end(step[0], step[1]), inner, _end(step[-1], step[-2])])

    def at(self, share: float) -> Array:
        """Point (k,) at a share of the way, 0 to 1."""
        last = len(self.points) - 1
        x = min(max(share, 0.0), 1.0) * last
        i = min(int(x), last - 1)
        t = x - i
        a, b = self.points[i], self.points[i + 1]
        u = t * t * (3.0 - 2.0 * t)
        rise = t * (1.0 - t)
        bend = (1.0 - t) * self.slopes[i] - t * self.slopes[i + 1]
        return np.asarray(a + u * (b - a) + rise * bend)


def _end(near: Array, far: Array) -> Array:
    """Slope at an end from its step and the next: three points, kept from overshooting."""
    slope = 0.5 * (3.0 * near - far)
    slope = np.where(slope * near > 0.0, slope, 0.0)
    turns = (near * far <= 0.0) & (np.abs(slope) > np.abs(3.0 * near))
    return np.where(turns, 3.0 * near, slope)
