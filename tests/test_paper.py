"""The printed numbers against one another: sums, counts and the contradictions we resolve."""

import dataclasses
from math import sqrt

import pytest

from mobius import paper
from mobius.types import LIMBS, Mode

G = 9.81


def test_the_papers_limb_numbers_are_our_four_limbs():
    assert set(paper.LIMB_NUMBER) == set(LIMBS)
    assert sorted(paper.LIMB_NUMBER.values()) == [0, 1, 2, 3]


@pytest.mark.parametrize(("mode", "frame"), [("biped", 26), ("crawl", 38)])
def test_seven_trunk_numbers_and_fifteen_past_frames_give_the_printed_observation(mode, frame):
    # biped 7 + 8 + 8 + 3 = 26, 26 * 16 = 416; crawl 7 + 14 + 14 + 3 = 38, 38 * 16 = 608
    size = paper.OBSERVATION[mode]
    assert size.frame == frame
    assert size.total == size.printed_total == frame * 16


def test_the_printed_ten_trunk_numbers_would_not_give_it():
    size = dataclasses.replace(paper.OBSERVATION["biped"], trunk=10)
    assert size.total != size.printed_total


def test_fifty_rpm_is_5_236_rad_per_s():
    assert paper.TABLE_I.max_motor_speed == pytest.approx(5.23599, abs=1e-5)


def test_tables_have_the_printed_number_of_rows():
    assert len(paper.TABLE_II.terms) == len(set(paper.TABLE_II.terms)) == 11
    assert len(dataclasses.fields(paper.TABLE_III)) == 13


def test_row_20_and_21_both_printed_ends_are_equal_and_the_resolved_are_symmetric():
    for printed in (paper.TABLE_III.initial_joints, paper.TABLE_III.body_mass):
        assert printed.low == printed.high
    for resolved in (paper.INITIAL_JOINTS_RESOLVED, paper.BODY_MASS_V3):
        assert resolved.low == -resolved.high < 0


def test_row_61_a_600_hz_clock_divides_every_rate():
    assert all(600 % hz == 0 for hz in dataclasses.asdict(paper.RATES).values())


def test_324_combinations_count_the_horizon_and_81_do_not():
    sweep = paper.TABLE_VII
    without_T = len(sweep.W_exp) * len(sweep.W_goal) * len(sweep.epsilon) * len(sweep.M)
    assert without_T == 81
    assert without_T * len(sweep.T) == paper.PLAN_COMBINATIONS


def test_row_47_the_best_weights_are_not_in_the_tested_ranges():
    assert all(row.W_exp not in paper.TABLE_VII.W_exp for row in paper.TABLE_VI_MULTI)
    assert all(row.W_exp in paper.TABLE_VII.W_exp for row in paper.TABLE_VI_SINGLE.values())


@pytest.mark.parametrize(("mode", "least"), [("biped", 38), ("crawl", 19), ("roll", 13)])
def test_row_39_one_axis_a_step_explains_the_best_horizon_of_table_vi(mode, least):
    """Corner to corner of 20 x 20 cells is 19 + 19 = 38 cells, one axis at a time."""
    step = max(paper.STEPS[mode])
    assert -(-38 // step) == least
    enough = min(T for T in paper.TABLE_VII.T if least <= T)
    assert enough == paper.TABLE_VI_SINGLE[mode].T


def test_row_49_the_third_versions_cost_of_transport_sides_with_the_table():
    for mode, printed in paper.COST_OF_TRANSPORT_V3.items():
        energy = paper.TABLE_VI_SINGLE[mode].energy
        assert energy / (paper.MASS * G * paper.CELL) == pytest.approx(printed, abs=5e-4)
    swapped = paper.TEXT_V_F_ENERGY
    assert swapped["biped"] == paper.TABLE_VI_SINGLE["roll"].energy
    assert swapped["roll"] == paper.TABLE_VI_SINGLE["biped"].energy


def test_row_51_every_sum_of_table_viii_holds_but_rolling():
    off = [
        name
        for name, row in paper.TABLE_VIII.items()
        if row.kinetic + row.potential != pytest.approx(row.total, abs=5e-3)
    ]
    assert off == ["roll"]
    fixed = paper.TABLE_VIII_ROLL_V3
    assert fixed.kinetic + fixed.potential == fixed.total


@pytest.mark.parametrize(
    ("mode", "lift"), [("crawl", 0.6), ("pull_up", 0.6), ("climb", 3.0), ("biped", 1.048)]
)
def test_row_51_potential_energy_is_the_weight_times_a_lift(mode, lift):
    assert paper.TABLE_VIII[mode].potential / (paper.MASS * G) == pytest.approx(lift, abs=5e-4)


def test_row_53_rolling_is_75_percent_faster_than_crawling():
    v = paper.MAX_SPEED
    assert 100 * (v["roll"] / v["biped"] - 1) == pytest.approx(paper.ROLL_FASTER_PERCENT["biped"])
    assert 100 * (v["roll"] / v["crawl"] - 1) == pytest.approx(75.0)
    assert 100 * (v["roll"] / 0.3 - 1) == pytest.approx(
        paper.ROLL_FASTER_PERCENT["crawl"], abs=5e-3
    )


def test_row_55_the_printed_damping_is_that_of_the_pid_polynomial():
    # K_d s^2 + K_p s + K_i: zeta = 3 / (2 sqrt(4.5)) = 0.707
    servo = paper.VISUAL_SERVO
    zeta = servo.K_p / (2 * sqrt(servo.K_i * servo.K_d))
    assert zeta == pytest.approx(0.7071, abs=1e-4)
    assert round(zeta, 1) == servo.damping


def test_row_59_one_gripper_holds_1_27_weights():
    assert paper.TABLE_IX["z"].mean / (paper.MASS * G) == pytest.approx(1.266, abs=1e-3)


def test_a_mode_is_a_key_of_the_mode_tables():
    assert paper.MAX_SPEED[Mode.CRAWL] == 0.4
    assert paper.STEPS[Mode.ROLL] == (-3, 3)


def test_nobody_can_change_a_printed_number():
    with pytest.raises(TypeError):
        paper.MAX_SPEED["roll"] = 1.0  # type: ignore[index]
    with pytest.raises(dataclasses.FrozenInstanceError):
        paper.TABLE_I.action_scale = 1.0  # type: ignore[misc]
