"""Kinematics of both arms in one call: the right arm is the left one in the mirror.

y changes its sign, and with it shoulder yaw, wrist roll and wrist yaw; one batched call of
the closed forms then costs as much as one for a single arm.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mobius.model.arm import forearm_rotation, gripper_ik, gripper_pose
from mobius.model.dimensions import limb_geometry

__all__ = ["arms_ik", "arms_pose", "arms_rotation"]

Array = NDArray[np.float64]

_LEFT = limb_geometry("left_arm")
_JOINTS = np.array([[1.0] * 6, [-1.0, 1.0, 1.0, 1.0, -1.0, -1.0]])
_POINT = np.array([[1.0, 1.0, 1.0], [1.0, -1.0, 1.0]])
_TURN = _POINT[:, :, None] * _POINT[:, None, :]
for _fixed in (_JOINTS, _POINT, _TURN):
    _fixed.setflags(write=False)


def arms_pose(q: Array) -> tuple[Array, Array]:
    """Fingertips (2, 3) [m] and orientation (2, 3, 3) in B of left and right arm q (2, 6)."""
    p, R = gripper_pose(_LEFT, q * _JOINTS)
    return p * _POINT, R * _TURN


def arms_rotation(q: Array) -> Array:
    """Orientation alone (2, 3, 3) of :func:`arms_pose`, in half the time."""
    q = q * _JOINTS
    cos, sin = np.cos(q[:, 3:]), np.sin(q[:, 3:])
    (ca, cb, cc), (sa, sb, sc) = cos.T, sin.T
    wrist = np.empty((2, 3, 3))  # R_y(-pitch) R_x(roll) R_z(yaw)
    wrist[:, 0, 0], wrist[:, 0, 1], wrist[:, 0, 2] = (
        ca * cc - sa * sb * sc,
        -ca * sc - sa * sb * cc,
        -sa * cb,
    )
    wrist[:, 1, 0], wrist[:, 1, 1], wrist[:, 1, 2] = cb * sc, cb * cc, -sb
    wrist[:, 2, 0], wrist[:, 2, 1], wrist[:, 2, 2] = (
        sa * cc + ca * sb * sc,
        -sa * sc + ca * sb * cc,
        ca * cb,
    )
    R: Array = forearm_rotation(_LEFT, q) @ wrist * _TURN
    return R


def arms_ik(p_B: Array, R_BG: Array) -> Array:
    """Arm angles (2, 6) [rad] for fingertips (2, 3) [m] and orientations (2, 3, 3); NaN where
    out of reach.
    """
    return gripper_ik(_LEFT, p_B * _POINT, R_BG * _TURN) * _JOINTS
