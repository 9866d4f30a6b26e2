"""Key poses in few numbers: both sides mirrored, or hands and feet held to the floor."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.model import LIMB_JOINTS
from mobius.model.build import joint_ranges
from mobius.model.dimensions import MIN_CRANK_SPREAD
from mobius.model.joints import JOINTS
from mobius.types import NUM_JOINTS

Array = NDArray[np.float64]

FREE = ("shoulder_yaw", "shoulder_motor_a", "shoulder_motor_b", "wrist_pitch",
        "hip_yaw", "hip_motor_a", "hip_motor_b", "ankle_pitch")  # fmt: skip
"""Joints of one side that a mirrored pose sets; wrist roll and yaw and the grippers stay 0."""
_LOW, _HIGH = np.array([joint_ranges()[j] for j in JOINTS]).T
_LEFT = np.r_[0:4, 12:16]
LOW, HIGH = _LOW[_LEFT], _HIGH[_LEFT]
"""(8,) limits of FREE, left side [rad]."""
_TOP = np.array([s.start + 1 for s in LIMB_JOINTS.values()])


def mirrored(side: ArrayLike) -> Array:
    """All joints (22,) [rad] from those of the left side (8,), order FREE."""
    side = np.asarray(side, dtype=float)
    q = np.zeros(NUM_JOINTS)
    for name, sign in (("left", 1.0), ("right", -1.0)):
        arm, leg = LIMB_JOINTS[f"{name}_arm"], LIMB_JOINTS[f"{name}_leg"]
        q[arm.start : arm.start + 4] = side[:4]
        q[leg] = side[4:]
        q[arm.start] *= sign
        q[leg.start] *= sign
    return q


def left_side(q: ArrayLike) -> Array:
    """(8,) the left side of all joints (22,), order FREE."""
    return np.asarray(q, dtype=float)[_LEFT]


def within_limits(q: ArrayLike) -> Array:
    """Targets (..., 22) clipped to the joint ranges, cranks on their assembly branch [rad]."""
    q = np.clip(q, _LOW, _HIGH)
    lack = np.maximum(MIN_CRANK_SPREAD - (q[..., _TOP + 1] - q[..., _TOP]), 0.0)
    q[..., _TOP] -= 0.5 * lack
    q[..., _TOP + 1] += 0.5 * lack
    return np.clip(q, _LOW, _HIGH)


def sampled(path: Callable[[float], Array], count: int) -> Array:
    """(count, 22) poses of ``path(u)`` at u = 1/count, ..., 1, within the limits."""
    return within_limits(np.stack([path(k / count) for k in range(1, count + 1)]))
