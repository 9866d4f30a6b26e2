"""Soft servos: follow the limbs until they rest, then hold them there (emergency stop)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.types import JointCommand, ModeCommand, SensorFrame, StateEstimate

Array = NDArray[np.float64]

QUIET_JOINT = 0.15
"""Joints slower than this rest [rad/s]; encoders read speed in steps of 0.024."""
QUIET_TRUNK = 0.25
"""And a trunk that turns slower than this [rad/s]."""
QUIET_FORCE = 3.0
"""And a specific force this close to gravity [m/s^2]: a robot in free fall does not rest."""
QUIET_S = 0.2
"""For this long [s]."""
LONGEST_S = 2.0
"""After this long it holds wherever it is [s]."""


class DampedHold:
    """Targets follow the measured angles, so that the servos' springs pull nowhere.

    What is left of a servo then is the back-EMF of its motor, a damper of 0.9 to 2 N m s/rad
    (:mod:`mobius.model.servo`): limbs give way slowly under load. Once joints and trunk rest
    the last angles become targets that stay. A :class:`mobius.stack.Controller` at 300 Hz.
    """

    every = 2

    def __init__(self, *, joints_too: bool = True) -> None:
        """Hold once trunk and joints rest, or once the trunk does (``joints_too`` False)."""
        self._joint_rate = QUIET_JOINT if joints_too else np.inf
        self.reset()

    def reset(self) -> None:
        """Start soft again."""
        self._held: Array | None = None
        self._began: float | None = None
        self._quiet_since = np.inf

    def begin(self, targets: ArrayLike) -> None:
        """Targets sent so far do not matter to a limb that goes soft."""

    @property
    def resting(self) -> bool:
        """Whether it holds."""
        return self._held is not None

    def act(self, command: ModeCommand, belief: StateEstimate, frame: SensorFrame) -> JointCommand:
        """The measured angles, or those at which the robot came to rest."""
        now = frame.stamp
        if self._began is None:
            self._began = now
        if self._held is None:
            still = (
                float(np.abs(frame.dq).max()) < self._joint_rate
                and float(np.abs(belief.w_B).max()) < QUIET_TRUNK
                and abs(float(np.linalg.norm(frame.accel_I)) - 9.81) < QUIET_FORCE
            )
            self._quiet_since = min(self._quiet_since, now) if still else np.inf
            if now - self._quiet_since >= QUIET_S or now - self._began >= LONGEST_S:
                self._held = np.array(frame.q)
        return JointCommand(q=frame.q if self._held is None else self._held, stamp=now)
