"""The running controller: drop-outs, limits, anti-windup, governors, gains that change."""

from dataclasses import replace

import numpy as np
import pytest

from mobius.control.admittance import DT, Admittance, AdmittanceConfig, AxisGains, AxisLaw, Wrenches
from mobius.control.governor import AXES, ScalarGovernor, axis_set
from mobius.errors import InvalidInput

NONE = np.zeros((1, 6))
NO = np.zeros((1, 6), dtype=bool)


def heard(z: float, *, fresh: bool = True) -> Wrenches:
    w = np.array([[0.0, 0.0, z, 0.0, 0.0, 0.0]])
    return Wrenches(w, w, np.array([fresh]), NO)


def controller(**changes) -> Admittance:
    return Admittance([AdmittanceConfig(**changes)])


def six(z: float, other: float = 0.0) -> np.ndarray:
    return np.array([other, other, z, other, other, other])


def test_each_axis_runs_the_very_law_that_governors_are_built_from():
    c = controller(stiffness=six(200.0, 5.0), integral_force=six(0.5), integral_position=six(20.0))
    lti = AxisLaw(c.configs[0].axis(2)).matrices()
    s, rng = np.zeros(4), np.random.default_rng(0)
    for _ in range(200):
        f, r = rng.normal(0, 3), np.array([rng.normal(0, 0.01), rng.normal(0, 2)])
        x_ref, w_ref = six(r[0])[None], six(r[1])[None]
        motion = c.step(heard(f), x_ref, w_ref)
        s = lti.A @ s + lti.B @ r + lti.E[:, 0] * f
        np.testing.assert_allclose(c.state[0, 2], s, atol=1e-12)
    assert motion.x[0, 2] == pytest.approx(s[0])


def dropout(c: Admittance, lost: float, force: float = 12.0) -> tuple[np.ndarray, list[bool]]:
    """1 s of force, a drop-out of ``lost`` seconds, 1 s of a third of the force."""
    x, holding = [], []
    for k in range(round((2.0 + lost) / DT)):
        t = k * DT
        gone = 1.0 <= t < 1.0 + lost
        f = force if t < 1.0 else force / 3
        motion = c.step(heard(np.nan if gone else f, fresh=not gone), NONE, NONE)
        x.append(motion.x[0, 2])
        holding.append(bool(motion.holding[0]))
    return np.array(x), holding


def test_a_drop_out_of_100_ms_holds_and_never_jumps():
    """While moving with 48 mm/s the sensor is silent for 100 ms: the command comes to rest
    within v * hold_time, about 1 mm, no tick changes its speed by more than dt / hold_time of
    it, and when the wrench is back it sets off more gently than the law would."""
    c = controller(position_max=[0.5] * 6)
    x, holding = dropout(c, 0.1)
    assert np.isfinite(x).all()
    gone = np.flatnonzero(holding)
    assert len(gone) == 30
    v = np.diff(x) / DT
    assert x[gone[-1]] - x[gone[0] - 1] < 0.048 * 0.02 * 1.1
    assert abs(v[gone[-1] - 1]) < 0.001  # at rest
    onset = np.abs(np.diff(v[:250])).max()  # the law's own step at t = 0
    assert np.abs(np.diff(v[250:])).max() < 0.048 * DT / 0.02
    after = v[gone[-1] + 1 :]
    assert np.abs(np.diff(after)).max() < 0.25 * onset  # smooth
    assert after[-1] == pytest.approx(4.0 / 250, rel=1e-3)


def test_integrals_and_spring_do_nothing_without_a_wrench():
    c = controller(stiffness=six(100.0, 1.0), integral_position=six(20.0), integral_force=six(1.0))
    for _ in range(300):
        c.step(heard(10.0), NONE, NONE)
    before = c.state.copy()
    for _ in range(900):
        motion = c.step(heard(np.nan, fresh=False), NONE, NONE)
    assert motion.holding.all()
    assert c.state[0, 2, 2] == before[0, 2, 2]
    assert abs(c.state[0, 2, 0] - before[0, 2, 0]) < abs(before[0, 2, 1]) * 0.02 + 1e-12


def test_position_and_velocity_stay_inside_and_it_is_told():
    c = controller(velocity_max=[0.02] * 6, position_max=[0.01] * 6)
    fast, far = [], []
    for _ in range(600):
        motion = c.step(heard(50.0), NONE, NONE)
        assert motion.v[0, 2] <= 0.02 and motion.x[0, 2] <= 0.01
        fast.append(motion.velocity_clipped[0, 2])
        far.append(motion.position_clipped[0, 2])
    assert fast[0:5] != [False] * 5 and far[-1]
    assert motion.v[0, 2] == 0.0
    assert not motion.velocity_clipped[0, [0, 1, 3, 4, 5]].any()


def test_the_integral_does_not_wind_up_at_a_limit():
    """Pushed against the position limit for 10 s, the command leaves it at once when the push
    turns; with a wound-up integral it would stay for as long again."""
    c = controller(position_max=[0.01] * 6, integral_force=[1.0] * 6)
    for _ in range(3000):
        motion = c.step(heard(20.0), NONE, NONE)
    assert motion.position_clipped[0, 2]
    z = c.state[0, 2, 2]
    for _ in range(90):
        motion = c.step(heard(-20.0), NONE, NONE)
    assert z < 20.0 and motion.x[0, 2] < 0.0099


def test_the_integral_has_its_own_limit():
    c = controller(integral_force=[5.0] * 6, integral_max=[3.0] * 6, position_max=[9.0] * 6)
    for _ in range(600):
        motion = c.step(heard(1.0), NONE, NONE)
    assert c.state[0, 2, 2] == 3.0 and motion.integral_clipped[0, 2]


def test_axes_not_selected_follow_their_reference_and_feel_nothing():
    c = controller(selected_axes=six(0.0, 1.0).astype(bool))
    x = []
    for _ in range(60):
        motion = c.step(heard(50.0), six(0.02)[None], NONE)
        x.append(motion.x[0, 2])
    assert x[-1] == pytest.approx(0.02)
    assert np.diff(x).max() <= 0.4 * DT + 1e-12


def test_gains_may_change_while_it_runs_without_a_jump():
    c = controller(stiffness=six(100.0, 1.0))
    for _ in range(200):
        c.step(heard(8.0), NONE, NONE)
    x, v = c.state[0, 2, 0], c.state[0, 2, 1]
    c.set_gains(0, "z", AxisGains(D=500.0, K=300.0, K_f=2.0))
    motion = c.step(heard(8.0), NONE, NONE)
    assert abs(motion.x[0, 2] - x) < 0.4 * DT
    assert c.gains[0, 2].tolist() == [0.7, 500.0, 300.0, 2.0, 0.0, 0.0]
    assert abs(motion.v[0, 2] - v) < 0.05


class Half:
    """Lets half of the wished position through."""

    def __init__(self):
        self.seen = []

    def step(self, x, r):
        self.seen.append(x.copy())
        return np.array([0.5 * r[0], r[1]])


def test_a_governor_sees_the_state_and_changes_the_reference():
    governor, config = Half(), AdmittanceConfig(stiffness=[400.0] * 6, damping=[40.0] * 6)
    governed = Admittance([config], governors={(0, "z"): governor})
    plain = Admittance([config])
    for _ in range(300):
        a = governed.step(heard(0.0), six(0.04)[None], NONE)
        b = plain.step(heard(0.0), six(0.02)[None], NONE)
    np.testing.assert_allclose(a.x, b.x)
    assert a.governed[0, 2] and not a.governed[0, 0]
    assert governor.seen[-1].shape == (4,)


def test_one_governor_may_serve_several_axes_in_one_call():
    axis = replace(
        AXES[0], environment=(100.0, 100.0), disturbance=1.0, position_max=0.05, wrench_max=20.0
    )
    safe = axis_set(axis)
    config = AdmittanceConfig(stiffness=[1000.0] * 6, damping=[120.0] * 6, mass=[10.0] * 6)
    apart = Admittance(
        [config, config], governors={(1, name): ScalarGovernor(safe) for name in "zx"}
    )
    together = Admittance([config, config], governors={(1, ("z", "x")): ScalarGovernor([safe] * 2)})
    x_ref = np.zeros((2, 6))
    x_ref[1, 0], x_ref[1, 2] = 0.03, 0.09  # of these only z is too much
    w = np.zeros((2, 6))
    heard_both = Wrenches(w, w, np.ones(2, dtype=bool), w > 0)
    for _ in range(200):
        a = apart.step(heard_both, x_ref, np.zeros((2, 6)))
        b = together.step(heard_both, x_ref, np.zeros((2, 6)))
        np.testing.assert_allclose(a.x, b.x, atol=1e-12)
        np.testing.assert_array_equal(a.governed, b.governed)
    assert a.governed[1].tolist() == [False, False, True, False, False, False]
    assert not a.governed[0].any()


def test_a_restart_begins_with_the_reference_that_stands_still():
    """Left at an old reference a governor would make the arm drive there first."""
    safe = axis_set(replace(AXES[0], environment=(0.0, 0.0)))
    governor = ScalarGovernor(safe)
    axis = AXES[0]
    law = Admittance(
        [
            AdmittanceConfig(
                stiffness=[axis.stiffness] * 6, damping=[axis.damping] * 6, mass=[axis.mass] * 6
            )
        ],
        governors={(0, "z"): governor},
    )
    for _ in range(300):
        law.step(heard(0.0), six(0.06)[None], NONE)
    assert governor.v[0] == pytest.approx(0.06)
    law.reset()
    np.testing.assert_array_equal(governor.v, 0.0)
    law.reset(six(-0.03)[None])
    np.testing.assert_allclose(governor.v, [-0.03, 0.0])


@pytest.mark.parametrize("which", ["x_ref", "wrench_ref"])
def test_a_reference_that_is_no_number_holds_and_is_forgotten(which):
    gains = {"stiffness": six(200.0, 5.0), "integral_position": six(20.0)}
    c = Admittance([AdmittanceConfig(**gains)] * 2)
    w = np.zeros((2, 6))
    quiet = Wrenches(w, w, np.ones(2, dtype=bool), w > 0)
    good = np.tile(six(0.05), (2, 1))
    bad = good.copy()
    bad[0, 2] = np.nan
    for _ in range(50):
        c.step(quiet, good, w)
    for _ in range(60):
        motion = c.step(quiet, *((bad, w) if which == "x_ref" else (good, bad)))
    assert motion.holding.tolist() == [True, False]
    assert np.isfinite(c.state).all() and abs(motion.v[0, 2]) < 1e-3
    for _ in range(3000):
        motion = c.step(quiet, good, w)
    np.testing.assert_allclose(motion.x[:, 2], 0.053, atol=1e-3)


def test_references_of_the_wrong_size_are_told():
    with pytest.raises(InvalidInput, match=r"expected shape \(1, 6\)"):
        controller().step(heard(0.0), np.zeros((1, 5)), NONE)


def test_mistakes_are_told():
    for key in ((0, ()), (0, ("x", "q")), (0, ("x", "x"))):
        with pytest.raises(InvalidInput, match="governors"):
            Admittance([AdmittanceConfig()], governors={key: Half()})
    with pytest.raises(InvalidInput, match="more than one"):
        Admittance([AdmittanceConfig()], governors={(0, "x"): Half(), (0, ("x", "y")): Half()})
    with pytest.raises(InvalidInput, match="at least one configuration"):
        Admittance([])
    with pytest.raises(InvalidInput, match=r"got \(1, 'z'\)"):
        Admittance([AdmittanceConfig()], governors={(1, "z"): Half()})
    with pytest.raises(InvalidInput, match="expected an axis"):
        controller().set_gains(0, "q", AxisGains())
