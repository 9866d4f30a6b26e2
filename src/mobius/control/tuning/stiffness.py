"""How stiff is what the grippers touch? From the tuner's own windows, while the robot works.

Wrench and servo position obey W = -K (y - p) + noise with an unknown, moving p. In closed
loop y answers to p and to noise, so that plain least squares is biased; the wished wrench
knows nothing of either and serves as the instrument (two-stage least squares). Its low-passed
copies are instruments too, since a slow loop answers slowly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve

from mobius.control.admittance.law import DT

__all__ = ["ContactEstimate", "StiffnessEstimator"]

Array = NDArray[np.float64]

SLOW = (0.15, 0.6, 2.4)
"""Time constants of the instruments' low passes [s]."""
TOGETHER = 100.0
"""Ticks whose residuals count as one: what moves a contact does so within a third of a second."""
LOOSE = 1.0
"""Spread of an estimate that takes all axes for equally stiff."""


@dataclass(frozen=True, eq=False)
class ContactEstimate:
    """What is known of a contact."""

    K: Array
    """(n, n) symmetric stiffness [N/m]."""
    low: float
    """Softest direction [N/m]."""
    high: float
    """Stiffest direction [N/m]."""
    spread_low: float
    """Relative standard deviation of ``low``."""
    spread_high: float
    """Relative standard deviation of ``high``."""

    @property
    def spread(self) -> float:
        """The larger of the two."""
        return max(self.spread_low, self.spread_high)


class StiffnessEstimator:
    """Gathers windows with forgetting; n axes that may be coupled by the contact."""

    def __init__(self, n: int, *, dt: float = DT, keep: float = 0.97) -> None:
        """An estimator.

        Args:
            n: Axes.
            dt: Tick [s].
            keep: Weight of all older windows per new one, (0, 1).
        """
        self.n, self._keep = n, keep
        self._a = np.array([dt / (t + dt) for t in SLOW])[:, None]
        self._slow: Array | None = None
        m = n * (1 + len(SLOW))
        self._zz, self._zy, self._zf = np.zeros((m, m)), np.zeros((m, n)), np.zeros((m, n))
        self._ff, self._fy, self._yy = np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n))
        self._count = 0.0

    def add(self, y: Array, f: Array, w: Array) -> None:
        """Take in a stretch of ticks that follows the last one: y, f, w (t, n) [m, N, N]."""
        Z = np.hstack([w, *self._instruments(w)])
        Z, Y, F = (a - a.mean(axis=0) for a in (Z, y, f))
        for name, value in (
            ("_zz", Z.T @ Z),
            ("_zy", Z.T @ Y),
            ("_zf", Z.T @ F),
            ("_ff", F.T @ F),
            ("_fy", F.T @ Y),
            ("_yy", Y.T @ Y),
        ):
            setattr(self, name, self._keep * getattr(self, name) + value)
        self._count = self._keep * self._count + len(y)

    def _instruments(self, w: Array) -> list[Array]:
        s = np.tile(w[0], (len(SLOW), 1)) if self._slow is None else self._slow
        out = np.empty((len(w), len(SLOW), self.n))
        for k, row in enumerate(w):
            s = s + self._a * (row - s)
            out[k] = s
        self._slow = s
        return [out[:, i] for i in range(len(SLOW))]

    def estimate(self) -> ContactEstimate | None:
        """The contact, or None while the windows do not tell (no excitation, wrong sign).

        Where the coupled estimate is not positive, all axes are taken as equally stiff, and
        the spread tells that this may be far off.
        """
        ridge = 1e-6 * np.trace(self._zz) / len(self._zz)
        if not ridge > 0:
            return None
        root = self._zz + ridge * np.eye(len(self._zz))
        projected = solve(root, self._zy, assume_a="pos")
        yy = self._zy.T @ projected  # (n, n) of y as the instruments explain it
        yf = projected.T @ self._zf
        if not np.trace(yy) > 0:
            return None
        if self.n > 1 and np.linalg.cond(yy) < 1e8:
            slope = np.linalg.solve(yy, yf)
            found = self._judged(-0.5 * (slope + slope.T), np.linalg.inv(yy), 0.0)
            if found is not None and found.spread < LOOSE:
                return found
        k = -float(np.trace(yf) / np.trace(yy))
        loose = LOOSE if self.n > 1 else 0.0
        return self._judged(k * np.eye(self.n), np.eye(self.n) / float(np.trace(yy)), loose)

    def _judged(self, K: Array, inverse: Array, loose: float) -> ContactEstimate | None:
        """An estimate with its spreads, or None where it is no stiffness.

        Args:
            K: (n, n) [N/m].
            inverse: (n, n) of the explained motion's moments; with the residuals' variances
                it gives the covariance of K.
            loose: Least spread to report.
        """
        values, U = np.linalg.eigh(K)
        if not values[0] > 0:
            return None
        residual = self._ff + K @ self._yy @ K + K @ self._fy.T + self._fy @ K
        noise = np.maximum(np.diag(residual), 0.0) / self._count
        # residuals of neighbouring ticks go together: one in TOGETHER counts
        variance = np.sum(U * (inverse @ U), axis=0) * (noise @ U**2)
        low, high = (
            max(float(np.sqrt(TOGETHER * variance[i]) / values[i]), loose) for i in (0, -1)
        )
        return ContactEstimate(K, float(values[0]), float(values[-1]), low, high)
