"""Back to a stance from any fall: look how it lies, play the motion for that, look again."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.errors import InvalidInput
from mobius.modes.motions.motion import Motion, Stage
from mobius.modes.motions.player import MOTION_EVERY, MotionPlayer, State
from mobius.modes.posture import Posture, posture_of
from mobius.modes.rest import DampedHold
from mobius.types import JointCommand, ModeCommand, SensorFrame, StateEstimate

Array = NDArray[np.float64]

WAYS_UP: dict[Posture, tuple[str, ...]] = {
    Posture.PRONE: ("prone_to_crawl",),
    Posture.SUPINE: ("supine_to_crawl", "supine_recovery"),
    Posture.ON_HEAD: ("head_recovery",),
    Posture.LEFT_SIDE: ("supine_to_crawl", "prone_to_crawl"),
    Posture.RIGHT_SIDE: ("supine_to_crawl", "prone_to_crawl"),
    Posture.STANDING: ("stand_to_crawl",),
    Posture.CRAWLING: ("crawl_to_stand",),
    Posture.OTHER: ("supine_to_crawl", "prone_to_crawl", "stand_to_crawl"),
}
"""Motions for each posture, the best first. The next is tried when one has failed here, or is
not there; lying askew, any motion that stirs the limbs ends in a clearer posture."""

LOOK_S = 1 / 30
"""Between motions it looks how it lies this often [s]."""
SLOW = 1.0
"""A trunk that turns slower than this is not falling [rad/s]."""


@dataclass(frozen=True)
class RecoveryConfig:
    """When to give up."""

    tries: int = 8
    """Motions played at most."""
    timeout: float = 25.0
    """Time in all [s]."""
    to_stance: float = 0.5
    """Time of the last move into the stance [s]."""
    patience: float = 0.6
    """After a motion that ended well it keeps the last targets this long for the trunk to come
    to rest, before it goes soft [s]."""


@dataclass
class Recovery:
    """Plays motions until the robot is in its stance (a :class:`mobius.stack.Controller`).

    While the robot is still falling its servos are soft (:class:`DampedHold`). Sees belief and
    encoders only.
    """

    motions: Mapping[str, Motion]
    """By name; those of :data:`WAYS_UP` that are there."""
    stances: Mapping[Posture, Array]
    """Servo targets (22,) [rad] of each stance that ends it: crawling, standing or both."""
    config: RecoveryConfig = field(default_factory=RecoveryConfig)

    every = MOTION_EVERY

    def __post_init__(self) -> None:
        wrong = [p.value for p in self.stances if p not in (Posture.CRAWLING, Posture.STANDING)]
        if wrong or not self.stances:
            raise InvalidInput(
                "Recovery.stances: expected targets of 'crawling' or 'standing', got"
                f" {', '.join(wrong) or 'none'}"
            )
        self.reset()

    def reset(self) -> None:
        """Start anew."""
        self.state: State = State.RUNNING
        self.reason = ""
        """Why it gave up."""
        self.log: list[tuple[float, str, str]] = []
        """(stamp [s], posture, motion) of every motion played."""
        self._soft = DampedHold(joints_too=False)
        self._player: MotionPlayer | None = None
        self._last = False
        self._failed: dict[Posture, list[str]] = {}
        self._began: float | None = None
        self._sent: Array | None = None
        self._reached: Posture | None = None
        self._patient_until = self._look_at = -np.inf

    def begin(self, targets: ArrayLike) -> None:
        """Tell the targets (22,) [rad] that were sent last."""
        self._sent = np.array(targets, dtype=float)

    def act(self, command: ModeCommand, belief: StateEstimate, frame: SensorFrame) -> JointCommand:
        """Targets of all joints for this moment."""
        now = frame.stamp
        if self._began is None:
            self._began = now
        if self.state is State.RUNNING and now - self._began > self.config.timeout:
            self._give_up(f"not up after {self.config.timeout:g} s")
        if self.state is not State.RUNNING:
            return JointCommand(q=frame.q if self._sent is None else self._sent, stamp=now)
        if self._player is None and now >= self._look_at:
            self._look_at = now + LOOK_S - 1e-9
            self._decide(belief, frame)
        if self._player is None and now < self._patient_until and self._sent is not None:
            return JointCommand(q=self._sent, stamp=now)
        sent = (self._player or self._soft).act(command, belief, frame)
        self._sent = np.array(sent.q)
        if self._player is not None and self._player.state is not State.RUNNING:
            self._over(now)
        return sent

    def _over(self, now: float) -> None:
        """A motion ended, well or not: look again, or be done."""
        player = self._player
        assert player is not None
        well = player.state is State.DONE
        if self._last and well:
            self.state = State.DONE
        elif not well and self.log:
            posture, name = Posture(self.log[-1][1]), self.log[-1][2]
            self._failed.setdefault(posture, []).append(name)
        self._reached = player.motion.end if well else None
        self._patient_until = now + self.config.patience if well else -np.inf
        self._player, self._last, self._soft = None, False, DampedHold(joints_too=False)

    def _decide(self, belief: StateEstimate, frame: SensorFrame) -> None:
        """Start the motion for this posture once the robot rests.

        In a stance, upright, or where the last motion meant to end, it need not go soft first.
        """
        posture = posture_of(belief, frame.q)
        slow = float(np.abs(belief.w_B).max()) < SLOW
        meant = posture in (Posture.STANDING, self._reached)
        if posture in self.stances and slow:
            self._play(self._to_stance(posture), belief.stamp, posture)
            self._last = True
        elif self._soft.resting or (meant and slow):
            motion = self._choose(posture)
            if motion is None:
                self._give_up(f"no motion for a robot that is '{posture}'")
            elif len(self.log) >= self.config.tries:
                self._give_up(f"not up after {self.config.tries} motions")
            else:
                self._play(motion, belief.stamp, posture)

    def _choose(self, posture: Posture) -> Motion | None:
        """The best motion that has not failed here; when all have, the best one again."""
        there = [name for name in WAYS_UP.get(posture, ()) if name in self.motions]
        there.sort(key=lambda name: self.motions[name].end not in self.stances)
        failed = self._failed.get(posture, [])
        fresh = [name for name in there if name not in failed]
        if there and not fresh:
            self._failed[posture] = []
        return self.motions[(fresh or there)[0]] if there else None

    def _to_stance(self, posture: Posture) -> Motion:
        stage = Stage(self.stances[posture], self.config.to_stance, hold=0.1)
        return Motion(f"to_{posture}", posture, posture, (stage,))

    def _play(self, motion: Motion, stamp: float, posture: Posture) -> None:
        self._player = MotionPlayer(motion)
        if self._sent is not None:
            self._player.begin(self._sent)
        self.log.append((stamp, posture.value, motion.name))

    def _give_up(self, reason: str) -> None:
        self.state, self.reason = State.FAILED, f"recovery: {reason}"
