"""The square-root filter, against filterpy, a Kalman filter, and by hand."""

import numpy as np
import pytest

from mobius.control.tuning import SquareRootUkf
from mobius.errors import InvalidInput

A = np.array([[0.7, -0.2, 0.4], [0.1, 0.5, -0.3]])
P, Q = np.diag([1.0, 0.5, 0.2]), np.diag([0.01, 0.02, 0.03])
R = np.array([[0.5, 0.1], [0.1, 0.3]])


def bent(theta: np.ndarray) -> np.ndarray:
    return np.tanh(theta @ A.T) + 0.1 * theta[..., :2] ** 2


@pytest.mark.parametrize(("alpha", "beta", "kappa"), [(1.0, 2.0, 0.0), (0.5, 2.0, 1.0)])
def test_it_is_filterpys_filter_step_by_step(alpha, beta, kappa):
    filterpy = pytest.importorskip("filterpy.kalman")
    ours = SquareRootUkf(np.zeros(3), P=P, Q=Q, R=R, alpha=alpha, beta=beta, kappa=kappa)
    points = filterpy.MerweScaledSigmaPoints(3, alpha, beta, kappa)
    oracle = filterpy.UnscentedKalmanFilter(3, 2, 1.0, bent, lambda x, dt: x, points)
    oracle.x, oracle.P, oracle.Q, oracle.R = np.zeros(3), P.copy(), Q, R
    rng = np.random.default_rng(0)
    for _ in range(50):
        y = rng.normal(size=2)
        ours.predict()
        ours.update(y, bent)
        oracle.predict()
        oracle.update(y)
        np.testing.assert_allclose(ours.theta, oracle.x, atol=1e-12)
        np.testing.assert_allclose(ours.P, oracle.P, atol=1e-12)


def test_on_a_linear_measurement_it_is_the_kalman_filter():
    ukf = SquareRootUkf([0.3, -0.1, 0.2], P=P, Q=Q, R=R)
    x, C, y = np.array([0.3, -0.1, 0.2]), P + Q, np.array([1.0, -2.0])
    gain = C @ A.T @ np.linalg.inv(A @ C @ A.T + R)
    ukf.predict()
    done = ukf.update(y, lambda t: t @ A.T)
    np.testing.assert_allclose(done.gain, gain, atol=1e-12)
    np.testing.assert_allclose(ukf.theta, x + gain @ (y - A @ x), atol=1e-12)
    np.testing.assert_allclose(ukf.P, C - gain @ A @ C, atol=1e-12)


def test_one_number_by_hand():
    """P = 3, Q = 1, R = 4, h = theta, y = 2: gain 4 / 8, theta 1, P 2."""
    ukf = SquareRootUkf([0.0], P=[[3.0]], Q=[[1.0]], R=[[4.0]])
    ukf.predict()
    done = ukf.update([2.0], lambda t: t)
    assert done.gain[0, 0] == pytest.approx(0.5)
    assert ukf.theta[0] == pytest.approx(1.0)
    assert ukf.P[0, 0] == pytest.approx(2.0)


def test_the_covariance_stays_positive_where_the_measurement_is_almost_perfect():
    """With R = 1e-16 a filter that subtracts K S K^T ends with a negative eigenvalue."""
    ukf = SquareRootUkf(np.zeros(3), P=P, Q=1e-18 * np.eye(3), R=1e-16 * np.eye(2))
    for _ in range(200):
        ukf.predict()
        ukf.update(np.zeros(2), lambda t: t @ A.T)
    assert np.isfinite(ukf.S).all()
    assert np.linalg.eigvalsh(ukf.P).min() >= 0.0
    assert (np.diag(ukf.S) >= 0).all()


def test_the_offset_moves_the_prediction_and_nothing_else():
    a, b = (SquareRootUkf(np.zeros(3), P=P, Q=Q, R=R) for _ in range(2))
    shift = np.array([0.4, -0.2])
    a.update(np.zeros(2), bent, offset=lambda Y: shift)
    b.update(-shift, bent)
    np.testing.assert_allclose(a.theta, b.theta, atol=1e-14)
    np.testing.assert_allclose(a.S, b.S, atol=1e-14)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"P": np.eye(2)}, r"P: expected \(3, 3\), got \(2, 2\)"),
        ({"Q": np.zeros((3, 3))}, "Q: expected a positive definite"),
        ({"alpha": 0.1, "beta": 0.0}, "central weight"),
        ({"kappa": -3.0}, r"alpha\^2 \(n \+ kappa\) > 0"),
    ],
)
def test_what_cannot_work_is_refused(changes, told):
    with pytest.raises(InvalidInput, match=told):
        SquareRootUkf(np.zeros(3), **{"P": P, "Q": Q, "R": R, **changes})


def test_predictions_that_are_not_numbers_are_refused():
    ukf = SquareRootUkf(np.zeros(3), P=P, Q=Q, R=R)
    with pytest.raises(InvalidInput, match=r"finite \(7, 2\)"):
        ukf.update(np.zeros(2), lambda t: np.full((7, 2), np.nan))
