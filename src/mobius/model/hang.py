"""The robot on a bar: from the trunk's pose to arm angles, from hand wrenches to servo torques.

Frame W stands at the bar: x forward (where the belly looks), y along the bar to the left, z up.
The trunk is upright (head up) and leans back by ``lean``; the bar's axis passes the point
(x_B, 0, z_B) of the trunk. Both hands point up and forward by :data:`TILT` with their fingers
before and behind the bar, ``SPREAD`` to the left and right of its middle.

Everything is said of the left arm; the right one is its mirror image (:data:`MIRROR`). Hand
axes G: x along the bar to the left, y the pinch normal, z towards the forearm, against which
the hand points. Closed forms, batched over leading axes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.geometry import cross, exp_so3
from mobius.model import dimensions as dim
from mobius.model.arm import gripper_ik, gripper_jacobian
from mobius.model.dimensions import limb_geometry
from mobius.model.servo import SERVOS

__all__ = [
    "MIRROR",
    "MIRROR_WRENCH",
    "SPLAY",
    "SPREAD",
    "STALL",
    "STIFFNESS",
    "TILT",
    "arm_jacobian",
    "hand_rotation",
    "hand_weight",
    "hang_arms",
    "hang_torques",
    "trunk_rotation",
]

Array = NDArray[np.float64]

TILT = float(np.radians(45.0))
"""Hands point this far forward of up [rad]. Pointing straight up, no arm is long enough to bring
the head above the bar with the centre of mass below it (docs/pullup.md)."""
SPLAY = float(np.radians(4.0))
"""And this far outward [rad]."""
SPREAD = 0.345
"""Middle of each grip from the middle of the bar [m]: with less the elbows meet their stop on
the way up, with more the shoulders' yaw servos carry more."""
MIRROR = np.array([-1.0, 1.0, 1.0, 1.0, -1.0, -1.0])
"""Angles and torques of the right arm over those of the left."""
MIRROR_WRENCH = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
"""The same for a wrench or a small motion in hand axes."""
HAND_MASS = (
    dim.MASS_ARM["wrist_pitch"]
    + dim.MASS_ARM["wrist_roll"]
    + dim.MASS_ARM["wrist_yaw"]
    + dim.MASS_ARM["ft_sensor"]
    + dim.MASS_ARM["palm"]
    + 2 * dim.MASS_ARM["finger"]
    + 0.5 * (dim.MASS_ARM["distal"] + dim.MASS_ARM["coupler"])
)
"""Of an arm that rests on its hand: wrist, hand, half of the forearm [kg]."""
HAND_CENTRE = 0.09
"""Its centre of mass from the fingertips towards the forearm [m], near enough."""

_ARM = limb_geometry("left_arm")
_SERVOS = [
    SERVOS[name]
    for name in (
        "shoulder_yaw",
        "shoulder_motor_a",
        "shoulder_motor_b",
        "wrist_pitch",
        "wrist_roll",
        "wrist_yaw",
    )
]
STIFFNESS = np.array([servo.kp for servo in _SERVOS])
"""(6,) of an arm's servos [N m/rad]."""
STALL = np.array([servo.stall_torque for servo in _SERVOS])
"""(6,) [N m]."""
for _fixed in (MIRROR, MIRROR_WRENCH, STIFFNESS, STALL):
    _fixed.setflags(write=False)


def _about_y(angle: ArrayLike) -> Array:
    """Rotations (..., 3, 3) about y."""
    c, s = np.cos(angle), np.sin(angle)
    R = np.zeros((*np.shape(angle), 3, 3))
    R[..., 0, 0], R[..., 0, 2], R[..., 1, 1] = c, s, 1.0
    R[..., 2, 0], R[..., 2, 2] = -s, c
    return R


def trunk_rotation(lean: ArrayLike) -> Array:
    """R_WB (..., 3, 3) of a trunk with its head up, leaning back by ``lean`` [rad]."""
    upright = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
    return _about_y(-np.asarray(lean, dtype=float)) @ upright


def hand_rotation() -> Array:
    """R_WG (3, 3) of the left hand: constant, the grip is rigid."""
    straight = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
    out: Array = _about_y(TILT) @ straight @ _about_y(-SPLAY)
    return out


def hang_arms(
    x_B: ArrayLike, z_B: ArrayLike, lean: ArrayLike, moved: ArrayLike | None = None
) -> Array:
    """Angles (..., 6) [rad] of the left arm whose fingertips are at the bar.

    Args:
        x_B: (...) bar from the trunk's centre towards the head [m].
        z_B: (...) bar from the trunk's centre towards the back [m]; negative is in front.
        lean: (...) of the trunk, back [rad].
        moved: (..., 6) the hand's deviation from that pose, hand axes [m, rad].

    Returns:
        Angles; NaN where out of reach. Joint limits are the caller's.
    """
    x, z = np.asarray(x_B, dtype=float), np.asarray(z_B, dtype=float)
    R_BG = np.swapaxes(trunk_rotation(lean), -1, -2) @ hand_rotation()
    p = np.stack([x, np.full_like(x, SPREAD), z], axis=-1)
    if moved is not None:
        m = np.asarray(moved, dtype=float)
        p = p + (R_BG @ m[..., :3, None])[..., 0]
        R_BG = R_BG @ np.stack([exp_so3(v) for v in m[..., 3:].reshape(-1, 3)]).reshape(
            *m.shape[:-1], 3, 3
        )
    return gripper_ik(_ARM, p, R_BG)


def arm_jacobian(lean: ArrayLike, q: ArrayLike) -> Array:
    """(..., 6, 6) of the left fingertips, hand axes, for arm angles q (..., 6) [rad]."""
    R_GB = hand_rotation().T @ trunk_rotation(lean)
    J = gripper_jacobian(_ARM, q)
    return np.concatenate([R_GB @ J[..., :3, :], R_GB @ J[..., 3:, :]], axis=-2)


def hand_weight() -> Array:
    """(6,) what gravity does to wrist and hand, at the fingertips in hand axes [N, N m]."""
    f = hand_rotation().T @ np.array([0.0, 0.0, -9.81 * HAND_MASS])
    return np.concatenate([f, cross(np.array([0.0, 0.0, HAND_CENTRE]), f)])


def hang_torques(lean: ArrayLike, q: ArrayLike, wrench_G: ArrayLike) -> Array:
    """Torques (..., 6) [N m] that hold the left arm at q while the bar does ``wrench_G`` to it.

    Args:
        lean: (...) [rad].
        q: (..., 6) [rad].
        wrench_G: (..., 6) by the bar on the hand at the fingertips, hand axes [N, N m].
    """
    J = arm_jacobian(lean, q)
    load = np.asarray(wrench_G, dtype=float) + hand_weight()
    return -(np.swapaxes(J, -1, -2) @ load[..., None])[..., 0]
