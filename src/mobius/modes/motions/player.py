"""Plays a motion at 300 Hz, watches the belief, and gives up rather than play on."""

from __future__ import annotations

from enum import StrEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.model.joints import joint_index
from mobius.modes.motions.motion import Motion, Stage
from mobius.modes.motions.tilt import Tilt, tilt_of, wrapped
from mobius.modes.motions.way import Way
from mobius.modes.posture import posture_of
from mobius.types import JointCommand, ModeCommand, SensorFrame, StateEstimate

Array = NDArray[np.float64]

MOTION_EVERY = 2
"""Ticks of 1/600 s between targets of a motion: 300 Hz."""


MOST_ADDED = 0.4
"""A feedback moves a target by no more than this [rad]."""


class State(StrEnum):
    """How far a motion is."""

    RUNNING = "running"
    DONE = "done"
    FAILED = "failed"


def smooth_step(x: float) -> float:
    """Quintic from 0 to 1 over [0, 1] with no speed and acceleration at both ends."""
    x = min(max(x, 0.0), 1.0)
    return x * x * x * (10.0 + x * (6.0 * x - 15.0))


class MotionPlayer:
    """Turns a :class:`Motion` into joint targets (a :class:`mobius.stack.Controller`).

    The first stage leads from the targets last sent (:meth:`begin`), else from the joint
    angles of the first frame. When it is done, or has failed, it keeps the last targets.
    """

    every = MOTION_EVERY

    def __init__(self, motion: Motion) -> None:
        self.motion = motion
        self.reset()

    def reset(self) -> None:
        """Start anew."""
        self.state: State = State.RUNNING
        self.reason = ""
        """Why it failed."""
        self.stage = 0
        """Index of the stage it is in."""
        self._base: Array | None = None
        self._way: Way | None = None
        self._sent: Array | None = None
        self._began: float | None = None
        self._start, self._last, self._far_since = 0.0, 0.0, np.inf

    def begin(self, targets: ArrayLike) -> None:
        """Tell the targets (22,) [rad] that were sent last."""
        self._sent = np.array(targets, dtype=float)

    @property
    def progress(self) -> float:
        """Share of the stages that are over, 0 to 1."""
        return 1.0 if self.state is State.DONE else self.stage / len(self.motion.stages)

    @property
    def elapsed(self) -> float:
        """Time since the first target [s]."""
        return 0.0 if self._began is None else self._last - self._began

    def act(self, command: ModeCommand, belief: StateEstimate, frame: SensorFrame) -> JointCommand:
        """Targets of all joints for this moment."""
        now, tilt = frame.stamp, tilt_of(belief.q_OB)
        rate = float(belief.w_B[1])
        if self._sent is None:
            self._sent = np.array(frame.q)
        if self._began is None:
            self._began = now
            self._enter(now, tilt, rate)
        self._last = now
        if self.state is State.RUNNING:
            self._advance(now, belief, frame.q)
        if self.state is State.RUNNING:
            self._watch(now, tilt, frame.q)
        if self.state is State.RUNNING:
            stage = self.motion.stages[self.stage]
            share = smooth_step((now - self._start) / stage.seconds)
            self._sent = self._along(stage, share) + added(stage, share, tilt, rate)
        return JointCommand(q=self._sent, stamp=now)

    def _enter(self, now: float, tilt: Tilt, rate: float) -> None:
        """Begin the current stage where the targets are now, so that they do not jump."""
        assert self._sent is not None
        stage = self.motion.stages[self.stage]
        self._start = now
        self._base = self._sent - added(stage, 0.0, tilt, rate)
        self._way = None
        if len(stage.through):
            self._way = Way(np.vstack([self._base, stage.through, stage.q]))

    def _along(self, stage: Stage, share: float) -> Array:
        """Targets (22,) at a share of a stage's way."""
        if self._way is not None:
            return self._way.at(share)
        assert self._base is not None  # set on entering a stage
        return self._base + share * (stage.q - self._base)

    def _advance(self, now: float, belief: StateEstimate, q: Array) -> None:
        """Go to the next stage when this one is over; after the last, look where it ended."""
        stage = self.motion.stages[self.stage]
        tilt, rate = tilt_of(belief.q_OB), float(belief.w_B[1])
        over = now - self._start - stage.seconds
        if stage.until is None:
            if over < stage.hold - 1e-9:
                return
        elif not stage.until.holds(tilt):
            if over > stage.timeout:
                self._fail(f"{stage.until.angle} did not come in {stage.timeout:g} s")
            return
        if stage.until is None:  # the pose itself, whatever the rounding of the clock
            self._sent = stage.q + added(stage, 1.0, tilt, rate)
        self.stage += 1
        if self.stage == len(self.motion.stages):
            self.stage -= 1
            ended = posture_of(belief, q)
            if ended is self.motion.end:
                self.state = State.DONE
            else:
                self._fail(f"ended {ended}, not {self.motion.end}")
            return
        self._enter(now, tilt, rate)

    def _watch(self, now: float, tilt: Tilt, q: Array) -> None:
        """Fail when the trunk is where it must not be or the joints do not follow."""
        window, guard = self.motion.stages[self.stage].window, self.motion.guard
        if window is not None and not window.holds(tilt):
            self._fail(f"trunk at pitch {tilt.pitch_B:.2f}, lean {tilt.lean_B:.2f} rad")
            return
        assert self._sent is not None
        far = float(np.abs(self._sent - q).max()) > guard.error
        self._far_since = min(self._far_since, now) if far else np.inf
        if now - self._far_since > guard.seconds:
            self._fail(f"joints more than {guard.error:g} rad off for {guard.seconds:g} s")

    def _fail(self, reason: str) -> None:
        self.state = State.FAILED
        self.reason = f"{self.motion.name}, stage {self.stage}: {reason}"


def added(stage: Stage, share: float, tilt: Tilt, rate: float) -> Array:
    """(22,) what a stage's feedback adds to the targets [rad].

    Args:
        stage: Whose feedback.
        share: Of the stage's move, 0 to 1.
        tilt: Of the trunk.
        rate: Of its pitch [rad/s].
    """
    extra = np.zeros(stage.q.shape)
    course = (
        np.interp(share, np.linspace(0.0, 1.0, len(stage.pitch)), stage.pitch)
        if stage.pitch
        else None
    )
    for f in stage.feedback:
        wanted = f.pitch if course is None else float(course)
        change = f.k_p * wrapped(tilt.pitch_B - wanted) + f.k_d * rate
        extra[joint_index(f.joint)] += min(max(change, -MOST_ADDED), MOST_ADDED)
    return extra
