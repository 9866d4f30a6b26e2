"""Every reward term by hand on two robots: one at rest, one that errs."""

import numpy as np
import pytest

from mobius.train.rewards import TERMS, WEIGHTS, Signals, total


def signals(**change) -> Signals:
    """Two robots, two joints, four feet; all quiet, on the ground, commanded to stand."""
    n, k, f = 2, 2, 4
    base = dict(
        command=np.zeros((n, 3)),
        moving=np.zeros(n),
        swing=np.zeros((n, f)),
        contact_wanted=np.ones((n, f)),
        velocity=np.zeros((n, 3)),
        v_z=np.zeros(n),
        w_xy=np.zeros((n, 2)),
        gravity_xy=np.zeros((n, 2)),
        height_error=np.zeros(n),
        q_error=np.zeros((n, k)),
        torque=np.zeros((n, 20)),
        speed=np.zeros((n, 20)),
        torque_limit=np.full(20, 10.0),
        action=np.zeros((n, k)),
        action_1=np.zeros((n, k)),
        action_2=np.zeros((n, k)),
        contact=np.ones((n, f)),
        touching=np.ones((n, f)),
        touchdown=np.zeros((n, f)),
        air_time=np.zeros((n, f)),
        contact_time=np.ones((n, f)),
        foot_height=np.zeros((n, f)),
        foot_speed=np.zeros((n, f)),
        foot_tilt=np.zeros((n, f)),
        landing_speed=np.zeros((n, f)),
        landing_drag=np.zeros((n, f)),
        lifted_early=np.zeros((n, f)),
        fallen=np.zeros(n),
        early=np.ones(n),
        swing_top=0.045,
        sigma_linear=0.25,
        sigma_yaw=0.25,
    )
    return Signals(**{**base, **change})


def second(name: str, **change) -> float:
    """Value of a term for the second robot, which alone differs from rest."""
    quiet = signals()
    for key, value in change.items():
        array = getattr(quiet, key)
        if np.ndim(array):
            array[1] = value
        else:
            setattr(quiet, key, value)
    value = TERMS[name](quiet)
    assert value.shape == (2,)
    return float(value[1])


@pytest.mark.parametrize(
    ("name", "change", "want"),
    [
        ("tracking_linear", dict(command=[0.5, 0, 0]), np.exp(-1.0)),  # 0.25 / 0.25
        ("tracking_yaw", dict(command=[0, 0, 0.5]), np.exp(-1.0)),
        ("vertical_velocity", dict(v_z=0.3), 0.09),
        ("tilt_rate", dict(w_xy=[1.0, 2.0]), 5.0),
        ("power", dict(torque=-2.0, speed=0.5), 20.0),  # 20 joints of |-2 * 0.5|
        ("action_rate", dict(action=[1.0, -1.0]), 2.0),
        ("action_acceleration", dict(action=[1.0, 0.0], action_1=[2.0, 0.0]), 9.0),
        ("stand_still", dict(q_error=[0.1, -0.2]), 0.3),
        ("stand_still", dict(q_error=[0.1, -0.2], moving=1.0), 0.0),
        ("air_time", dict(air_time=0.25, touchdown=[1, 0, 0, 0], moving=1.0), 0.15),
        ("air_time", dict(air_time=0.25, touchdown=[1, 0, 0, 0]), 0.0),
        ("contact", dict(moving=1.0), 4.0),
        ("contact", dict(moving=1.0, contact_time=0.05), 0.0),
        ("slip", dict(foot_speed=0.5), 1.0),
        ("slip", dict(foot_speed=0.5, contact=0.0), 0.0),
        ("termination", dict(fallen=1.0), 1.0),
        ("termination", dict(fallen=1.0, early=0.0), 0.0),
        ("fall", dict(fallen=1.0, early=0.0), 1.0),
        ("tracking_far", dict(command=[0.4, 0, 0]), np.exp(-1.0)),
        ("joint_speed", dict(speed=0.85 * 50 * np.pi / 30 + 0.1), 20 * 0.01),
        ("impact", dict(touchdown=[1, 0, 0, 0], landing_speed=-0.5), 0.25),
        ("landing", dict(touchdown=[1, 0, 0, 0], landing_drag=0.5), 0.25),
        ("skim", dict(foot_speed=2.0, foot_height=[0.0, 0.006, 0.012, 0.1]), 4.0 + 2.0),
        ("skim", dict(foot_speed=2.0, foot_height=[-0.001, 0.1, 0.1, 0.1]), 4.0),
        ("creep", dict(foot_speed=0.1, contact=[1, 0, 1, 1]), 0.3),
        ("chatter", dict(lifted_early=[1, 0, 1, 0]), 2.0),
        ("flat_foot", dict(foot_tilt=[0.1, 0.2, 0, 0], contact=[1, 0, 1, 1]), 0.1),
        ("alive", {}, 1.0),
        ("orientation", dict(gravity_xy=[0.3, 0.4]), 0.25),
        ("height", dict(height_error=-0.05), 0.0025),
        ("height", dict(height_error=0.5), 0.01),
        ("height_band", dict(height_error=-0.05), 0.03),
        ("height_band", dict(height_error=0.019), 0.0),
        ("economy", dict(torque=-2.0, speed=0.5, command=[0.3, 0.3, 1.0]), 20.0),
        ("economy", dict(torque=-2.0, speed=0.5, command=[0.525, 0.0, 0.0]), 10.0),
        ("economy", dict(torque=-2.0, speed=0.5, command=[-0.6, 0.1, 0.0]), 0.0),
        ("torque", dict(torque=2.0), 80.0),
        ("saturation", dict(torque=9.0), 2.0),  # 20 joints, 0.9 - 0.8 of stall
        ("pose", dict(q_error=[0.1, 0.2]), 0.05),
        ("gait", {}, 1.0),  # standing, all feet down, as the clock wants
        ("gait", dict(contact_wanted=[-1, 1, 1, -1]), 0.0),  # two right, two wrong
        ("gait", dict(contact_wanted=[-1, 1, 1, -1], contact=[0, 1, 1, 0]), 1.0),
        ("gait", dict(contact_wanted=[0, 1, 1, 0], contact=[0, 1, 1, 1]), 1.0),  # 0: either
        ("scuff", dict(swing=[0.7, 0, 0.2, 0.4], touching=[1, 1, 0, 1]), 1.1),
        ("swing_height", dict(swing=[1, 0, 0, 0]), 0.25),  # one of four misses by all of it
        ("swing_height", dict(swing=[1, 0, 0, 0], foot_height=[0.045, 0, 0, 0]), 0.0),
    ],
)
def test_term_by_hand(name, change, want):
    assert second(name, **change) == pytest.approx(want)


def test_every_term_has_a_weight_and_every_weight_a_term():
    assert set(WEIGHTS) == set(TERMS)


def test_weight_zero_switches_a_term_off():
    s = signals(v_z=np.array([0.0, 1.0]))
    on, means = total(s, {"vertical_velocity": -2.0})
    off, none = total(s, {"vertical_velocity": 0.0})
    np.testing.assert_allclose(on, [0.0, -2.0])
    np.testing.assert_allclose(off, 0.0)
    assert means == {"vertical_velocity": -1.0} and none == {}
