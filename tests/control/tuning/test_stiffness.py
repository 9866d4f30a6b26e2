"""The stiffness of a contact, from moving in it."""

import numpy as np
import pytest

from mobius.control.admittance import DT
from mobius.control.tuning import StiffnessEstimator

RNG = np.random.default_rng


def closed_loop(K: np.ndarray, seconds: float, seed: int, *, wish: float = 5.0):
    """y, f, w of a slow force loop in a contact that sways, as it would be recorded."""
    n, rng = len(K), RNG(seed)
    ticks = round(seconds / DT)
    y, out = np.zeros(n), []
    gain = 3.0 / np.linalg.eigvalsh(K)[-1]
    w = np.zeros(n)
    for k in range(ticks):
        if k % 300 == 0:
            w = rng.uniform(-wish, wish, n)
        sway = 0.8 * np.sin(2 * np.pi * 0.4 * k * DT + np.arange(n))
        f = -K @ y + sway + 0.15 * rng.standard_normal(n)
        out.append((y.copy(), f, w.copy()))
        y = y + DT * gain * (f - w)
    return tuple(np.array(a) for a in zip(*out, strict=True))


def fed(K, seconds=20.0, seed=0, **kw):
    estimator = StiffnessEstimator(len(K))
    y, f, w = closed_loop(K, seconds, seed, **kw)
    for start in range(0, len(y), 150):
        part = slice(start, start + 150)
        estimator.add(y[part], f[part], w[part])
    return estimator.estimate(), (y, f)


@pytest.mark.parametrize("k", [500.0, 50_000.0])
def test_a_spring_is_found(k):
    found, _ = fed(np.array([[k]]))
    assert found.low == found.high == pytest.approx(k, rel=0.1)


def test_least_squares_is_biased_and_the_instruments_are_not():
    """y answers to sway and noise, so that the plain slope of f over y is off in the mean."""
    k, ours, plain = 5000.0, [], []
    for seed in range(12):
        found, (y, f) = fed(np.array([[k]]), seed=seed, wish=1.5)
        y, f = y - y.mean(), f - f.mean()
        ours.append(found.low / k - 1)
        plain.append(-float((y * f).sum() / (y * y).sum()) / k - 1)
    assert abs(np.median(ours)) < 0.06
    assert abs(np.median(plain)) > 2 * abs(np.median(ours))


def test_coupled_axes_are_found():
    K = 4000.0 * np.array([[1.0, 0.2], [0.2, 0.4]])
    found, _ = fed(K, 30.0)
    low, high = np.linalg.eigvalsh(K)
    assert found.high == pytest.approx(high, rel=0.15)
    assert abs(found.low / low - 1.0) < 3 * found.spread_low < 1.0
    assert found.spread_high < found.spread_low  # the soft direction is seen less well


def test_the_spread_is_honest():
    """Over 30 seeds the error is mostly within twice the told spread."""
    K = np.array([[3000.0]])
    off = [abs(e.low / 3000.0 - 1) / e.spread for e in (fed(K, 6.0, s)[0] for s in range(30))]
    assert np.mean(np.array(off) < 2.0) >= 0.9


def test_without_a_changing_wish_nothing_is_said():
    found, _ = fed(np.array([[3000.0]]), 10.0, wish=0.0)
    assert found is None


def test_what_is_no_spring_is_not_called_one():
    estimator, rng = StiffnessEstimator(1), RNG(0)
    y, w = rng.standard_normal((600, 1)), rng.standard_normal((600, 1))
    estimator.add(y + w, 100.0 * (y + w), w)  # pushes along instead of back
    assert estimator.estimate() is None
