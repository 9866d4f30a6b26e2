"""Arm and leg kinematics against MuJoCo's own, over 1,000 random poses a limb."""

import mujoco
import numpy as np
import pytest

from mobius.model import JOINTS, LIMB_JOINTS, arm, leg, limb_geometry
from mobius.model import robot as load
from mobius.types import LIMBS


@pytest.fixture(scope="module")
def model():
    return load.load_model("full", floor=False)


def poses(limb: str, n: int = 1000, seed: int = 1) -> np.ndarray:
    """Random joint angles of one limb: all ranges, on the assembly branch."""
    g = limb_geometry(limb)
    low, high = (x[LIMB_JOINTS[limb]] for x in load.joint_limits())
    q = np.random.default_rng(seed).uniform(low, high, (8 * n, len(low)))
    T = g.fivebar.fk(q[:, 1], q[:, 2])
    ok = np.isfinite(T).all(axis=1) & (q[:, 2] - q[:, 1] > 0.70)
    return q[ok][:n]


def reachable(limb: str, n: int = 1000) -> np.ndarray:
    """Those with the wrist or ankle outward of the yaw axis, as :func:`ankle_ik` assumes."""
    q, g = poses(limb, 3 * n), limb_geometry(limb)
    out = g.fivebar.fk(q[:, 1], q[:, 2])[:, 1] + g.x_off
    if not g.is_arm:
        out += np.minimum(g.tip * np.sin(leg.foot_pitch(g, q)), 0)
    return q[out > 0.02][:n]


@pytest.mark.parametrize("limb", LIMBS)
def test_forward_kinematics_equal_mujoco(model, limb):
    g, data = limb_geometry(limb), mujoco.MjData(model)
    q_limb = poses(limb)
    assert len(q_limb) == 1000
    q = np.tile(load.keyframe_joints("crawl")[0], (1000, 1))
    q[:, LIMB_JOINTS[limb]] = q_limb
    for k in range(1000):
        data.qpos[:] = load.configuration(model, q[k])
        mujoco.mj_kinematics(model, data)
        site = data.site(f"{limb}_tip")
        gap = data.site(f"{limb}_loop_coupler").xpos - data.site(f"{limb}_loop_distal").xpos
        assert np.abs(gap).max() < 1e-6
        if g.is_arm:
            p, rotation = arm.gripper_pose(g, q_limb[k])
            assert np.abs(rotation - site.xmat.reshape(3, 3)).max() < 1e-6
        else:
            p = leg.sole_position(g, q_limb[k])
        assert np.abs(p - site.xpos).max() < 1e-6


@pytest.mark.parametrize("limb", LIMBS)
def test_inverse_kinematics_undo_forward(limb):
    g, q = limb_geometry(limb), reachable(limb)
    assert len(q) > 500
    if g.is_arm:
        p, rotation = arm.gripper_pose(g, q)
        back = arm.gripper_ik(g, p, rotation)
    else:
        back = leg.sole_ik(g, leg.sole_position(g, q), leg.foot_pitch(g, q))
    error = (back - q + np.pi) % (2 * np.pi) - np.pi
    assert np.abs(error).max() < 1e-6


@pytest.mark.parametrize("limb", LIMBS)
def test_jacobian_matches_finite_differences(limb):
    g, q, e = limb_geometry(limb), poses(limb, 200), 1e-6

    def position(x):
        return arm.gripper_pose(g, x)[0] if g.is_arm else leg.sole_position(g, x)

    J = arm.gripper_jacobian(g, q)[:, :3] if g.is_arm else leg.sole_jacobian(g, q)
    for i in range(q.shape[1]):
        d = np.zeros(q.shape[1])
        d[i] = e
        numeric = (position(q + d) - position(q - d)) / (2 * e)
        assert np.abs(J[..., i] - numeric).max() < 1e-6 * (1 + np.abs(J).max())


def test_angular_jacobian_of_the_arm():
    g, q, e = limb_geometry("left_arm"), poses("left_arm", 100), 1e-6
    J = arm.gripper_jacobian(g, q)[:, 3:]
    _, rotation = arm.gripper_pose(g, q)
    for i in range(6):
        d = np.zeros(6)
        d[i] = e
        turned = arm.gripper_pose(g, q + d)[1] @ np.swapaxes(rotation, -1, -2)
        w = (
            0.5
            / e
            * np.stack(
                [
                    turned[:, 2, 1] - turned[:, 1, 2],
                    turned[:, 0, 2] - turned[:, 2, 0],
                    turned[:, 1, 0] - turned[:, 0, 1],
                ],
                axis=1,
            )
        )
        np.testing.assert_allclose(J[..., i], w, atol=1e-4 * (1 + np.abs(J).max()))


def test_left_and_right_mirror():
    """The same angles with yaw and roll negated give the mirrored point."""
    for pair in (("left_arm", "right_arm"), ("left_leg", "right_leg")):
        left, right = (limb_geometry(n) for n in pair)
        q = poses(pair[0], 50)
        names = JOINTS[LIMB_JOINTS[pair[0]]]
        sign = [-1.0 if n.endswith(("yaw", "roll")) else 1.0 for n in names]
        tip = (lambda g, x: arm.gripper_pose(g, x)[0]) if left.is_arm else leg.sole_position
        np.testing.assert_allclose(
            tip(right, q * sign), tip(left, q) * [1.0, -1.0, 1.0], atol=1e-12
        )


def test_out_of_reach_is_nan():
    g = limb_geometry("left_leg")
    assert np.isnan(leg.sole_ik(g, np.array([1.0, 1.0, -1.0]))).any()
