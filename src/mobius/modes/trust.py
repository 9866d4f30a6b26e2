"""Which of the estimator's sources are worth listening to in each mode."""

from __future__ import annotations

from dataclasses import dataclass

from mobius.types import Mode


@dataclass(frozen=True)
class Trust:
    """Sources besides the IMU, which is always heard."""

    vio: bool = True
    """The camera on the back: blind while the robot rolls over it."""
    legs: bool = True
    """Limbs that press on the ground do so with their ends, and these do not slip or roll."""
    ground: bool = True
    """And their ends are at the floor's height."""


WALKING = Trust()
MOVING = Trust(ground=False)
LYING = Trust(legs=False, ground=False)
ROLLING = Trust(vio=False, legs=False, ground=False)

TRUST: dict[Mode, Trust] = {
    Mode.STAND_UP: MOVING,
    Mode.LIE_DOWN: MOVING,
    Mode.PUSH_UPS: MOVING,
    Mode.RECOVER: LYING,
    Mode.STOP: LYING,
    Mode.ROLL: ROLLING,
}
"""Modes that are not listed trust everything (:func:`trust_in`)."""


def trust_in(mode: Mode) -> Trust:
    """What to trust in a mode."""
    return TRUST.get(mode, WALKING)
