"""Whole-body inverse kinematics against the forward kinematics and the stances."""

import numpy as np
import pytest

from mobius.errors import InvalidInput
from mobius.model.arm import gripper_pose
from mobius.model.dimensions import limb_geometry
from mobius.model.joints import LIMB_JOINTS
from mobius.model.leg import sole_position
from mobius.model.poses import TRUNK_HEIGHT_CRAWL, Stance, crawl_joints
from mobius.model.reach import (
    arm_joints,
    body_joints,
    ends,
    leg_joints,
    longest_step,
    nose_up,
)

HAND, FOOT = np.array([0.24, 0.25, 0.0]), np.array([-0.2, 0.24, 0.0])
MIRROR = np.array([1.0, -1.0, 1.0])


def test_the_crawl_stance_comes_back_from_where_its_hands_and_feet_are():
    q, p = crawl_joints(), np.array([0.0, 0.0, TRUNK_HEIGHT_CRAWL])
    hands, feet = [], []
    for limb, joints in LIMB_JOINTS.items():
        g = limb_geometry(limb)
        if g.is_arm:
            hands.append(p + gripper_pose(g, q[joints])[0])
        else:
            feet.append(p + sole_position(g, q[joints]))
    again = body_joints(np.eye(3), p, hands_M=hands, feet_M=feet)
    np.testing.assert_allclose(again, q, atol=1e-9)


def test_the_ends_of_the_limbs_are_left_hand_right_hand_left_foot_right_foot():
    hand, foot = np.array([0.2603, 0.2658]), np.array([-0.2215, 0.2591])
    mirror = np.array([1.0, -1.0])
    expected = [hand, hand * mirror, foot, foot * mirror]
    np.testing.assert_allclose(ends(crawl_joints())[:, :2], expected, atol=1e-3)
    np.testing.assert_allclose(ends(crawl_joints())[:, 2], -TRUNK_HEIGHT_CRAWL, atol=1e-9)


def test_the_longest_step_is_that_of_the_foot_that_has_farthest_to_go():
    """Hands 0.20 m out, feet 0.17 m, all straight out; then hands 0.05 and feet 0.02 further."""
    a, b = Stance(0.20, 0.0, 0.17, 0.0).joints(), Stance(0.25, 0.0, 0.19, 0.0).joints()
    assert longest_step(a, b) == pytest.approx(0.05) == longest_step(b, a)
    assert longest_step(a, a) == 0.0


@pytest.mark.parametrize("angle", [0.0, 0.2, 0.5])
@pytest.mark.parametrize("side", ["left", "right"])
def test_fingertips_reach_their_place_and_point_along_the_tilt(angle: float, side: str):
    R, p = nose_up(angle), np.array([0.0, 0.0, 0.3])
    place = HAND * (1 if side == "left" else MIRROR)
    g = limb_geometry(f"{side}_arm")
    tip, R_BG = gripper_pose(g, arm_joints(f"{side}_arm", R, p, place))
    np.testing.assert_allclose(p + R @ tip, place, atol=2e-4)
    assert (R @ R_BG)[2, 2] > 0.85  # the arm's plane leans with the trunk, not more


def test_the_sole_is_flat_where_the_legs_plane_is_upright():
    angle = np.radians(40.0)
    R, p = nose_up(angle), np.array([-0.1, 0.0, 0.36])
    g = limb_geometry("left_leg")
    place = np.array([-0.1, g.hip_B[1], 0.0])
    q = leg_joints("left_leg", R, p, place)
    np.testing.assert_allclose(p + R @ sole_position(g, q), place, atol=1e-9)


def test_both_sides_mirror():
    q = body_joints(
        np.eye(3), (0, 0, 0.27), hands_M=(HAND, HAND * MIRROR), feet_M=(FOOT, FOOT * MIRROR)
    )
    for kind in ("arm", "leg"):
        left, right = q[LIMB_JOINTS[f"left_{kind}"]], q[LIMB_JOINTS[f"right_{kind}"]]
        np.testing.assert_allclose(left[0], -right[0], atol=1e-12)
        np.testing.assert_allclose(left[1:4], right[1:4], atol=1e-12)


def test_limbs_without_a_place_keep_their_joints():
    keep = np.linspace(-0.3, 0.3, 22)
    q = body_joints(np.eye(3), (0, 0, 0.27), hands_M=(HAND, None), keep=keep)
    np.testing.assert_array_equal(q[6:], keep[6:])
    assert not np.allclose(q[:4], keep[:4])


def test_a_place_out_of_reach_is_named():
    with pytest.raises(InvalidInput, match=r"right_arm.*within reach"):
        body_joints(np.eye(3), (0, 0, 0.27), hands_M=(HAND, (2.0, 0.0, 0.0)))
