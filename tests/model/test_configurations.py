"""Many configurations at once are those of one at a time; measured joints are never changed."""

import mujoco
import numpy as np
import pytest

from mobius.errors import InvalidInput
from mobius.model.joints import LIMB_JOINTS
from mobius.model.robot import (
    addresses,
    compile_scene,
    configuration,
    configurations,
    keyframe_joints,
    load_model,
    passive_angles,
)

N = 5


@pytest.fixture(scope="module")
def model():
    return load_model("full")


@pytest.fixture
def poses():
    rng = np.random.default_rng(0)
    q = keyframe_joints("crawl")[0] + 0.02 * rng.normal(size=(N, 22))
    quat = rng.normal(size=(N, 4))
    return q, rng.normal(size=(N, 3)), quat / np.linalg.norm(quat, axis=1, keepdims=True)


def test_rows_are_the_configurations_one_at_a_time(model, poses):
    q, p, quat = poses
    rows, closed = configurations(model, q, p=p, quat=quat)
    assert closed.all()
    for k in range(N):
        np.testing.assert_array_equal(rows[k], configuration(model, q[k], p=p[k], quat=quat[k]))


def test_a_five_bar_that_cannot_be_assembled_keeps_its_passive_joints_from_before(model, poses):
    q, p, quat = poses
    a = LIMB_JOINTS["left_leg"].start + 1
    q[[0, 3], a], q[[0, 3], a + 1] = np.pi, 0.0  # cranks wide apart: the couplers do not meet
    assert np.isnan(passive_angles(q)[0][[0, 3], 2]).all()
    rows, closed = configurations(model, q, p=p, quat=quat)
    at = addresses(model)
    assert closed.tolist() == [False, True, True, False, True]
    np.testing.assert_array_equal(rows[:, at.qpos], q)
    np.testing.assert_array_equal(rows[3, at.coupler[2]], rows[2, at.coupler[2]])
    np.testing.assert_array_equal(rows[0, at.distal[2]], rows[1, at.distal[2]])
    # the other limbs go on by themselves
    np.testing.assert_array_equal(rows[3, at.coupler[0]], passive_angles(q[3])[0][0])
    with pytest.raises(InvalidInput, match="five-bar of left_leg"):
        configuration(model, q[3])


def test_a_scene_without_the_robot_or_that_is_none_is_refused():
    with pytest.raises(InvalidInput, match="lacks joints of the robot: left_shoulder_yaw"):
        compile_scene("<mujoco/>")
    with pytest.raises(InvalidInput, match="the scene cannot be built"):
        compile_scene("<mujoco><worldbody><geom size='-1'/></worldbody></mujoco>")
    assert isinstance(load_model("full"), mujoco.MjModel)
