"""The float kinematics are those of mobius.model; feet touch with what is lowest."""

import numpy as np
import pytest

from mobius.estimate.limbs import LimbKinematics, cross, dot, sole_rectangle
from mobius.model import LIMB_JOINTS, limb_geometry
from mobius.model.arm import forearm_rotation, gripper_jacobian, gripper_pose
from mobius.model.leg import ankle_jacobian, foot_pitch, sole_jacobian, sole_position
from mobius.model.robot import keyframe_joints
from mobius.types import LIMBS

STANCE = keyframe_joints("crawl")[0]
UP = (0j, 1.0)


def array(v) -> np.ndarray:
    return np.array([v[0].real, v[0].imag, v[1]])


def postures(limb: str, n: int = 40):
    """Random joint angles and rates about the stance."""
    rng = np.random.default_rng(LIMBS.index(limb))
    base = STANCE[LIMB_JOINTS[limb]]
    for _ in range(n):
        yield base + rng.normal(0, 0.15, len(base)), rng.normal(0, 1.0, len(base))


def end_pose(limb: str, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sole or fingertip and orientation of foot or gripper, by mobius.model."""
    g = limb_geometry(limb)
    if g.is_arm:
        return gripper_pose(g, q)
    c, s = np.cos(q[3]), np.sin(q[3])
    pitch = np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])
    return sole_position(g, q), forearm_rotation(g, q) @ pitch


@pytest.mark.parametrize("limb", LIMBS)
def test_orientation_is_the_model_s(limb):
    kinematics = LimbKinematics(limb_geometry(limb))
    for q, dq in postures(limb):
        axes = np.column_stack([array(a) for a in kinematics(q.tolist(), dq.tolist(), UP).axes])
        assert axes == pytest.approx(end_pose(limb, q)[1], abs=1e-12)


@pytest.mark.parametrize("limb", LIMBS)
def test_the_contact_point_moves_as_the_model_says(limb):
    g = limb_geometry(limb)
    kinematics, h = LimbKinematics(g), 1e-6
    for q, dq in postures(limb):
        state = kinematics(q.tolist(), dq.tolist(), UP)
        tip, R = end_pose(limb, q)
        fixed = R.T @ (array(state.contact) - tip)  # the material point, in gripper or foot

        def place(angles, fixed=fixed):
            p, turn = end_pose(limb, angles)
            return p + turn @ fixed

        velocity = (place(q + h * dq) - place(q - h * dq)) / (2 * h)
        assert array(state.velocity) == pytest.approx(velocity, abs=1e-8)
        out = np.array([state.out.real, state.out.imag, 0.0])
        for crank, drive in enumerate(state.contact_drive):
            e = h * np.eye(len(q))[1 + crank]
            d = (place(q + e) - place(q - e)) / (2 * h)
            assert (-d[2], d @ out) == pytest.approx((drive.real, drive.imag), abs=1e-8)


@pytest.mark.parametrize("limb", LIMBS)
def test_wrist_drive_is_the_model_s_jacobian(limb):
    g = limb_geometry(limb)
    for q, dq in postures(limb, 10):
        state = LimbKinematics(g)(q.tolist(), dq.tolist(), UP)
        J = ankle_jacobian(g, q)
        out = np.array([state.out.real, state.out.imag, 0.0])
        for crank, drive in enumerate(state.wrist_drive):
            assert drive.real == pytest.approx(-J[2, 1 + crank], abs=1e-12)
            assert drive.imag == pytest.approx(J[:, 1 + crank] @ out, abs=1e-12)


@pytest.mark.parametrize("limb", LIMBS)
def test_an_upright_end_touches_in_its_middle(limb):
    g = limb_geometry(limb)
    q = STANCE[LIMB_JOINTS[limb]]
    state = LimbKinematics(g)(q.tolist(), [0.0] * len(q), UP)
    tip, R = end_pose(limb, q)
    middle = tip if g.is_arm else tip - 0.015 * R[:, 0]  # toe 85 mm, heel 55 mm
    assert array(state.contact) == pytest.approx(middle, abs=2e-6)


def test_a_foot_on_its_toe_touches_with_the_toe_edge():
    g = limb_geometry("left_leg")
    q = STANCE[LIMB_JOINTS["left_leg"]].copy()
    q[3] -= 0.3  # the sole's outward normal turns in, the toe (inward) rises, the heel sinks
    sole, R = end_pose("left_leg", q)
    state = LimbKinematics(g)(q.tolist(), [0.0] * 4, UP)
    ends = {x: sole + x * R[:, 0] for x in (-0.085, 0.055)}
    lowest = min(ends.values(), key=lambda p: p[2])
    assert array(state.contact) == pytest.approx(lowest, abs=1e-6)


def test_a_tilted_trunk_puts_a_foot_on_one_corner():
    g = limb_geometry("left_leg")
    q = STANCE[LIMB_JOINTS["left_leg"]]
    up = np.array([0.15, 0.2, 1.0])
    up /= np.linalg.norm(up)
    sole, R = end_pose("left_leg", q)
    corners = [sole + x * R[:, 0] + y * R[:, 1] for x in (-0.085, 0.055) for y in (-0.015, 0.015)]
    lowest = min(corners, key=lambda p: p @ up)
    state = LimbKinematics(g)(q.tolist(), [0.0] * 4, (complex(up[0], up[1]), up[2]))
    assert array(state.contact) == pytest.approx(lowest, abs=1e-3)


def test_a_tilted_fingertip_touches_with_the_bottom_of_its_sphere():
    g = limb_geometry("left_arm")
    q = STANCE[LIMB_JOINTS["left_arm"]].copy()
    q[3] += 0.4
    tip, R = end_pose("left_arm", q)
    (_, _, half, z), r = sole_rectangle(g)
    centres = [tip + R @ [0.0, y, g.tip + z] for y in (-half, half)]
    state = LimbKinematics(g)(q.tolist(), [0.0] * 6, UP)
    height = min(c[2] for c in centres) - r
    assert array(state.contact)[2] == pytest.approx(height, abs=1e-6)


@pytest.mark.parametrize("limb", LIMBS)
def test_velocities_agree_with_the_model_s_jacobians_at_the_tip(limb):
    g = limb_geometry(limb)
    q = STANCE[LIMB_JOINTS[limb]]
    dq = np.random.default_rng(3).normal(size=len(q))
    state = LimbKinematics(g)(q.tolist(), dq.tolist(), UP)
    tip, R = end_pose(limb, q)
    if g.is_arm:
        J = gripper_jacobian(g, q)
        at_tip, spin = J[:3] @ dq, J[3:] @ dq
    else:
        at_tip = sole_jacobian(g, q) @ dq
        h = 1e-6
        turn = (end_pose(limb, q + h * dq)[1] - end_pose(limb, q - h * dq)[1]) / (2 * h) @ R.T
        spin = np.array([turn[2, 1], turn[0, 2], turn[1, 0]])
        assert foot_pitch(g, q) == pytest.approx(0.0, abs=0.02)
    expected = at_tip + np.cross(spin, array(state.contact) - tip)
    assert array(state.velocity) == pytest.approx(expected, abs=1e-8)


def test_pairs_multiply_like_vectors():
    a, b = np.array([1.0, -2.0, 3.0]), np.array([0.5, 4.0, -1.0])
    pair_a, pair_b = (complex(a[0], a[1]), a[2]), (complex(b[0], b[1]), b[2])
    assert array(cross(pair_a, pair_b)) == pytest.approx(np.cross(a, b))
    assert dot(pair_a, pair_b) == pytest.approx(a @ b)
