"""Parameters, their names in ROS, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest

from mobius.control.admittance import AdmittanceConfig, from_ros, mobius_config
from mobius.errors import InvalidInput, UnknownName


def test_damping_ratio_is_that_of_ros():
    """D = 2 * 0.7 * sqrt(1 * 400) = 28."""
    c = AdmittanceConfig(mass=[1.0] * 6, stiffness=[400.0] * 6, damping_ratio=[0.7] * 6)
    np.testing.assert_allclose(c.D, 28.0)


def test_a_damping_ratio_without_stiffness_is_refused_since_it_damps_nothing():
    with pytest.raises(InvalidInput, match=r"stiffness 0 .* \(y\); give damping"):
        AdmittanceConfig(stiffness=[1, 0, 1, 1, 1, 1], damping_ratio=[1.0] * 6)


def test_parameters_of_an_admittance_controller_are_understood():
    c = from_ros(
        {
            "ft_sensor.name": "left_wrist",
            "ft_sensor.frame.id": "left_wrist_ft",
            "ft_sensor.filter_coefficient": 0.2,
            "control.frame.id": "base_link",
            "gravity_compensation.CoG.pos": [0.0, 0.0, -0.01],
            "gravity_compensation.CoG.force": 4.5,
            "admittance.selected_axes": [True, True, True, False, False, False],
            "admittance.mass": [3.0] * 6,
            "admittance.damping_ratio": [2.0] * 6,
            "admittance.stiffness": [50.0] * 6,
            "force_gain": [0.5] * 6,
        }
    )
    assert c.ft_sensor.frame_id == "left_wrist_ft"
    assert c.gravity_compensation.cog_force == 4.5
    assert c.axis(0).K == 50.0 and c.axis(0).K_f == 0.5
    assert c.selected_axes.tolist() == [True] * 3 + [False] * 3


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"mass": [1.0] * 5}, r"mass: expected shape \(6,\), got \(5,\)"),
        ({"mass": [0.0] + [1.0] * 5}, "mass: expected numbers > 0"),
        ({"stiffness": [-1.0] * 6}, "axis x: AxisGains.K"),
        ({"damping": [1.0] * 6, "damping_ratio": [1.0] * 6}, "got both"),
        ({"velocity_min": [0.1] * 6}, "expected velocity_min < 0 < velocity_max"),
        ({"position_max": [-1.0] * 6}, "expected position_min < 0 < position_max"),
        ({"integral_position": [1e6] * 6}, "axis x: AxisGains: the free axis is unstable"),
        ({"force_gain": [float("nan")] * 6}, "expected finite numbers"),
        ({"integral_max": [0.0] * 6}, "integral_max"),
        ({"resume_time": 0.0}, "resume_time"),
    ],
)
def test_what_cannot_work_is_refused_at_construction(changes, told):
    with pytest.raises(InvalidInput, match=told):
        AdmittanceConfig(**changes)


def test_a_configuration_can_be_changed_in_one_place():
    c = replace(AdmittanceConfig(), stiffness=[100.0] * 6, damping_ratio=[1.0] * 6)
    assert c.D[0] == pytest.approx(2 * np.sqrt(0.7 * 100.0))
    assert replace(c, mass=[2.8] * 6).D[0] == pytest.approx(2 * np.sqrt(2.8 * 100.0))
    d = mobius_config(damping=[300.0] * 6)
    assert replace(d, stiffness=[5.0] * 6).D.tolist() == [300.0] * 6


def test_our_own_parameters_of_the_sensor_go_by_their_names():
    c = from_ros({"ft_sensor.sign": -1, "ft_sensor.timeout": 0.02, "ft_sensor.deadband": [0.5] * 6})
    assert (c.ft_sensor.sign, c.ft_sensor.timeout) == (-1, 0.02)
    with pytest.raises(UnknownName, match="'D'"):
        from_ros({"D": [1.0] * 6})


def test_unknown_names_are_told_with_the_nearest():
    with pytest.raises(UnknownName, match=r"Did you mean 'admittance\.stiffness'"):
        from_ros({"admittance.stifness": [1.0] * 6})
    with pytest.raises(UnknownName, match="base_link"):
        AdmittanceConfig(control_frame_id="base_lnk")


def test_a_configuration_cannot_be_written():
    with pytest.raises(ValueError):
        AdmittanceConfig().stiffness[0] = 1.0
