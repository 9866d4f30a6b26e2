"""Which of the estimator's sources are worth listening to in each mode."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mobius.modes.motions.tilt import tilt_of
from mobius.types import Mode, StateEstimate


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
}
"""Modes that are not listed trust everything; a roll goes through several."""


REARED = float(np.radians(70.0))
"""A trunk whose nose is higher than this is on its way over [rad]; rearing up stays below."""
LEVEL = float(np.radians(30.0))
"""Back within this of level, and slower than :data:`SLOW`, it has landed [rad]."""
SLOW = 1.5
"""[rad/s]."""


class TrustWatch:
    """What to trust now: the mode says, and in a roll how far it is.

    Until the trunk goes over, a rolling robot stands on its limbs and its camera sees; while
    it goes over only the IMU is worth hearing; lying where it landed, the camera sees again.
    """

    def __init__(self) -> None:
        self._mode: Mode | None = None
        self._phase = MOVING

    def see(self, mode: Mode, belief: StateEstimate | None) -> Trust:
        """Trust in a mode at a belief; call at 60 Hz."""
        if mode is not self._mode:
            self._mode, self._phase = mode, MOVING
        if mode is not Mode.ROLL or belief is None:
            return TRUST.get(mode, WALKING)
        pitch = tilt_of(belief.q_OB).pitch_B
        slow = float(np.abs(belief.w_B).max()) < SLOW
        if self._phase is MOVING and (pitch < -REARED or pitch > REARED):
            self._phase = ROLLING
        elif self._phase is ROLLING and slow and abs(pitch) < LEVEL:
            self._phase = LYING
        return self._phase
