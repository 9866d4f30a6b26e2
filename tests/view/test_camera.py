"""The camera stays behind the robot, moves smoothly and looks over walls."""

import mujoco
import numpy as np
import pytest

from mobius.errors import InvalidInput
from mobius.view.camera import ChaseCamera, chase, free_joint

BALL = """
<mujoco>
  <worldbody>
    <light pos="0 0 3"/>
    <geom type="plane" size="0 0 1"/>
    {walls}
    <body name="cart"><joint type="slide"/><geom size=".01"/></body>
    <body pos="0 0 0.2"><freejoint/><geom type="box" size=".2 .1 .05" rgba="1 0 0 1"/></body>
  </worldbody>
</mujoco>
"""
BEHIND = ChaseCamera(side=0.0)


def model(walls=""):
    return mujoco.MjModel.from_xml_string(BALL.format(walls=walls))


def poses(xyz, yaw=0.0, pitch=0.0):
    """(k, 8): the cart's slide, then the free joint."""
    xyz = np.atleast_2d(xyz)
    yaw, pitch = np.broadcast_to(yaw, len(xyz)) / 2, np.broadcast_to(pitch, len(xyz)) / 2
    quat = [
        np.cos(yaw) * np.cos(pitch),
        -np.sin(yaw) * np.sin(pitch),
        np.cos(yaw) * np.sin(pitch),
        np.sin(yaw) * np.cos(pitch),
    ]
    return np.column_stack([np.zeros(len(xyz)), xyz, *quat])


def test_the_free_joint_is_found_behind_other_joints():
    assert free_joint(model()) == 1


def test_a_model_without_a_free_joint_is_refused():
    fixed = mujoco.MjModel.from_xml_string("<mujoco/>")
    with pytest.raises(InvalidInput, match="free joint to follow"):
        free_joint(fixed)


def test_a_robot_at_rest_is_looked_at_from_behind_and_above():
    rows = chase(model(), poses([[1.0, 2.0, 0.2]] * 5, yaw=0.5), 0.05, camera=BEHIND)
    np.testing.assert_allclose(rows[2, :3], [1.0, 2.0, 0.2], atol=1e-9)
    np.testing.assert_allclose(rows[2, 3:], [BEHIND.distance, 0.5, -BEHIND.elevation], atol=1e-9)


def test_of_an_upright_robot_the_belly_shows_the_way():
    rows = chase(model(), poses([[0, 0, 0.5]] * 3, pitch=-np.pi / 2), 0.05, camera=BEHIND)
    # R_y(-90 deg) turns +x into +z and -z into +x: the camera looks along +x of M
    assert abs(rows[1, 4]) < 1e-9


def test_the_view_turns_smoothly_when_the_robot_turns_at_once():
    yaw = np.where(np.arange(100) < 50, 3.0, 3.4)
    rows = chase(model(), poses([[0, 0, 0.2]] * 100, yaw=yaw), 0.05, camera=BEHIND)
    turned = np.unwrap(rows[:, 4])
    assert np.abs(np.diff(turned)).max() < 0.02
    np.testing.assert_allclose(turned[[0, -1]] % (2 * np.pi), [3.0, 3.4], atol=0.02)


def test_a_wall_behind_the_robot_lifts_the_camera_and_no_wall_does_not():
    wall = '<geom type="box" size=".05 2 .4" pos="-.6 0 .4"/>'
    start = poses([[0, 0, 0.2]] * 5)
    free = chase(model(), start, 0.05, camera=BEHIND)
    behind_wall = chase(model(wall), start, 0.05, camera=BEHIND)
    assert behind_wall[2, 5] < free[2, 5] - 0.2
    # over a wall 0.8 m high and 0.55 m behind, from 0.2 m up: steeper than atan(0.6 / 0.55)
    assert behind_wall[2, 5] < -np.arctan2(0.6, 0.65)


def test_the_robot_itself_never_counts_as_a_wall():
    rows = chase(model(), poses([[0, 0, 0.2]] * 5), 0.05, camera=BEHIND)
    np.testing.assert_allclose(rows[:, 5], -BEHIND.elevation)
