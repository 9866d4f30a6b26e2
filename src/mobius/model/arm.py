"""Arm kinematics in ``base_link``: shoulder yaw, five-bar, spherical wrist. Closed form, batched.

Joint order of an arm: shoulder_yaw, shoulder_motor_a (q11), shoulder_motor_b (q21),
wrist_pitch, wrist_roll, wrist_yaw. The gripper frame G has -z as approach axis and its
origin at the closed fingertips; at wrist zero -z continues the forearm.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.model.dimensions import LimbGeometry
from mobius.model.leg import ankle_ik, ankle_jacobian, ankle_position, limb_axes

Array = NDArray[np.float64]


def _axis_angle(axis: str, angle: Array) -> Array:
    """Rotation matrices (..., 3, 3) about x, y or z."""
    c, s = np.cos(angle), np.sin(angle)
    R = np.zeros((*np.shape(angle), 3, 3))
    i, j, k = {"x": (0, 1, 2), "y": (1, 2, 0), "z": (2, 0, 1)}[axis]
    R[..., i, i] = 1.0
    R[..., j, j], R[..., k, k] = c, c
    R[..., k, j], R[..., j, k] = s, -s
    return R


def forearm_rotation(g: LimbGeometry, q: ArrayLike) -> Array:
    """Orientation (..., 3, 3) of the forearm link in B for yaw and cranks q (..., >=3)."""
    q = np.asarray(q, dtype=float)
    out, normal = limb_axes(g, q[..., 0])
    base = np.zeros((*out.shape, 3))
    base[..., 0], base[..., 1], base[..., 2, 2] = out, normal, 1.0
    return base @ _axis_angle("y", -g.fivebar.distal_angle(q[..., 1], q[..., 2]))


def gripper_pose(g: LimbGeometry, q: ArrayLike) -> tuple[Array, Array]:
    """Fingertip position (..., 3) [m] and orientation (..., 3, 3) in B for q (..., 6) [rad]."""
    q = np.asarray(q, dtype=float)
    R = (
        forearm_rotation(g, q)
        @ _axis_angle("y", -q[..., 3])
        @ _axis_angle("x", q[..., 4])
        @ _axis_angle("z", q[..., 5])
    )
    return ankle_position(g, q) - g.tip * R[..., :, 2], R


def gripper_ik(g: LimbGeometry, p_B: ArrayLike, R_BG: ArrayLike) -> Array:
    """Arm angles (..., 6) [rad] for fingertip p_B (..., 3) [m] and orientation (..., 3, 3).

    NaN where out of reach; of the two wrist solutions the one with |roll| <= pi/2.
    """
    p, R = np.asarray(p_B, dtype=float), np.asarray(R_BG, dtype=float)
    q = ankle_ik(g, p + g.tip * R[..., :, 2])
    W = np.swapaxes(forearm_rotation(g, q), -1, -2) @ R  # R_y(-pitch) R_x(roll) R_z(yaw)
    roll = np.arcsin(np.clip(-W[..., 1, 2], -1.0, 1.0))
    pitch = -np.arctan2(W[..., 0, 2], W[..., 2, 2])
    yaw = np.arctan2(W[..., 1, 0], W[..., 1, 1])
    return np.concatenate([q, np.stack([pitch, roll, yaw], axis=-1)], axis=-1)


def gripper_jacobian(g: LimbGeometry, q: ArrayLike) -> Array:
    """(..., 6, 6): rows linear [m/rad] then angular [rad/rad] velocity of G in B axes."""
    q = np.asarray(q, dtype=float)
    tip, R = gripper_pose(g, q)
    center = ankle_position(g, q)
    lever = tip - center
    _, normal = limb_axes(g, q[..., 0])
    forearm = forearm_rotation(g, q)
    rate = g.fivebar.distal_rate(q[..., 1], q[..., 2])
    pitched = forearm @ _axis_angle("y", -q[..., 3])
    J = np.zeros((*q.shape[:-1], 6, 6))
    J[..., 3:, 0] = [0.0, 0.0, 1.0]
    J[..., 3:, 1:3] = -normal[..., :, None] * rate[..., None, :]
    J[..., 3:, 3] = -normal
    J[..., 3:, 4] = pitched[..., :, 0]
    J[..., 3:, 5] = R[..., :, 2]
    J[..., :3, :3] = ankle_jacobian(g, q)
    J[..., :3, :] += np.cross(J[..., 3:, :], lever[..., :, None], axis=-2)
    return J
