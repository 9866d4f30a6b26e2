"""The one-axis law, Eq. (22), and its discretisations."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mobius.control.admittance import DT, SERVO_LAG, AxisGains, AxisLaw
from mobius.errors import InvalidInput, UnknownName
from mobius.model.servo import SERVOS

FULL = AxisGains(M=0.9, D=40.0, K=300.0, K_f=1.3, K_fi=2.0, K_pi=90.0)


def test_the_exact_step_is_the_solution_of_the_differential_equation():
    g, s0, r, w, f = FULL, [0.01, -0.2, 0.4, 0.02], 0.03, -5.0, 7.0

    def rate(_t, s):
        x, v, z, y = s
        u = (g.K_f * (f - w) + z - g.D * v - g.K * (x - r)) / g.M
        return [v, u, g.K_fi * (f - w) - g.K_pi * (x - r), (x - y) / SERVO_LAG]

    truth = solve_ivp(rate, (0, DT), s0, rtol=1e-11, atol=1e-13).y[:, -1]
    lti = AxisLaw(g).matrices()
    ours = lti.A @ s0 + lti.B @ [r, w] + lti.E[:, 0] * f
    np.testing.assert_allclose(ours, truth, rtol=1e-8, atol=1e-11)


def test_the_papers_explicit_step_alternates_in_sign_and_ours_do_not():
    """M 0.7, D 250 at 300 Hz: 1 - 250 / 0.7 / 300 = -0.190; exact exp(-250 / 0.7 / 300) = 0.304."""
    s = np.array([0.0, 1.0, 0.0, 0.0])
    v = {m: (AxisLaw(method=m).matrices().A @ s)[1] for m in ("explicit", "exact", "semi_implicit")}
    assert v["explicit"] == pytest.approx(-0.190476, abs=1e-6)
    assert v["exact"] == pytest.approx(0.304076, abs=1e-6)
    assert v["semi_implicit"] == pytest.approx(1 / (1 + 250 / 0.7 / 300))
    A = AxisLaw(method="explicit").matrices().A
    signs = []
    for _ in range(6):
        s = A @ s
        signs.append(np.sign(s[1]))
    assert signs == [-1, 1, -1, 1, -1, 1]


@pytest.mark.parametrize("method", ["semi_implicit", "explicit"])
def test_all_steps_agree_where_the_tick_is_short(method):
    short = 1e-6
    exact = AxisLaw(FULL, dt=short).matrices()
    other = AxisLaw(FULL, dt=short, method=method).matrices()
    for a, b in zip(exact[:3], other[:3], strict=True):
        np.testing.assert_allclose(a, b, atol=2e-8)


def test_public_gains_move_4_mm_per_second_and_newton():
    """D = 250, K_f = 1: v = f / D = 1 / 250 m/s."""
    lti = AxisLaw().matrices()
    s = np.zeros(4)
    for _ in range(300):
        s = lti.A @ s + lti.E[:, 0] * 1.0
    assert s[1] == pytest.approx(0.004, rel=1e-6)


def test_both_integrals_settle_on_the_compromise_of_the_paper():
    """Sec. V-G4: at rest K_pi (x - x_ref) = K_fi (W - W_ref), neither is fulfilled."""
    g = AxisGains(M=1.0, D=60.0, K=200.0, K_f=1.0, K_fi=1.0, K_pi=100.0)
    lti, k, s, r, w = AxisLaw(g).matrices(), 400.0, np.zeros(4), np.array([0.02, 0.0]), 0.0
    for _ in range(12_000):
        w = -k * s[3]
        s = lti.A @ s + lti.B @ r + lti.E[:, 0] * w
    assert g.K_pi * (s[0] - r[0]) == pytest.approx(g.K_fi * (w - r[1]), abs=1e-6)
    assert 0 < s[0] < r[0]


def test_the_servo_lags_by_damping_over_stiffness_of_the_servos():
    for name in ("shoulder_yaw", "shoulder_motor_a", "wrist_yaw"):
        assert SERVOS[name].damping / SERVOS[name].kp == pytest.approx(SERVO_LAG, abs=5e-4)


@pytest.mark.parametrize("method", ["exact", "semi_implicit", "explicit"])
def test_without_lag_the_servo_is_where_the_command_is(method):
    lti = AxisLaw(FULL, tau=0.0, method=method).matrices()
    np.testing.assert_allclose(lti.A[3], lti.A[0])
    np.testing.assert_allclose(lti.E[3], lti.E[0])


def test_the_matrices_cannot_be_written():
    with pytest.raises(ValueError):
        AxisLaw().matrices().A[0, 0] = 2.0


@pytest.mark.parametrize(
    ("gains", "told"),
    [
        ({"M": 0.0}, r"AxisGains.M: expected a number > 0, got 0.0"),
        ({"D": -1.0}, "AxisGains.D"),
        ({"K_f": float("nan")}, "AxisGains.K_f"),
        ({"K": 1.0, "D": 1.0, "K_pi": 10.0}, r"unstable; expected D K > M K_pi"),
    ],
)
def test_gains_that_cannot_work_are_refused(gains, told):
    with pytest.raises(InvalidInput, match=told):
        AxisGains(**gains)


def test_the_bound_on_the_position_integral_is_the_true_one():
    """Routh: M s^3 + D s^2 + K s + K_pi is stable exactly for D K > M K_pi."""
    at = AxisGains(M=1.0, D=20.0, K=30.0, K_f=1.0, K_fi=0.0, K_pi=590.0)
    assert np.abs(np.linalg.eigvals(AxisLaw(at).matrices().A)).max() < 1.0
    roots = np.roots([1.0, 20.0, 30.0, 610.0])
    assert roots.real.max() > 0
    with pytest.raises(InvalidInput):
        AxisGains(M=1.0, D=20.0, K=30.0, K_f=1.0, K_fi=0.0, K_pi=610.0)


def test_an_unknown_step_is_told_with_the_known_ones():
    with pytest.raises(UnknownName, match="semi_implicit"):
        AxisLaw(method="semi")
