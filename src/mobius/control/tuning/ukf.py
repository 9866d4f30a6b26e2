"""A square-root unscented Kalman filter for a slowly walking parameter.

Model: theta+ = theta + w, w ~ N(0, Q); y = h(theta) + e, e ~ N(0, R). All 2n + 1 sigma points
go through h in one call. Covariances live as lower-triangular roots; both updates are one QR
decomposition of a stacked matrix (the array form), so that P cannot lose positive
definiteness, which filters that subtract K S K^T do.

    predict   [S, Q^1/2]                       = [S-, 0] U
    update    [Y, R^1/2; X, 0]                 = [S_y, 0; L, S+] U,   gain = L S_y^-1

X and Y hold the weighted deviations of sigma points and predictions, U is orthogonal. It
wants weights that are not negative: 1 - alpha^2 + beta + lambda / (n + lambda) >= 0.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import solve_triangular

from mobius.errors import InvalidInput

__all__ = ["SquareRootUkf", "Update"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Update:
    """What one measurement did."""

    theta: Array
    """(n,) new estimate."""
    predicted: Array
    """(m,) mean of h over the sigma points."""
    innovation: Array
    """(m,)."""
    gain: Array
    """(n, m)."""


def _lower(block: Array) -> Array:
    """Lower-triangular L with L L^T = block block^T, diagonal >= 0."""
    R = np.linalg.qr(block.T, mode="r")
    sign = np.where(np.diag(R) < 0, -1.0, 1.0)
    lower: Array = (sign[:, None] * R).T
    return lower


class SquareRootUkf:
    """Estimates n parameters from measurements of m numbers."""

    def __init__(
        self,
        theta: ArrayLike,
        *,
        P: ArrayLike,
        Q: ArrayLike,
        R: ArrayLike,
        alpha: float = 1.0,
        beta: float = 2.0,
        kappa: float = 0.0,
    ) -> None:
        """A filter.

        Args:
            theta: (n,) first estimate.
            P: (n, n) its covariance, positive definite.
            Q: (n, n) of the walk, per prediction.
            R: (m, m) of the measurement, positive definite.
            alpha: Spread of the sigma points.
            beta: 2 is best for a Gaussian.
            kappa: Second spread, 0 as usual for parameters.
        """
        self.theta = np.array(theta, dtype=float)
        n = len(self.theta)
        lam = alpha**2 * (n + kappa) - n
        if n + lam <= 0:
            raise InvalidInput(f"SquareRootUkf: expected alpha^2 (n + kappa) > 0, got {n + lam:g}")
        self.spread = float(np.sqrt(n + lam))
        self.w_mean = np.full(2 * n + 1, 0.5 / (n + lam))
        self.w_cov = self.w_mean.copy()
        self.w_mean[0] = lam / (n + lam)
        self.w_cov[0] = self.w_mean[0] + 1 - alpha**2 + beta
        if self.w_cov[0] < 0:
            raise InvalidInput(
                f"SquareRootUkf: the central weight is {self.w_cov[0]:.3g}; raise alpha or beta"
            )
        self.S = self._root("P", P, n)
        self.S_q = self._root("Q", Q, n)
        self.S_r = self._root("R", R, None)

    @staticmethod
    def _root(name: str, value: ArrayLike, n: int | None) -> Array:
        matrix = np.atleast_2d(np.asarray(value, dtype=float))
        if matrix.shape != ((n or len(matrix)),) * 2:
            raise InvalidInput(f"SquareRootUkf.{name}: expected ({n}, {n}), got {matrix.shape}")
        try:
            return np.linalg.cholesky(matrix)
        except np.linalg.LinAlgError:
            raise InvalidInput(
                f"SquareRootUkf.{name}: expected a positive definite matrix"
            ) from None

    @property
    def P(self) -> Array:
        """(n, n) covariance of the estimate."""
        return self.S @ self.S.T

    def predict(self) -> None:
        """Let the parameter walk on."""
        self.S = _lower(np.hstack([self.S, self.S_q]))

    def sigma_points(self) -> Array:
        """(2n + 1, n): the estimate, then one step each way along every column of the root."""
        steps = self.spread * self.S.T
        return np.vstack([self.theta, self.theta + steps, self.theta - steps])

    def update(
        self,
        y: ArrayLike,
        h: Callable[[Array], Array],
        *,
        offset: Callable[[Array], Array] | None = None,
    ) -> Update:
        """Take in one measurement.

        Args:
            y: (m,) measured, or wished.
            h: (k, n) parameters -> (k, m) predictions.
            offset: From the predictions (2n + 1, m) a correction (m,) of their mean, for what
                was measured at the estimate itself.
        """
        points = self.sigma_points()
        Y = np.asarray(h(points), dtype=float)
        m = len(self.S_r)
        if Y.shape != (len(points), m) or not np.isfinite(Y).all():
            raise InvalidInput(
                f"SquareRootUkf.update: expected h to give finite ({len(points)}, {m}), got"
                f" shape {Y.shape}"
            )
        mean = self.w_mean @ Y
        root = np.sqrt(self.w_cov)[:, None]
        top = np.hstack([(root * (Y - mean)).T, self.S_r])
        low = np.hstack([(root * (points - self.theta)).T, np.zeros((len(self.theta), m))])
        L = _lower(np.vstack([top, low]))
        S_y, cross = L[:m, :m], L[m:, :m]
        gain = solve_triangular(S_y.T, cross.T, lower=False).T
        predicted = mean if offset is None else mean + offset(Y)
        innovation = np.asarray(y, dtype=float) - predicted
        self.theta = self.theta + gain @ innovation
        self.S = L[m:, m:]
        return Update(self.theta.copy(), predicted, innovation, gain)
