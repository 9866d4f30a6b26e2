"""Which half-spaces of a polytope matter: Farkas certificates by non-negative least squares.

Rows are scaled to ``p z <= 1``. A row p is implied by rows S exactly if p lies in the convex
hull of S and the origin (Farkas). Non-negative least squares decides that: a zero residual is
the certificate; otherwise the residual points at a z that obeys S and breaks p. Both ways it is
20 times faster here than a linear program, and the answer is the same; ``support`` is the
linear program (HiGHS) for those who want the number.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog, nnls

from mobius.errors import MobiusError

__all__ = ["Bound", "Pruner", "support", "symmetric_half"]

Array = NDArray[np.float64]

RESIDUAL = 1e-9
"""A residual below this is zero; coordinates are scaled to the size of the rows."""


def support(rows: Array, c: Array) -> float:
    """Largest ``c z`` over ``rows z <= 1`` by HiGHS; infinite where nothing bounds it."""
    done = linprog(-c, A_ub=rows, b_ub=np.ones(len(rows)), bounds=(None, None), method="highs")
    if done.status == 3:
        return float("inf")
    if done.status != 0:
        raise MobiusError(f"the linear program over {len(rows)} rows failed: {done.message}")
    return float(-done.fun)


class Bound:
    """An upper bound of ``|c z|`` over ``rows z <= 1`` for many c at once.

    The polytope is put into a box along the axes of the ellipsoid that the rows span, by two
    linear programs an axis.
    """

    def __init__(self, rows: Array) -> None:
        """Args: rows (r, n)."""
        scale = np.abs(rows).max(axis=0)
        scale[scale == 0.0] = 1.0
        rows = rows / scale
        _, axes = np.linalg.eigh(rows.T @ rows)
        half = [max(support(rows, e), support(rows, -e)) for e in axes.T]
        self._axes = axes / scale[:, None]
        self._half = np.array(half)

    @property
    def finite(self) -> bool:
        """Whether the polytope is bounded."""
        return bool(np.isfinite(self._half).all())

    def __call__(self, c: Array) -> Array:
        """(...) for c (..., n)."""
        return np.abs(c @ self._axes) @ self._half


class Pruner:
    """Keeps as few rows as imply all rows it was shown, up to a tolerance.

    After ``add(P)``: ``P z <= 1 + tolerance`` wherever ``rows z <= 1``. A symmetric one is shown
    one row of every pair ``p, -p`` and keeps both.
    """

    def __init__(self, scale: Array, tolerance: float, *, symmetric: bool = False) -> None:
        """Args: scale (n,) size of each coordinate of the rows; tolerance, relative, >= 0."""
        self._scale = scale
        self._slack = 1.0 + tolerance
        self._symmetric = symmetric
        self._kept = np.zeros((0, len(scale)))  # scaled
        self._table = np.zeros((len(scale) + 1, 1))
        self._table[-1, 0] = 1.0

    @property
    def shown(self) -> Array:
        """(k, n) the rows kept, one of each pair where symmetric, in the order of keeping."""
        return self._kept * self._scale

    @property
    def rows(self) -> Array:
        """(r, n) all rows kept."""
        return np.vstack([self.shown, -self.shown]) if self._symmetric else self.shown

    def implies(self, row: Array) -> bool:
        """Whether the rows kept imply ``row z <= 1``, without tolerance."""
        return self._breach(row / self._scale) is None

    def add(self, candidates: Array) -> NDArray[np.intp]:
        """Keep those rows (c, n) that are needed; returns their indices."""
        P = candidates / self._scale
        waiting = np.ones(len(P), bool)
        taken: list[int] = []
        for i in range(len(P)):
            while waiting[i]:
                breach = self._breach(P[i] / self._slack)
                if breach is None:
                    waiting[i] = False
                    continue
                # the row that is broken most there is needed at least as much as row i
                values = P @ breach
                values = np.abs(values) if self._symmetric else values
                worst = int(np.argmax(np.where(waiting, values, -np.inf)))
                self._keep(P[worst])
                waiting[worst] = False
                taken.append(worst)
        return np.array(taken, dtype=np.intp)

    def _keep(self, row: Array) -> None:
        self._kept = np.vstack([self._kept, row])
        more = np.append(row, 1.0)[:, None]
        if self._symmetric:
            more = np.hstack([more, np.append(-row, 1.0)[:, None]])
        self._table = np.hstack([self._table, more])

    def _breach(self, row: Array) -> Array | None:
        """None where the row is implied, else a z that obeys all rows kept and breaks it."""
        target = np.append(row, 1.0)
        weights, residual = nnls(self._table, target)
        if residual < RESIDUAL:
            return None
        gap = target - self._table @ weights
        if gap[-1] >= 0.0:  # unbounded that way: any row with a positive value there will do
            return 1e12 * gap[:-1]
        return gap[:-1] / -gap[-1]


def symmetric_half(H: Array, h: Array) -> NDArray[np.intp] | None:
    """Indices of one row of each pair ``H_i = -H_j, h_i = h_j``; None where some have none."""
    left, half = list(range(len(h))), []
    while left:
        i = left.pop(0)
        twin = [j for j in left if h[j] == h[i] and np.array_equal(H[j], -H[i])]
        if not twin:
            return None
        left.remove(twin[0])
        half.append(i)
    return np.array(half, dtype=np.intp)
