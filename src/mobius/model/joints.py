"""The joints: names, order and limits, fixed here once for MJCF, policy, log and hardware."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mobius.errors import UnknownName
from mobius.types import NUM_JOINTS

_ARM = (
    "shoulder_yaw",
    "shoulder_motor_a",
    "shoulder_motor_b",
    "wrist_pitch",
    "wrist_roll",
    "wrist_yaw",
)
_LEG = ("hip_yaw", "hip_motor_a", "hip_motor_b", "ankle_pitch")

JOINTS: tuple[str, ...] = (
    *(f"left_{j}" for j in _ARM),
    *(f"right_{j}" for j in _ARM),
    *(f"left_{j}" for j in _LEG),
    *(f"right_{j}" for j in _LEG),
    "left_gripper",
    "right_gripper",
)
"""Motor names in the order of every (22,) joint vector. ``motor_a`` drives the top crank
(q11 of the five-bar), ``motor_b`` the bottom crank (q21)."""

assert len(JOINTS) == NUM_JOINTS

LIMB_JOINTS: dict[str, slice] = {
    "left_arm": slice(0, 6),
    "right_arm": slice(6, 12),
    "left_leg": slice(12, 16),
    "right_leg": slice(16, 20),
}
"""Where each limb's joints stand in a joint vector."""


def joint_index(*names: str) -> NDArray[np.int64]:
    """Indices of joints by name. Raises :class:`UnknownName`."""
    for name in names:
        if name not in JOINTS:
            raise UnknownName("joint", name, JOINTS)
    return np.array([JOINTS.index(n) for n in names], dtype=np.int64)
