"""What a show asks of the mode machine, act by act; it goes on by what the machine does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from mobius.errors import InvalidInput
from mobius.geometry import heading_yaw
from mobius.modes.machine import WALKING
from mobius.robot import TICK
from mobius.stack import Sample
from mobius.types import Mode, ModeCommand, StateEstimate


@dataclass(frozen=True)
class Act:
    """One thing to be seen.

    In a mode that lasts, crawl or biped, it is over after ``seconds`` in it. A mode that ends
    by itself is asked for until it has been entered, and over when the robot crawls again.
    """

    mode: Mode
    """What is wanted."""
    seconds: float = 0.0
    """Time in a mode that lasts [s]."""
    twist: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """vx, vy [m/s], wz [rad/s] in the heading frame."""
    shove: tuple[float, float] | None = None
    """Pushes the whole robot as the act begins: speed gained forward and to the left [m/s].
    Such an act is not over before the robot has fallen and got up again."""
    limit_s: float = 30.0
    """Longest it may take, what lies between included [s]."""

    def __post_init__(self) -> None:
        if self.shove is not None and self.mode not in WALKING:
            raise InvalidInput(
                f"an act with a shove: expected mode crawl or biped, got {self.mode}"
            )


@dataclass
class Script:
    """Acts as a source of commands (:data:`mobius.stack.Source`); :meth:`see` moves it on."""

    acts: Sequence[Act]
    first: Mode
    """Mode the robot starts in."""
    act: int = field(default=0, init=False)
    """Index of the act it is in."""
    over: bool = field(default=False, init=False)
    """Whether all acts are."""
    failed: str = field(default="", init=False)
    """Why it cannot go on."""

    def __post_init__(self) -> None:
        if not self.acts:
            raise InvalidInput("a script: expected at least one act, got none")
        self._mode = self.first
        self._enter(0.0)

    def __call__(self, belief: StateEstimate) -> ModeCommand:
        """The command at this belief."""
        act = self.acts[self.act]
        wanted = Mode.CRAWL if self._been and act.mode not in WALKING else act.mode
        there = wanted is self._mode
        twist = np.array(act.twist if there else (0.0, 0.0, 0.0))
        return ModeCommand(wanted, twist, belief.stamp)

    def see(self, sample: Sample, robot: Any) -> None:
        """Go on to the next act when this one is over; call after each 60 Hz turn.

        Args:
            sample: Of this turn.
            robot: A SimRobot, to shove.
        """
        now, mode, act = sample.tick * TICK, sample.command.mode, self.acts[self.act]
        if act.shove is not None and not self._shoved:
            self._shove(act, robot)
        if mode is Mode.STOP:
            self.failed = "emergency stop"
        elif now - self._began > act.limit_s:
            self.failed = f"act {self.act} ({act.mode}) not over after {act.limit_s:g} s"
        elif self._is_over(act, mode, now):
            self.act += 1
            self.over = self.act == len(self.acts)
            if not self.over:
                self._enter(now)
        self._mode = mode

    # -- inside --------------------------------------------------------------------------

    def _enter(self, now: float) -> None:
        self._began, self._since = now, -1.0
        self._been, self._shoved, self._fell = False, False, False

    def _is_over(self, act: Act, mode: Mode, now: float) -> bool:
        self._fell = self._fell or mode is Mode.RECOVER
        if act.mode in WALKING:
            if mode is not act.mode:
                self._since = -1.0
            elif self._since < 0.0:
                self._since = now
            waits = act.shove is not None and not self._fell
            return self._since >= 0.0 and not waits and now - self._since >= act.seconds - 1e-9
        self._been = self._been or mode is act.mode
        return self._been and mode is Mode.CRAWL

    def _shove(self, act: Act, robot: Any) -> None:
        assert act.shove is not None
        q = robot.truth().q_OB
        yaw = float(heading_yaw("biped" if act.mode is Mode.BIPED else "crawl", q))
        c, s = np.cos(yaw), np.sin(yaw)
        robot.push(np.array([[c, -s], [s, c]]) @ act.shove, 0.1, as_force=True)
        self._shoved = True
