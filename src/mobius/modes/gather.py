"""Serves mode GATHER: looks where hands and feet stand, and steps to where motions begin."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.errors import InvalidInput
from mobius.modes.motions.gather import Gathered, build_gather
from mobius.modes.motions.player import MOTION_EVERY, MotionPlayer, State
from mobius.modes.posture import up_in_trunk
from mobius.types import JointCommand, ModeCommand, SensorFrame, StateEstimate

Array = NDArray[np.float64]


class Gather:
    """A motion made anew each time, from the measured joint angles (a
    :class:`mobius.stack.Controller`).
    """

    every = MOTION_EVERY

    def __init__(self, end: Gathered) -> None:
        """End there."""
        self.end = end
        self.reset()

    def reset(self) -> None:
        """Look anew."""
        self._sent: Array | None = None
        self._player: MotionPlayer | None = None
        self._why = ""

    def begin(self, targets: ArrayLike) -> None:
        """Tell the targets (22,) [rad] that were sent last."""
        self._sent = np.array(targets, dtype=float)

    @property
    def state(self) -> State:
        """How far it is."""
        if self._player is not None:
            return self._player.state
        return State.FAILED if self._why else State.RUNNING

    @property
    def reason(self) -> str:
        """Why it failed."""
        return self._why if self._player is None else self._player.reason

    def act(self, command: ModeCommand, belief: StateEstimate, frame: SensorFrame) -> JointCommand:
        """Targets of all joints for this moment; those sent last where there is no way."""
        if self._player is None and not self._why:
            try:
                self._player = MotionPlayer(build_gather(frame.q, up_in_trunk(belief), self.end))
            except InvalidInput as error:
                self._why = str(error)
            else:
                self._player.begin(frame.q if self._sent is None else self._sent)
        if self._player is None:
            return JointCommand(q=frame.q if self._sent is None else self._sent, stamp=frame.stamp)
        return self._player.act(command, belief, frame)
