"""Soft servos, then firm ones where the robot came to rest."""

from dataclasses import replace

import numpy as np

from mobius.model.robot import keyframe_joints
from mobius.modes import DampedHold
from mobius.types import Mode, ModeCommand

CRAWL = keyframe_joints("crawl")[0]
STOP = ModeCommand(Mode.STOP, np.zeros(3), 0.0)


def act(hold, belief_of, frame_of, t, q, rate):
    return hold.act(STOP, belief_of(t), frame_of(t, q, np.full(22, rate))).q


def test_targets_are_the_measured_angles_while_anything_moves(belief_of, frame_of):
    hold = DampedHold()
    for k in range(300):
        q = CRAWL + 1e-3 * k
        np.testing.assert_array_equal(act(hold, belief_of, frame_of, k / 300, q, 0.5), q)
    assert not hold.resting


def test_it_holds_the_angles_at_which_it_came_to_rest(belief_of, frame_of):
    hold = DampedHold()
    for k in range(70):
        act(hold, belief_of, frame_of, k / 300, CRAWL, 0.0)
    assert hold.resting
    np.testing.assert_array_equal(act(hold, belief_of, frame_of, 1.0, CRAWL + 0.3, 2.0), CRAWL)
    hold.reset()
    assert not hold.resting


def test_it_does_not_stay_soft_for_ever(belief_of, frame_of):
    hold = DampedHold()
    for k in range(620):
        act(hold, belief_of, frame_of, k / 300, CRAWL, 0.5)
    assert hold.resting


def test_who_waits_for_the_trunk_alone_does_not_look_at_joints(belief_of, frame_of):
    hold = DampedHold(joints_too=False)
    for k in range(70):
        act(hold, belief_of, frame_of, k / 300, CRAWL, 0.5)
    assert hold.resting


def test_a_robot_in_free_fall_does_not_rest(belief_of, frame_of):
    hold = DampedHold()
    for k in range(150):
        falling = replace(frame_of(k / 300, CRAWL), accel_I=np.array([0.0, 0.0, 0.3]))
        hold.act(STOP, belief_of(k / 300), falling)
    assert not hold.resting
