"""The two walking bodies as data: which joints a policy moves, from which pose, how fast."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mobius.control.clock import Gait
from mobius.errors import UnknownName
from mobius.model.joints import joint_index
from mobius.types import LIMBS, Mode

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Body:
    """One body a locomotion policy drives."""

    mode: Mode
    keyframe: str
    """Keyframe whose servo targets are Theta_default of Eq. (2)."""
    joints: tuple[str, ...]
    """Actuated joints, in the order of the action; the others hold their target."""
    heading: Literal["crawl", "biped"]
    """Which trunk axis points forward (:func:`mobius.geometry.heading_axis`)."""
    feet: tuple[str, ...]
    """Limbs that touch the ground."""
    gait: Gait
    """Of the feet, in their order."""
    fallen_below: float
    """A trunk lower than this has fallen [m]."""
    command_low: tuple[float, float, float]
    """Slowest vx, vy [m/s], wz [rad/s] it is trained for."""
    command_high: tuple[float, float, float]

    @property
    def index(self) -> NDArray[np.int64]:
        """Where the actuated joints stand in JOINTS."""
        return joint_index(*self.joints)


def _crawl_joints() -> tuple[str, ...]:
    """14: three a leg (ankle fixed), four an arm (of the wrist only yaw), Sec. IV-A2."""
    arm = ("shoulder_yaw", "shoulder_motor_a", "shoulder_motor_b", "wrist_yaw")
    leg = ("hip_yaw", "hip_motor_a", "hip_motor_b")
    names = [f"{s}_{j}" for s in ("left", "right") for j in arm]
    return tuple(names + [f"{s}_{j}" for s in ("left", "right") for j in leg])


def _biped_joints() -> tuple[str, ...]:
    """8: four a leg; the arms hold their pose, Sec. IV-A2."""
    leg = ("hip_yaw", "hip_motor_a", "hip_motor_b", "ankle_pitch")
    return tuple(f"{s}_{j}" for s in ("left", "right") for j in leg)


BODIES: dict[str, Body] = {
    "crawl": Body(
        mode=Mode.CRAWL,
        keyframe="crawl",
        joints=_crawl_joints(),
        heading="crawl",
        feet=LIMBS,
        gait=Gait(
            period=0.64,
            offsets=(0.0, 0.5, 0.5, 0.0),
            swing=(0.04, 0.46),
            height=0.038,
            lift=0.8,
            slack=0.04,
            quicken=0.8,
        ),
        fallen_below=0.20,
        command_low=(-0.5, -0.5, -1.0),
        command_high=(0.7, 0.5, 1.0),
    ),
    "biped": Body(
        mode=Mode.BIPED,
        keyframe="stand",
        joints=_biped_joints(),
        heading="biped",
        feet=("left_leg", "right_leg"),
        gait=Gait(
            period=0.64,
            offsets=(0.0, 0.5),
            swing=(0.08, 0.42),
            height=0.03,
            unrest=0.15,
            settled=0.24,
        ),
        fallen_below=0.33,
        command_low=(-0.25, -0.15, -0.5),
        command_high=(0.25, 0.15, 0.5),
    ),
}
"""Bodies by name."""


@cache
def body_of(name: str) -> Body:
    """The body called ``name``. Raises :class:`UnknownName`."""
    if name not in BODIES:
        raise UnknownName("body", name, BODIES)
    return BODIES[name]
