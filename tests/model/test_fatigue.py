"""Eq. (1) and the S-N curve: scaling laws first, then the numbers of Fig. 5 by hand."""

import numpy as np
import pytest

from mobius.errors import InvalidInput
from mobius.model.fatigue import (
    ARM_GEAR,
    LEG_GEAR,
    SN_COEFFICIENT,
    SN_EXPONENT,
    bending_stress,
    cycles_to_failure,
    stress_for_life,
)
from mobius.paper import GEAR_FATIGUE

MPA = 1e6


def test_stress_is_proportional_to_load_and_inverse_in_module_and_geometry_factor():
    one = bending_stress(50e3, 0.4e-3, J=0.4)
    assert bending_stress(100e3, 0.4e-3, J=0.4) == pytest.approx(2 * one)
    assert bending_stress(50e3, 0.8e-3, J=0.4) == pytest.approx(one / 2)
    assert bending_stress(50e3, 0.4e-3, J=0.2) == pytest.approx(2 * one)


def test_bending_stress_by_hand():
    # 40 kN/m / (0.5 mm * 0.4) = 200 MPa; * K_a K_m = 2 * 1.5 = 3 -> 600 MPa
    assert bending_stress(40e3, 0.5e-3, J=0.4) == pytest.approx(600 * MPA)
    # a dynamic factor divides, the others multiply: 600 / 0.8 * 1.1 * 1.2 * 1.4 = 1386 MPa
    all_factors = bending_stress(40e3, 0.5e-3, J=0.4, K_v=0.8, K_S=1.1, K_B=1.2, K_I=1.4)
    assert all_factors == pytest.approx(1386 * MPA)


def test_stress_and_life_are_inverse_of_one_another():
    N = np.geomspace(1e3, 1e7, 9)
    np.testing.assert_allclose(cycles_to_failure(stress_for_life(N)), N, rtol=1e-12)
    assert (np.diff(stress_for_life(N)) < 0).all()


def test_the_sn_line_is_the_one_through_both_printed_points():
    # k = ln(986 / 496) / ln(280000 / 7200) = 0.687084 / 3.660710 = 0.18769
    assert pytest.approx(0.18769, abs=1e-5) == SN_EXPONENT
    assert pytest.approx(5222 * MPA, rel=1e-4) == SN_COEFFICIENT
    assert cycles_to_failure(496 * MPA) == pytest.approx(2.8e5)
    assert cycles_to_failure(986 * MPA) == pytest.approx(7.2e3)


def test_life_between_the_points_by_hand():
    # at the geometric mean of the stresses, the geometric mean of the lives:
    # sqrt(496 * 986) = 699.326 MPa -> sqrt(2.8e5 * 7.2e3) = 44899.9 cycles
    assert cycles_to_failure(699.326 * MPA) == pytest.approx(44899.9, rel=1e-4)


def test_the_calibrated_load_area_is_that_of_the_arm_gear():
    # A = 2.5 N m * 3 / (0.4 mm * 986 MPa) = 19.016 mm^2, and the leg differs in module only
    assert ARM_GEAR.load_area == pytest.approx(19.016e-6, rel=1e-4)
    assert LEG_GEAR.load_area == ARM_GEAR.load_area


def test_the_leg_module_that_the_two_printed_stresses_imply():
    # 0.4 mm * 986 / 496 = 0.7952 mm; the standard 0.8 mm would give 986 / 2 = 493 MPa
    assert LEG_GEAR.m == pytest.approx(0.7952e-3, abs=1e-7)
    assert bending_stress(2.5 / LEG_GEAR.load_area, 0.8e-3, J=1.0) == pytest.approx(493 * MPA)


def test_a_gear_carries_the_printed_peak_torque_for_the_printed_life():
    torque = GEAR_FATIGUE.peak_torque
    assert ARM_GEAR.stress(torque) == pytest.approx(986 * MPA)
    assert ARM_GEAR.life(-torque) == pytest.approx(7.2e3)
    assert LEG_GEAR.life(torque) == pytest.approx(2.8e5)
    # twice the torque costs a factor 2^(1/k) = 2^5.328 = 40.2 in life
    assert LEG_GEAR.life(torque) / LEG_GEAR.life(2 * torque) == pytest.approx(40.2, rel=1e-3)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: bending_stress(1.0, 0.0, J=0.4), "module m: expected m > 0, got 0.0"),
        (lambda: bending_stress(1.0, 1.0, J=-1), "geometry factor J: expected > 0, got -1"),
        (lambda: cycles_to_failure(-5e6), "stress sigma: expected Pa > 0, got -5000000.0"),
        (lambda: stress_for_life(0), "life N: expected cycles > 0, got 0"),
        (lambda: cycles_to_failure(np.nan), "stress sigma: expected Pa > 0, got nan"),
    ],
)
def test_impossible_gears_are_refused_in_one_line(call, message):
    with pytest.raises(InvalidInput) as error:
        call()
    assert str(error.value) == message
