"""The mode machine of Fig. 6: from the mode that is wanted to the one that may be now.

A source (follower, schedule, joystick) wants a primary mode and a twist. The machine lets the
twist through while it is in that mode. Otherwise it inserts what lies between (Fig. 13): from
crawl to biped STAND_UP, back LIE_DOWN, and a roll begins and ends in crawl. Before a switch the
request must last, and the robot stand still. Where a crawl policy stands apart from the stance that
motions begin in, GATHER comes first; what it was begun for follows, whatever is wanted then. A
fall, a motion that failed or one that takes too long lead to RECOVER and from there to a stance.
What it does not do as asked it explains in :attr:`ModeMachine.notice` and
:attr:`ModeMachine.events`.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from mobius.errors import InvalidInput
from mobius.model.reach import longest_step
from mobius.modes.motions.player import State
from mobius.modes.posture import FallDetector, Posture, posture_of
from mobius.modes.trust import WALKING as TRUST_ALL
from mobius.modes.trust import Trust, TrustWatch
from mobius.types import Mode, ModeCommand, StateEstimate

_ALWAYS = (Mode.RECOVER, Mode.STOP)

SUCCESSORS: dict[Mode, frozenset[Mode]] = {
    Mode.CRAWL: frozenset(
        {Mode.CRAWL, Mode.GATHER, Mode.STAND_UP, Mode.ROLL, Mode.PUSH_UPS, *_ALWAYS}
    ),
    Mode.BIPED: frozenset({Mode.BIPED, Mode.LIE_DOWN, Mode.CLIMB, Mode.PULL_UP, *_ALWAYS}),
    Mode.ROLL: frozenset({Mode.ROLL, Mode.CRAWL, *_ALWAYS}),
    Mode.PUSH_UPS: frozenset({Mode.PUSH_UPS, Mode.CRAWL, *_ALWAYS}),
    Mode.GATHER: frozenset({Mode.GATHER, Mode.STAND_UP, Mode.ROLL, Mode.PUSH_UPS, *_ALWAYS}),
    Mode.STAND_UP: frozenset({Mode.STAND_UP, Mode.BIPED, *_ALWAYS}),
    Mode.LIE_DOWN: frozenset({Mode.LIE_DOWN, Mode.CRAWL, *_ALWAYS}),
    Mode.CLIMB: frozenset({Mode.CLIMB, Mode.BIPED, *_ALWAYS}),
    Mode.PULL_UP: frozenset({Mode.PULL_UP, Mode.BIPED, *_ALWAYS}),
    Mode.RECOVER: frozenset({Mode.RECOVER, Mode.CRAWL, Mode.BIPED, Mode.STOP}),
    Mode.STOP: frozenset({Mode.STOP, Mode.RECOVER, Mode.CRAWL, Mode.BIPED}),
}
"""Which mode may follow which (Fig. 6 and the transitions of Fig. 13)."""

AT_HOME = 0.045
"""Feet at most this far from where the motions begin [m] need not step there: motions start from
as far off after any walk."""
WALKING = (Mode.CRAWL, Mode.BIPED)
"""Modes that last until another is wanted."""
TOWARDS: dict[tuple[Mode, Mode], Mode] = {
    (Mode.CRAWL, Mode.BIPED): Mode.STAND_UP,
    (Mode.CRAWL, Mode.ROLL): Mode.ROLL,
    (Mode.CRAWL, Mode.PUSH_UPS): Mode.PUSH_UPS,
    (Mode.BIPED, Mode.CRAWL): Mode.LIE_DOWN,
    (Mode.BIPED, Mode.ROLL): Mode.LIE_DOWN,
    (Mode.BIPED, Mode.PUSH_UPS): Mode.LIE_DOWN,
}
"""(is, wanted) -> the next mode on the way."""
LEADS_TO = {
    Mode.STAND_UP: Mode.BIPED,
    Mode.LIE_DOWN: Mode.CRAWL,
    Mode.ROLL: Mode.CRAWL,
    Mode.PUSH_UPS: Mode.CRAWL,
    Mode.RECOVER: Mode.CRAWL,
}
"""Where a mode that ends by itself ends; GATHER in the step that it was inserted before."""


@dataclass(frozen=True)
class MachineConfig:
    """Hysteresis, patience, time-outs."""

    persist: float = 0.3
    """A request must last this long before anything happens [s]."""
    settle: float = 0.5
    """Then the robot is told to stand still for at least this long [s]."""
    settle_most: float = 2.0
    """And for at most this long when it does not come to rest [s]."""
    still: float = 0.08
    """A trunk slower than this [m/s] and :attr:`still_rate` stands still."""
    still_rate: float = 0.35
    """[rad/s]."""
    timeout: float = 15.0
    """A motion that lasts longer has failed [s]."""
    recover_timeout: float = 30.0
    """A recovery that lasts longer has failed [s]."""
    push_ups_timeout: float = 120.0
    """Push-ups that last longer have failed [s]."""
    calm: float = 5.0
    """A robot that has walked this long since its last recovery falls anew [s];"""
    tries: int = 4
    """one that has not, again: after so many recoveries in a row it stops."""


@dataclass(frozen=True, eq=False)
class Seen:
    """What the machine goes by besides the request."""

    belief: StateEstimate
    q: np.ndarray
    """(22,) joint angles [rad]."""
    state: str = State.RUNNING
    """Of the controller that is on: running, done or failed."""
    reason: str = ""
    """Why it failed."""
    apart: bool = False
    """Whether what is on stands elsewhere than where motions begin."""
    home: np.ndarray | None = None
    """(22,) joint angles where they begin [rad]; where it is not known, who is apart gathers."""


@dataclass(frozen=True)
class Event:
    """One switch or refusal."""

    stamp: float
    """[s]."""
    before: Mode
    after: Mode
    """The same as ``before`` where a request was refused."""
    why: str


@dataclass
class ModeMachine:
    """Lets through the modes that the robot can be and may switch to."""

    available: frozenset[Mode]
    """Modes with a controller."""
    mode: Mode = Mode.CRAWL
    config: MachineConfig = field(default_factory=MachineConfig)
    events: list[Event] = field(default_factory=list, init=False)
    """Every switch and refusal so far."""
    notice: str = field(default="", init=False)
    """Why the last request is not being carried out; empty when it is."""

    def __post_init__(self) -> None:
        if self.mode not in self.available:
            names = ", ".join(sorted(self.available))
            raise InvalidInput(f"start mode '{self.mode}' has no controller; available: {names}")
        self._home = self.mode if self.mode in WALKING else Mode.CRAWL
        self._falls = FallDetector()
        self._since = -np.inf  # in this mode; the first step sets it
        self._wanted, self._wanted_since = self.mode, np.inf
        self._stamp, self._stale = 0.0, False
        self._gathers_for = Mode.CRAWL
        self._walks_since, self._tries = -np.inf, 0
        self._watch, self._trust = TrustWatch(), TRUST_ALL

    @property
    def stopped(self) -> bool:
        """Whether the emergency stop holds."""
        return self.mode is Mode.STOP

    @property
    def trust(self) -> Trust:
        """Which sources the estimator may trust now."""
        return self._trust

    def emergency_stop(self, why: str = "emergency stop") -> None:
        """From any state: soft servos until the robot rests, then it holds; until release."""
        if not self.stopped:
            self._switch(Mode.STOP, why)
        self.notice = f"{why}; call release() to go on"

    def release(self) -> None:
        """End the emergency stop: recover to a stance, or go on where there is no recovery."""
        if self.stopped:
            self.notice = ""
            self._switch(Mode.RECOVER if Mode.RECOVER in self.available else self._home, "release")
            self._stale = True  # the next step still sees the controller of before

    def step(self, wanted: ModeCommand, seen: Seen | None = None) -> ModeCommand:
        """The command to carry out; call at 60 Hz.

        Args:
            wanted: A primary mode and its twist.
            seen: Belief, joints and how far the controller is; without it falls and ends of
                motions are not noticed.

        Raises:
            InvalidInput: The wanted mode has no controller.
        """
        command = self._step(wanted, seen)
        self._trust = self._watch.see(self.mode, None if seen is None else seen.belief)
        return command

    # -- inside --------------------------------------------------------------------------

    def _step(self, wanted: ModeCommand, seen: Seen | None) -> ModeCommand:
        self._stamp = wanted.stamp
        if self.stopped:
            return self._still()
        if wanted.mode not in self.available:
            names = ", ".join(sorted(self.available))
            raise InvalidInput(f"mode '{wanted.mode}' has no controller yet; available: {names}")
        if self._since == -np.inf:
            self._since = self._stamp
        if self._stale:
            self._stale = False
        elif self.mode in LEADS_TO or self.mode is Mode.GATHER:
            self._follow_motion(seen)
        elif Mode.RECOVER in self.available and seen is not None:
            why = self._falls.fallen(self.mode, seen.belief, seen.q)
            if why:
                self._switch(Mode.RECOVER, why)
        if self.mode in WALKING:
            if self.mode is wanted.mode:
                self._wanted, self.notice = self.mode, ""
                return wanted
            self._approach(wanted.mode, seen)
        return self._still()

    def _still(self) -> ModeCommand:
        return ModeCommand(mode=self.mode, twist_H=np.zeros(3), stamp=self._stamp)

    def _follow_motion(self, seen: Seen | None) -> None:
        """Leave a mode that ends by itself when it is done, failed or takes too long."""
        if seen is None:
            return
        most = {
            Mode.RECOVER: self.config.recover_timeout,
            Mode.PUSH_UPS: self.config.push_ups_timeout,
        }.get(self.mode, self.config.timeout)
        if seen.state == State.DONE:
            self._switch(self._reached(seen), f"{self.mode} done")
        elif seen.state == State.FAILED:
            self._failed(seen.reason or f"{self.mode} failed")
        elif self._stamp - self._since > most:
            self._failed(f"{self.mode} not done after {most:g} s")

    def _reached(self, seen: Seen) -> Mode:
        """The mode that a finished one leads to; a recovery may end standing."""
        if self.mode is Mode.GATHER:
            return self._gathers_for
        if self.mode is Mode.RECOVER and Mode.BIPED in self.available:
            standing = posture_of(seen.belief, seen.q) is Posture.STANDING
            if standing or Mode.CRAWL not in self.available:
                return Mode.BIPED
        return LEADS_TO[self.mode]

    def _failed(self, why: str) -> None:
        if self.mode is not Mode.RECOVER and Mode.RECOVER in self.available:
            self._switch(Mode.RECOVER, why)
        else:
            self.emergency_stop(why)

    def _approach(self, wanted: Mode, seen: Seen | None) -> None:
        """Wait out hysteresis and settling, then take the next step towards a mode."""
        if wanted is not self._wanted:
            self._wanted, self._wanted_since = wanted, self._stamp
        step = TOWARDS.get((self.mode, wanted))
        if step is None or step not in self.available or step not in SUCCESSORS[self.mode]:
            self._refuse(wanted, step)
            return
        self.notice = f"on the way from {self.mode} to {wanted}"
        asked = self._stamp - self._wanted_since
        if asked >= self.config.persist + self.config.settle - 1e-9 and (
            self._is_still(seen) or asked >= self.config.persist + self.config.settle_most
        ):
            if seen is not None and self._must_gather(seen):
                self._gathers_for, step = step, Mode.GATHER
            self._switch(step, f"{wanted} wanted")

    def _must_gather(self, seen: Seen) -> bool:
        """Whether the feet must step to where motions begin; one that has just stood up from a
        motion and not walked since stands there already.
        """
        if not seen.apart or Mode.GATHER not in self.available:
            return False
        return seen.home is None or longest_step(seen.q, seen.home) > AT_HOME

    def _is_still(self, seen: Seen | None) -> bool:
        if seen is None:
            return True
        speed = float(np.linalg.norm(seen.belief.v_B))
        rate = float(np.linalg.norm(seen.belief.w_B))
        return speed < self.config.still and rate < self.config.still_rate

    def _refuse(self, wanted: Mode, step: Mode | None) -> None:
        legal = [b for (a, b), via in TOWARDS.items() if a is self.mode and via in self.available]
        names = ", ".join(sorted({self.mode, *legal}))
        lacks = "" if step is None else f" without a motion '{step}'"
        why = f"mode '{wanted}' may not follow '{self.mode}'{lacks}; legal: {names}"
        if self.notice != why:
            self.notice = why
            self.events.append(Event(self._stamp, self.mode, self.mode, why))

    def _switch(self, mode: Mode, why: str) -> None:
        assert mode in SUCCESSORS[self.mode], f"{mode} after {self.mode}"
        if mode in WALKING:
            self._walks_since = self._stamp
        elif mode is Mode.RECOVER:
            calm = self._stamp - self._walks_since > self.config.calm and self.mode in WALKING
            self._tries = 1 if calm else self._tries + 1
            if self._tries > self.config.tries:
                mode, why = Mode.STOP, f"{why}; fallen {self._tries} times in a row"
                self.notice = f"{why}; call release() to go on"
        self.events.append(Event(self._stamp, self.mode, mode, why))
        self.mode, self._since = mode, self._stamp
        self._wanted, self._wanted_since = mode, self._stamp
        self._falls.reset()
