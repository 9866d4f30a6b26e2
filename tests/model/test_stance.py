"""Stances other than the keyframe: where the feet stand, and that the robot can stand so."""

from itertools import product

import numpy as np
import pytest

from mobius.model import arm, leg, robot
from mobius.model.dimensions import limb_geometry
from mobius.model.joints import LIMB_JOINTS
from mobius.model.poses import Stance, crawl_joints, overlap, stance_keyframe
from mobius.train.presets import WIDE
from mobius.types import LIMBS


def feet_of(q):
    """(4, 3) soles and fingertips from their yaw axes [m]."""
    tips = []
    for limb in LIMBS:
        g, at = limb_geometry(limb), LIMB_JOINTS[limb]
        tip = arm.gripper_pose(g, q[at])[0] if g.is_arm else leg.sole_position(g, q[at])
        tips.append(tip - g.hip_B)
    return np.array(tips)


def test_the_stance_of_the_keyframe_is_the_keyframe():
    x, y, _ = np.abs(feet_of(crawl_joints())).T
    r, turn = np.hypot(x, y), np.arctan2(x, y)
    stance = Stance(r[0], turn[0], r[2], turn[2])
    np.testing.assert_allclose(stance.joints(), crawl_joints(), atol=1e-12)


@pytest.mark.parametrize(("r", "turn"), [*product((0.18, 0.24), (0.0, 0.3))])
def test_feet_stand_where_they_are_asked_to(r, turn):
    feet = feet_of(Stance(r, turn, r, turn).joints())
    across, along = r * np.cos(turn), r * np.sin(turn)
    want = [[x * along, y * across, -0.275] for x in (1, -1) for y in (1, -1)]
    np.testing.assert_allclose(feet, want, atol=1e-12)


def test_the_wide_stance_is_held_inside_the_limits_and_touches_nothing():
    qpos, ctrl = stance_keyframe(WIDE)
    low, high = robot.joint_limits()
    assert np.minimum(ctrl - low, high - ctrl)[:20].min() > 0.15
    assert overlap(robot.load_model("full"), qpos) < 1e-4
    assert np.abs(ctrl - WIDE.joints()).max() < 0.1
