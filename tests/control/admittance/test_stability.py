"""The closed loop with a contact."""

import numpy as np
import pytest

from mobius.control.admittance import AxisGains, AxisLaw, Interval, Loop, damping, spectral_radius
from mobius.control.admittance.stability import as_rows, closed_loops
from mobius.errors import InvalidInput


def simulated(gains: AxisGains, k: float, loop: Loop, ticks: int) -> np.ndarray:
    """Positions of the servo, written out tick by tick."""
    lti, a = AxisLaw(gains, tau=loop.tau).matrices(), loop.filter_coefficient
    keep = np.exp(-loop.dt / loop.tau)
    s, y, w, before = np.array([1e-3, 0.0, 0.0, 0.0]), 0.0, 0.0, 1e-3
    out = []
    for _ in range(ticks):
        out.append(y)
        w = w + a * (-k * y - w)
        servo_towards = before if loop.delay else None
        before = s[0]
        s = lti.A @ s + lti.E[:, 0] * w
        y = keep * y + (1 - keep) * servo_towards if loop.delay else s[3]
    return np.array(out)


def test_the_matrix_is_the_loop_that_runs():
    g = AxisGains(D=900.0, K=20.0, K_f=1.2, K_fi=0.3, K_pi=2.0)
    loop = Loop()
    A = closed_loops(as_rows(g), np.array([4000.0]), loop)[0, 0]
    s, ours = np.array([1e-3, 0.0, 0.0, 0.0, 0.0, 1e-3]), []
    for _ in range(200):
        ours.append(s[3])
        s = A @ s
    np.testing.assert_allclose(ours, simulated(g, 4000.0, loop, 200), atol=1e-15)


@pytest.mark.parametrize(("D", "stable"), [(200.0, False), (1200.0, True)])
def test_the_spectral_radius_tells_growth_from_decay(D, stable):
    g, k = AxisGains(D=D), 15_000.0
    radius = spectral_radius(g, Interval(k, k, lag=(1.0,)), Loop())[0]
    y = np.abs(simulated(g, k, Loop(), 1500))
    assert bool(radius < 1) is stable
    assert bool(y[-300:].max() < y[:300].max()) is stable


def test_damping_is_zero_where_the_radius_is_one():
    k = 15_000.0
    at = Interval(k, k, lag=(1.0,))
    low, high = 10.0, 1e4
    for _ in range(60):
        D = np.sqrt(low * high)
        low, high = (low, D) if spectral_radius(AxisGains(D=D), at, Loop())[0] < 1 else (D, high)
    assert damping(AxisGains(D=high), at, Loop())[0] == pytest.approx(0.0, abs=1e-6)


def test_an_interval_is_as_bad_as_its_worst_end():
    g = AxisGains(D=400.0)
    wide = spectral_radius(g, Interval(500.0, 40_000.0), Loop())[0]
    ends = [
        spectral_radius(g, Interval(k, k, lag=(f,)), Loop())[0]
        for k in (500.0, 40_000.0)
        for f in (0.8, 1.25)
    ]
    assert wide >= max(ends) - 1e-12
    assert wide > 1


@pytest.mark.parametrize(
    "make",
    [
        lambda: Interval(0.0, 1.0),
        lambda: Interval(2.0, 1.0),
        lambda: Interval(1.0, 2.0, lag=()),
        lambda: Loop(filter_coefficient=0.0),
        lambda: Loop(delay=2),
    ],
)
def test_nonsense_is_refused(make):
    with pytest.raises(InvalidInput):
        make()
