"""Eq. (2) and the gait clock."""

from dataclasses import replace

import numpy as np
import pytest

from mobius.control.action import ActionFilter
from mobius.control.bodies import body_of
from mobius.control.clock import MOVE_GATE, GaitClock

GAIT = replace(body_of("crawl").gait, quicken=0.0)


def test_moving_average_by_hand():
    """a_scale 0.3, three actions: after 1, 2, 3 the target is default + 0.3 * mean(3, 2, 1)."""
    f = ActionFilter(np.array([0.1]), np.array([-9.0]), np.array([9.0]))
    f.push(np.array([[1.0]]))
    f.push(np.array([[2.0]]))
    np.testing.assert_allclose(f.push(np.array([[3.0]])), [[0.1 + 0.3 * 2.0]])
    np.testing.assert_allclose(f.last, [[3.0]])


def test_first_action_is_a_third():
    f = ActionFilter(np.zeros(1), -np.ones(1), np.ones(1))
    np.testing.assert_allclose(f.push(np.array([[1.0]])), [[0.1]])


def test_targets_stay_inside_the_limits():
    f = ActionFilter(np.zeros(2), np.array([-0.2, -1]), np.array([0.2, 1]), n=3)
    for _ in range(4):
        out = f.push(np.full((3, 2), 50.0))
    np.testing.assert_allclose(out, np.tile([0.2, 1.0], (3, 1)))


def test_reset_forgets_only_the_chosen():
    f = ActionFilter(np.zeros(1), -np.ones(1), np.ones(1), n=2)
    f.push(np.ones((2, 1)))
    f.reset(np.array([True, False]))
    np.testing.assert_allclose(f.push(np.zeros((2, 1)))[:, 0], [0.0, 0.1])


def test_clock_runs_only_when_asked_to_move():
    clock = GaitClock(GAIT, 2)
    command = np.array([[0.3, 0.0, 0.0], [0.5 * MOVE_GATE, 0.0, 0.0]])
    for _ in range(7):
        clock.advance(command, GAIT.period / 28)
    np.testing.assert_allclose(clock.phase, [0.25, 0.0])
    np.testing.assert_allclose(clock.observe(), [[1.0, 0.0], [0.0, 0.0]], atol=1e-12)
    assert (clock.swing_wanted()[1] == 0).all()


def test_diagonal_limbs_swing_together_and_never_all():
    clock = GaitClock(GAIT, 50)
    clock.reset(phase=np.linspace(0, 1, 50, endpoint=False))
    clock.advance(np.ones((50, 3)), 0.0)
    swing = clock.swing_wanted()
    np.testing.assert_allclose(swing[:, 0], swing[:, 3])  # left arm, right leg
    np.testing.assert_allclose(swing[:, 1], swing[:, 2])
    assert ((swing > 0).sum(axis=1) <= 2).all()
    assert (swing[:, 0] > 0).any() and (swing[:, 1] > 0).any()


def test_slack_leaves_both_ends_of_a_swing_to_the_feet():
    phase = np.linspace(0, 1, 100, endpoint=False)
    wanted = {}
    for slack in (0.0, 0.06):
        clock = GaitClock(replace(GAIT, swing=(0.03, 0.47), slack=slack), 100)
        clock.reset(phase=phase)
        clock.advance(np.ones((100, 3)), 0.0)
        wanted[slack] = clock.contact_wanted()[:, 0]  # its offset is 0
        np.testing.assert_array_equal(
            clock.swing_wanted()[:, 0] > 0, (phase > 0.03) & (phase < 0.47)
        )
    inside = (phase > 0.03) & (phase < 0.47)
    np.testing.assert_array_equal(wanted[0.0], np.where(inside, -1, 1))
    assert (wanted[0.06][(phase > 0.10) & (phase < 0.40)] == -1).all()
    assert (wanted[0.06][(phase > 0.54) & (phase < 0.96)] == 1).all()
    assert (wanted[0.06][[0, 5, 43, 50, 99]] == 0).all()
    clock = GaitClock(replace(GAIT, slack=0.06), 100)
    clock.reset(phase=phase)
    assert (clock.contact_wanted() == 1).all()  # standing


def test_a_stepping_robot_may_sway_and_still_come_to_rest():
    gait = replace(GAIT, unrest=0.15, settled=0.25)
    clock, still = GaitClock(gait, 3), np.zeros((3, 3))
    clock.advance(still, 0.01, np.array([0.1, 0.2, 0.3]))  # standing: 0.15 wakes
    assert clock.moving.tolist() == [False, True, True]
    for _ in range(round(1.5 * gait.period / 0.01)):
        clock.advance(still, 0.01, np.array([0.1, 0.2, 0.3]))
        if not clock.moving[1]:
            break
    assert clock.moving.tolist() == [False, False, True]  # stepping: 0.2 is calm


def test_a_shoved_robot_s_clock_runs_until_a_whole_period_was_calm():
    gait = replace(GAIT, unrest=0.15)
    clock, still = GaitClock(gait, 2), np.zeros((2, 3))
    clock.advance(still, 0.01, np.array([0.1, 0.2]))
    assert clock.moving.tolist() == [False, True]
    assert clock.phase[0] == 0 and clock.phase[1] > 0
    steps = 0
    while clock.moving[1]:
        clock.advance(still, 0.01, 0.0)
        steps += 1
    assert steps == pytest.approx(gait.period / 0.01, abs=1)
    clock.advance(still, 0.01, 0.3)
    assert clock.moving.all()
    clock.reset()
    clock.advance(still, 0.01)
    assert not clock.moving.any()


def test_strides_quicken_with_the_commanded_speed():
    clock = GaitClock(replace(GAIT, period=0.5, quicken=0.4), 2)
    clock.advance(np.array([[0.5, 0.0, 0.0], [0.0, 0.0, 1.0]]), 0.1)
    np.testing.assert_allclose(clock.phase, [0.2 * 1.2, 0.2])
