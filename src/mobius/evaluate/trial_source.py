"""What a trial asks of the mode machine: stand a while, ask, and stand again."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from mobius.geometry import heading_yaw, wrap_angle
from mobius.types import Mode, ModeCommand, StateEstimate

STAND_S = 1.0
"""The robot stands this long before it is asked for anything [s]."""
TURN_GAIN = 1.6
"""Yaw rate per heading error between two rolls [1/s]."""
TURN_RATE = 0.8
"""Largest [rad/s]."""
TURNED = float(np.radians(2.5))
"""Heading that is good enough for the next roll [rad]."""
TURN_S = 4.0
"""Longest turn between two rolls [s]."""


@dataclass
class Asks:
    """A source of commands (:data:`mobius.stack.Source`) that sees the belief alone.

    It learns that a mode was entered from the command's echo: :meth:`entered`.
    """

    asks: Mode | None
    """What is asked for; None where the robot starts fallen."""
    ends: Mode
    """What is wanted afterwards."""
    first: Mode
    """What it starts in."""
    times: int = 1
    """How often ``asks`` is wanted; the heading is corrected in between."""
    over: bool = field(default=False, init=False)
    """Whether all that was to be asked has been done."""
    done: int = field(default=0, init=False)
    _heading: float | None = field(default=None, init=False)
    _since: float = field(default=-np.inf, init=False)

    def __call__(self, belief: StateEstimate) -> ModeCommand:
        """The command at this belief."""
        now = belief.stamp
        if self.asks is None:
            self.over = True
            return self._command(self.ends, now)
        walking = self.first if self.first in (Mode.CRAWL, Mode.BIPED) else self.ends
        if now < STAND_S:
            return self._command(walking, now)
        if self._heading is None:
            self._heading = float(heading_yaw("crawl", belief.q_OB))
        if self.over:
            return self._command(self.ends, now)
        error = float(wrap_angle(self._heading - heading_yaw("crawl", belief.q_OB)))
        if self.done and now - self._since < TURN_S and abs(error) > TURNED:
            rate = float(np.clip(TURN_GAIN * error, -TURN_RATE, TURN_RATE))
            return self._command(Mode.CRAWL, now, rate)
        return self._command(self.asks, now)

    def entered(self, mode: Mode, before: Mode, stamp: float) -> None:
        """Tell that the machine went from one mode to another."""
        if before in (Mode.CRAWL, Mode.BIPED, Mode.GATHER) or mode is Mode.STOP:
            return
        self.done += 1
        self._since = stamp
        self.over = self.done >= self.times

    @staticmethod
    def _command(mode: Mode, stamp: float, rate: float = 0.0) -> ModeCommand:
        return ModeCommand(mode, np.array([0.0, 0.0, rate]), stamp)
