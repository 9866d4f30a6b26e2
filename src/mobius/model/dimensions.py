"""Every length and mass of the robot, with its source.

Marks: [S] public SCALER/MOBIUS hardware constants, [P] the paper, [D] derived,
[A] our assumption where nothing is published. Frame: ``base_link``, metres, kilograms.
``model/mjcf/README.md`` tells the derivations.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mobius.errors import UnknownName
from mobius.model.fivebar import ARM_FIVEBAR, LEG_FIVEBAR, FiveBar
from mobius.types import LIMBS

HIP_X = 0.144
"""Shoulder (+) and hip (-) axes ahead of the trunk centre [S] 150/2 + 69 mm."""
HIP_Y = 0.136
"""Left (+) and right (-) [S] 86 + 100/2 mm."""


@dataclass(frozen=True)
class LimbGeometry:
    """Where a limb's five-bar sits and what hangs on it."""

    name: str
    hip_B: tuple[float, float, float]
    """Yaw axis in ``base_link`` [m]."""
    side: int
    """+1 left, -1 right."""
    fivebar: FiveBar
    x_off: float
    """Top servo axis outward of the yaw axis [m] [S]."""
    z_top: float
    """Top servo axis above the yaw joint centre [m] [S]."""
    lateral: float
    """Wrist centre forward (+x_B at zero yaw) of the five-bar plane [m] [S]."""
    tip: float
    """Wrist centre or ankle axis to the sole, along the approach axis [m]."""

    @property
    def is_arm(self) -> bool:
        """Arms end in a gripper, legs in a foot."""
        return self.name.endswith("arm")


TIP_ARM = 0.110
"""Wrist centre to closed fingertips [A]: F/T sensor, palm and the two finger cells."""
TIP_LEG = 0.035
"""Ankle axis to sole [A]."""


def limb_geometry(name: str) -> LimbGeometry:
    """Geometry of a limb of :data:`mobius.types.LIMBS`. Raises :class:`UnknownName`."""
    if name not in LIMBS:
        raise UnknownName("limb", name, LIMBS)
    side = 1 if name.startswith("left") else -1
    if name.endswith("arm"):
        hip = (HIP_X, side * HIP_Y, 0.0)
        return LimbGeometry(name, hip, side, ARM_FIVEBAR, -0.0105, -0.07125, 0.05913, TIP_ARM)
    hip = (-HIP_X, side * HIP_Y, 0.0)
    return LimbGeometry(name, hip, side, LEG_FIVEBAR, -0.01025, -0.07375, 0.0, TIP_LEG)


# Masses [kg]; trunk 4.70, arm 1.70, leg 1.10, together 10.30 [P v3], arm/leg 1.545 [P +55 %].
MASS_TRUNK = {
    "frame": 1.20,
    "battery": 1.50,
    "computer": 1.00,
    "rails": 0.40,
    "electronics": 0.473,
    "head_camera": 0.072,
    "vio_camera": 0.055,
}
MASS_ARM = {
    "shoulder": 0.75,
    "crank_a": 0.035,
    "coupler": 0.030,
    "crank_b": 0.035,
    "distal": 0.170,
    "wrist_pitch": 0.110,
    "wrist_roll": 0.110,
    "wrist_yaw": 0.110,
    "ft_sensor": 0.10,
    "palm": 0.19,
    "finger": 0.03,
}
MASS_LEG = {
    "hip": 0.65,
    "crank_a": 0.030,
    "coupler": 0.025,
    "crank_b": 0.025,
    "distal": 0.120,
    "ankle_servo": 0.165,
    "foot": 0.085,
}
ROBOT_MASS = 10.3

RAIL_RADIUS = 0.30
RAIL_Y = 0.10
RAIL_TOP = 0.125
RAIL_HALF_LENGTH = 0.175
"""Back rails [A]: two arcs from head to hip, as far apart as the trunk allows."""

FOOT_TOE, FOOT_HEEL, FOOT_WIDTH, FOOT_THICK = 0.085, 0.055, 0.030, 0.010
"""Flat narrow foot 140 x 30 mm [A]; the toe points to the belly side."""

SOLE_FRICTION = (0.8, 0.005, 0.0001)
"""Sliding, torsional [m], rolling [m], of soles and fingertips [A]."""
SOLE_SOLIMP = (0.0, 0.98, 0.0007, 0.5, 2.0)
"""MuJoCo's impedance of their contacts: a rubber pad, whose force grows from nothing over the
first 0.7 mm [A]. With MuJoCo's own, 0.9 at zero depth, the force jumps between
nothing and tens of newtons as a foot is unloaded, and the contact flickers (docs/training.md)."""

FINGER_PIVOT = (0.012, 0.050)
"""Finger pivots: lateral and along the approach axis from the wrist centre [m] [A]."""
FINGER_KNEE = (0.018, 0.026)
FINGER_TIP = (-0.006, 0.051)
FINGER_RADIUS = 0.009

# Joint ranges [rad]
YAW_RANGE = (-np.radians(105.0), np.radians(105.0))
"""[P] Fig. 3a: 210 deg."""
MOTOR_A_RANGE = (-1.5, 1.5)
MOTOR_B_RANGE = (0.2, 3.1)
"""[A] assembly branch."""
MIN_CRANK_SPREAD = 0.70
"""q21 - q11 keeps the closed form on its branch [D]."""
WRIST_RANGES = {
    "wrist_pitch": (-1.57, 1.57),
    "wrist_roll": (-1.2, 1.2),
    "wrist_yaw": (-1.83, 1.83),
}
ANKLE_RANGE = (-0.60, np.radians(105.0) - 0.60)
"""[P] Fig. 3b: 105 deg in all; its middle [A]."""
GRIPPER_RANGE = (0.0, 0.9)
