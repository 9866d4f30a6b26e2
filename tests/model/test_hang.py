"""The robot on a bar: closed forms against MuJoCo and against statics done by hand."""

import mujoco
import numpy as np
import pytest

from mobius.model import hang
from mobius.model import robot as model_robot
from mobius.model.arm import gripper_pose
from mobius.model.dimensions import limb_geometry

POSES = [(0.372, -0.318, 36.0), (0.185, -0.290, 49.0), (0.0475, -0.104, 39.8)]


@pytest.mark.parametrize("pose", POSES)
def test_the_fingertips_are_at_the_bar_with_the_hand_as_wished(pose):
    x, z, lean = pose[0], pose[1], np.radians(pose[2])
    q = hang.hang_arms(x, z, lean)
    p, R_BG = gripper_pose(limb_geometry("left_arm"), q)
    np.testing.assert_allclose(p, [x, hang.SPREAD, z], atol=1e-9)
    np.testing.assert_allclose(hang.trunk_rotation(lean) @ R_BG, hang.hand_rotation(), atol=1e-9)


def test_an_upright_trunk_has_its_head_up_and_its_belly_ahead():
    R = hang.trunk_rotation(0.0)
    np.testing.assert_allclose(R @ [1, 0, 0], [0, 0, 1], atol=1e-12)
    np.testing.assert_allclose(R @ [0, 0, -1], [1, 0, 0], atol=1e-12)


def test_leaning_back_moves_the_head_back():
    assert (hang.trunk_rotation(0.3) @ [1.0, 0, 0])[0] < 0


def test_the_hands_x_axis_lies_along_the_bar_and_the_fingers_point_up():
    R = hang.hand_rotation()
    assert R[1, 0] == pytest.approx(np.cos(hang.SPLAY))
    # the hand points along -z: up by cos(tilt) cos(splay)
    assert -R[2, 2] == pytest.approx(np.cos(hang.TILT) * np.cos(hang.SPLAY))


def test_the_jacobian_is_that_of_the_fingertips_in_hand_axes():
    x, z, lean = POSES[1][0], POSES[1][1], np.radians(POSES[1][2])
    q = hang.hang_arms(x, z, lean)
    J = hang.arm_jacobian(lean, q)
    e = 1e-5
    for axis in range(6):
        moved = np.zeros((2, 6))
        moved[0, axis], moved[1, axis] = e, -e
        two = np.ones(2)
        plus, minus = hang.hang_arms(x * two, z * two, lean * two, moved)
        np.testing.assert_allclose(J @ (plus - minus) / (2 * e), np.eye(6)[axis], atol=1e-5)


def test_torques_do_the_work_of_the_bar_and_of_the_hands_weight():
    """Virtual work: tau dq + (wrench + hand's weight) dx = 0 for any small motion."""
    x, z, lean = POSES[2][0], POSES[2][1], np.radians(POSES[2][2])
    q = hang.hang_arms(x, z, lean)
    wrench = np.array([3.0, -36.0, -35.0, 0.8, -1.6, 0.2])
    tau = hang.hang_torques(lean, q, wrench)
    dq = np.array([0.1, -0.2, 0.3, 0.05, -0.1, 0.2])
    dx = hang.arm_jacobian(lean, q) @ dq
    assert tau @ dq == pytest.approx(-(wrench + hang.hand_weight()) @ dx)


def test_a_hand_that_weighs_down_is_pulled_down():
    f = hang.hand_rotation() @ hang.hand_weight()[:3]
    np.testing.assert_allclose(f, [0, 0, -9.81 * hang.HAND_MASS], atol=1e-9)
    assert pytest.approx(0.78, abs=0.06) == hang.HAND_MASS


def test_the_right_arm_mirrors_the_left_in_mujoco():
    x, z, lean = POSES[0][0], POSES[0][1], np.radians(POSES[0][2])
    q = np.zeros(22)
    q[:6] = hang.hang_arms(x, z, lean)
    q[6:12] = q[:6] * hang.MIRROR
    model = model_robot.load_model("full", floor=False)
    data = mujoco.MjData(model)
    q[12:20] = model_robot.keyframe_joints("stand")[0][12:20]
    data.qpos[:] = model_robot.configuration(model, q)
    mujoco.mj_kinematics(model, data)
    left, right = (data.site(f"{s}_arm_tip").xpos for s in ("left", "right"))
    np.testing.assert_allclose(left, [x, hang.SPREAD, z], atol=2e-4)
    np.testing.assert_allclose(right, left * [1, -1, 1], atol=1e-9)


def test_a_bar_that_no_arm_reaches_gives_nan():
    assert np.isnan(hang.hang_arms(0.9, 0.0, 0.0)).any()
