"""From a trunk pose and places of hands and feet in the world to all joints, closed form.

Frame M: z up, floor at 0. A limb whose place is ``None`` keeps the joints it is given.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.errors import InvalidInput
from mobius.model.arm import gripper_pose
from mobius.model.dimensions import LimbGeometry, limb_geometry
from mobius.model.joints import LIMB_JOINTS
from mobius.model.leg import ankle_ik, limb_axes, sole_position
from mobius.types import LIMBS, NUM_JOINTS

Array = NDArray[np.float64]

ROUNDS = 30
"""Fixed-point rounds for the gripper's direction; the arm's plane turns little between them."""


def ends(q: Array) -> Array:
    """(4, 3) closed fingertips and soles below the ankles in B [m] at joint angles q (22,) [rad],
    order LIMBS; NaN where a five-bar cannot be closed.
    """
    return np.array([end(limb, q) for limb in LIMBS])


def end(limb: str, q: Array) -> Array:
    """(3,) of :func:`ends`, of one limb."""
    g, joints = limb_geometry(limb), q[LIMB_JOINTS[limb]]
    return gripper_pose(g, joints)[0] if g.is_arm else sole_position(g, joints)


def longest_step(a: Array, b: Array) -> float:
    """Longest way [m] of a foot over the floor between two stances, joint angles (22,) [rad], the
    trunk over one spot.
    """
    return float(np.linalg.norm((ends(a) - ends(b))[:, :2], axis=1).max())


def nose_up(angle: float) -> Array:
    """Rotation (3, 3) of a trunk whose nose is raised by ``angle`` [rad] (REP-103 pitch -angle)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])


def _down_in_plane(g: LimbGeometry, yaw: float, up_B: Array) -> float:
    """Angle [rad] of world "down" in a limb's plane, from -z_B towards "out"."""
    out, _ = limb_axes(g, yaw)
    return float(np.arctan2(-up_B @ out, up_B[2]))


def leg_joints(limb: str, R_MB: ArrayLike, p_M: ArrayLike, sole_M: ArrayLike) -> Array:
    """Hip yaw, cranks and ankle (4,) [rad] with the sole flat on the place below the ankle.

    Args:
        limb: ``left_leg`` or ``right_leg``.
        R_MB: (3, 3) trunk.
        p_M: (3,) trunk [m].
        sole_M: (3,) point of the sole below the ankle [m].

    Returns:
        Angles; NaN where out of reach. The sole is flat only while the leg's plane is upright.
    """
    g, R = limb_geometry(limb), np.asarray(R_MB, dtype=float)
    up_B = R[2]
    ankle_B = R.T @ (np.asarray(sole_M, dtype=float) - p_M) + g.tip * up_B
    q = ankle_ik(g, ankle_B)
    pitch = _down_in_plane(g, q[0], up_B) - g.fivebar.distal_angle(q[1], q[2])
    return np.append(q, pitch)


def arm_joints(
    limb: str, R_MB: ArrayLike, p_M: ArrayLike, tip_M: ArrayLike, tilt: float = 0.0
) -> Array:
    """Shoulder yaw, cranks, wrist pitch, roll and yaw (6,) [rad] with the fingertips at a place.

    Args:
        limb: ``left_arm`` or ``right_arm``.
        R_MB: (3, 3) trunk.
        p_M: (3,) trunk [m].
        tip_M: (3,) closed fingertips [m].
        tilt: Of the gripper in the arm's plane, outward of "down" [rad].

    Returns:
        Angles with wrist roll and yaw 0; NaN where out of reach.
    """
    g, R = limb_geometry(limb), np.asarray(R_MB, dtype=float)
    up_B = R[2]
    tip_B = R.T @ (np.asarray(tip_M, dtype=float) - p_M)
    q = ankle_ik(g, tip_B + g.tip * up_B)
    angle = 0.0
    for _ in range(ROUNDS):
        out, _normal = limb_axes(g, q[0])
        angle = _down_in_plane(g, q[0], up_B) + tilt
        approach = np.sin(angle) * out - np.array([0.0, 0.0, np.cos(angle)])
        q = ankle_ik(g, tip_B - g.tip * approach)
    return np.concatenate([q, [angle - g.fivebar.distal_angle(q[1], q[2]), 0.0, 0.0]])


def body_joints(
    R_MB: ArrayLike,
    p_M: ArrayLike,
    *,
    hands_M: Sequence[ArrayLike | None] = (None, None),
    feet_M: Sequence[ArrayLike | None] = (None, None),
    keep: ArrayLike | None = None,
    tilt: float = 0.0,
) -> Array:
    """All joints (22,) [rad] of a trunk pose with hands and feet at their places, left first.

    Args:
        R_MB: (3, 3) trunk.
        p_M: (3,) trunk [m].
        hands_M: Fingertips (3,) [m] or None, each.
        feet_M: Soles below the ankle (3,) [m] or None, each.
        keep: (22,) joints of the limbs without a place; zero if not given.
        tilt: Of the grippers, outward of "down" [rad].

    Raises:
        InvalidInput: A place is out of reach.
    """
    q = np.zeros(NUM_JOINTS) if keep is None else np.array(keep, dtype=float)
    p = np.asarray(p_M, dtype=float)
    for limb, place in zip(LIMBS, (*hands_M, *feet_M), strict=True):
        if place is None:
            continue
        angles = (
            arm_joints(limb, R_MB, p, place, tilt)
            if limb.endswith("arm")
            else leg_joints(limb, R_MB, p, place)
        )
        if not np.isfinite(angles).all():
            at = np.round(np.asarray(place, dtype=float), 3).tolist()
            raise InvalidInput(
                f"{limb}: expected a place within reach, got {at} m for a trunk at"
                f" {np.round(p, 3).tolist()} m"
            )
        q[LIMB_JOINTS[limb]] = angles
    return q
