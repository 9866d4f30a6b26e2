"""What a robot of several bodies does along a plan, one thing after another.

Every task sees the belief and the mode the robot is really in, says what to command, and
ends. A task that walks stands still while the robot is in another mode than it walks in, as
after a fall, and asks for its own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mobius.errors import InvalidInput
from mobius.geometry import heading_yaw, wrap_angle
from mobius.modes.follow import FollowerConfig, PathFollower
from mobius.modes.legs import Leg
from mobius.types import Mode, ModeCommand, StateEstimate

Array = NDArray[np.float64]
Room = Callable[[Array], float]
"""Distance to obstacles [m] at a point (2,) [m]."""

ROLL_LENGTH = 1.4
"""Way of a roll, rearing up and stances included [m]: 0.22 m/s for 6.2 s (docs/motions.md)."""

PRIMARY = (Mode.CRAWL, Mode.BIPED)
"""Modes the robot can stay in."""


@dataclass(frozen=True)
class TaskConfig:
    """When a task is over, and how it moves."""

    settle: float = 0.5
    """Standing before and after a change of body or a roll [s]."""
    turned: float = 0.06
    """Heading error that a roll begins with at most [rad]."""
    faced: float = 0.25
    """And a change of body [rad]."""
    turn_rate: float = 0.8
    """Turning on the spot [rad/s]."""
    turn_gain: float = 1.6
    """Yaw rate per heading error [1/s]."""
    patience: float = 12.0
    """A turn or a small correction that takes longer is left as it is [s]."""
    near: float = 0.12
    """Distance to a landing point that counts as there [m]."""
    creep: float = 0.25
    """Speed of small corrections [m/s]."""
    position_gain: float = 1.2
    """Their speed per distance [1/s]."""
    ask: float = 4.0
    """A roll that has not begun so long after it was asked for is given up [s]."""
    roll_room: float = 0.45
    """Distance to obstacles that the line of a roll must keep [m]."""
    overshoot: float = 0.3
    """And this far beyond its end [m]."""


class Task:
    """One thing to do. ``mode`` is the body it is done in."""

    mode: Mode = Mode.CRAWL
    done: bool = False
    failures: int = 0
    """Motions that were asked for and did not come about."""

    @property
    def motion(self) -> Mode:
        """The mode that a motion of the task is for."""
        return self.mode

    def __init__(self, config: TaskConfig) -> None:
        self.config = config
        self._began: float | None = None

    def command(self, belief: StateEstimate, dt: float, actual: Mode) -> ModeCommand:
        """What to command now, ``dt`` [s] after the last time."""
        if self._began is None:
            self._began = belief.stamp
        if actual is not self.mode:
            self.interrupted()
            return stand(self.mode, belief)
        return self.move(belief, dt)

    def move(self, belief: StateEstimate, dt: float) -> ModeCommand:
        """The same, in the right body."""
        raise NotImplementedError

    def interrupted(self) -> None:
        """The robot is in another body now."""
        self._began = None

    def since(self, belief: StateEstimate) -> float:
        """How long the task has been on [s]."""
        return 0.0 if self._began is None else belief.stamp - self._began


def stand(mode: Mode, belief: StateEstimate) -> ModeCommand:
    """Stand in a mode, or change to it."""
    return ModeCommand(mode=mode, twist_H=np.zeros(3), stamp=belief.stamp)


def yaw_of(mode: Mode, belief: StateEstimate) -> float:
    """Heading of a body [rad]."""
    return float(heading_yaw("biped" if mode is Mode.BIPED else "crawl", belief.q_OB))


class Stand(Task):
    """Stand still for a while."""

    def __init__(self, mode: Mode, config: TaskConfig, *, seconds: float | None = None) -> None:
        super().__init__(config)
        self.mode, self._seconds = mode, config.settle if seconds is None else seconds

    def move(self, belief: StateEstimate, dt: float) -> ModeCommand:
        """Zero twist."""
        self.done = self.since(belief) >= self._seconds
        return stand(self.mode, belief)


class Become(Task):
    """Be another body: stop, ask for it until the robot is really in it, stand."""

    def __init__(self, mode: Mode, config: TaskConfig) -> None:
        super().__init__(config)
        self.mode = mode
        self._asked = self._away = False
        self._counted = False  # a failure that the robot still recovers from
        self._there: float | None = None

    def command(self, belief: StateEstimate, dt: float, actual: Mode) -> ModeCommand:
        """Ask; a change that ends in a recovery, or in the body it began in, has failed and is
        asked for anew.
        """
        if self._began is None:
            self._began = belief.stamp
        if actual is self.mode:
            if self._there is None:
                self._there = belief.stamp
            settle = self.config.settle if self._asked else 0.0
            self.done = belief.stamp - self._there >= settle
            return stand(self.mode, belief)
        self._there = None
        if actual in PRIMARY:
            if self._away:
                self.failures, self._away = self.failures + 1, False
            self._counted = False
            if not self._asked and self.since(belief) < self.config.settle:
                return stand(actual, belief)
        elif actual is Mode.RECOVER:
            if self._asked and not self._counted:
                self.failures, self._counted = self.failures + 1, True
            self._away = False
        else:
            self._away = self._asked
        self._asked = True
        return stand(self.mode, belief)


class Go(Task):
    """Follow a leg in its body."""

    def __init__(
        self, leg: Leg, follower: FollowerConfig, config: TaskConfig, *, room: Room | None,
        grid_yaw: float,
    ) -> None:  # fmt: skip
        super().__init__(config)
        self.mode = leg.mode
        self.follower = PathFollower(leg.as_plan(), follower, room=room, grid_yaw=grid_yaw)

    def interrupted(self) -> None:
        """The robot is in another body now."""
        super().interrupted()
        self.follower.halt()

    def move(self, belief: StateEstimate, dt: float) -> ModeCommand:
        """The follower's twist."""
        command = self.follower.command(belief, dt)
        self.done = self.follower.arrived
        return command


class Hold(Task):
    """Crawl to a point close by while turning to a heading, and stay there."""

    def __init__(
        self, xy: Array, heading: float, config: TaskConfig, *, turned: float, near: float
    ) -> None:
        super().__init__(config)
        self._xy, self._heading = xy, heading
        self._turned, self._near = turned, near
        self._still = 0.0

    def move(self, belief: StateEstimate, dt: float) -> ModeCommand:
        """A twist towards point and heading; done after a quarter of a second there."""
        c, yaw = self.config, yaw_of(Mode.CRAWL, belief)
        error = float(wrap_angle(self._heading - yaw))
        off = self._xy - belief.p_OB[:2]
        distance = float(np.linalg.norm(off))
        there = abs(error) <= self._turned and distance <= self._near
        self._still = self._still + dt if there else 0.0
        self.done = self._still >= 0.25 or self.since(belief) > c.patience
        velocity = c.position_gain * off
        if distance <= 0.5 * self._near:
            velocity = np.zeros(2)
        velocity *= min(1.0, c.creep / max(float(np.linalg.norm(velocity)), 1e-9))
        velocity *= max(np.cos(min(abs(error), np.pi / 2)), 0.15)
        turn = 0.0 if abs(error) <= 0.5 * self._turned else c.turn_gain * error
        cos, sin = np.cos(yaw), np.sin(yaw)
        twist = np.array(
            [
                cos * velocity[0] + sin * velocity[1],
                -sin * velocity[0] + cos * velocity[1],
                np.clip(turn, -c.turn_rate, c.turn_rate),
            ]
        )
        return ModeCommand(mode=Mode.CRAWL, twist_H=twist, stamp=belief.stamp)


class Roll(Task):
    """One roll, tail first, from a point to another; then in the crawl stance again.

    Once the robot rolls it is told to crawl, so that it rolls once only.
    """

    def __init__(self, xy: Array, to: Array, config: TaskConfig, *, room: Room | None) -> None:
        super().__init__(config)
        self._xy, self._to, self._room = xy, to, room
        self._rolling = False
        self.rolled = False
        """Whether it came about."""
        self.refused = False
        """Whether there was no room."""

    @property
    def motion(self) -> Mode:
        """It crawls before and after."""
        return Mode.ROLL

    def command(self, belief: StateEstimate, dt: float, actual: Mode) -> ModeCommand:
        """Ask for the roll, wait for its end."""
        if actual is Mode.ROLL:
            self._rolling = True
        elif self._rolling and actual is Mode.CRAWL:
            self.rolled = self.done = True
        elif actual is Mode.RECOVER:
            self.failures, self.done = self.failures + 1, True
        if self._rolling or self.done or actual is not Mode.CRAWL:
            return stand(Mode.CRAWL, belief)
        if self._began is None:
            self._began = belief.stamp
        if not self._fits(belief.p_OB[:2]):
            self.refused = self.done = True
        elif self.since(belief) > self.config.ask:
            self.failures, self.done = self.failures + 1, True
        if self.done:
            return stand(Mode.CRAWL, belief)
        return stand(Mode.ROLL, belief)

    def _fits(self, p: Array) -> bool:
        """Whether the line that the trunk will move along is clear."""
        return self._room is None or tightest(p, self._to, self._room, self.config) is None


def tightest(p: Array, to: Array, room: Room, config: TaskConfig) -> tuple[Array, float] | None:
    """The first place on the line of a roll that is too near to something.

    Args:
        p: Where the trunk is, (2,) [m], frame M.
        to: Where the roll ends, likewise.
        room: Distance [m] of a point to obstacles.
        config: ``roll_room`` and ``overshoot``.

    Returns:
        Place (2,) and its distance to obstacles [m]; None where the whole line is clear.
    """
    way = to - p
    length = max(float(np.linalg.norm(way)), 1e-9)
    for s in np.linspace(0.0, length + config.overshoot, int(10.0 * length) + 5):
        here = p + s / length * way
        distance = room(here)
        if distance < config.roll_room:
            return here, distance
    return None


def check_roll(belief: StateEstimate, room: Room, config: TaskConfig | None = None) -> None:
    """Whether a roll begun here would run into something, as the map knows it.

    Args:
        belief: Of a robot that crawls; it rolls away from its heading, tail first.
        room: Distance [m] of a point to obstacles.
        config: ``roll_room`` and ``overshoot``; the defaults if not given.

    Raises:
        InvalidInput: The line of the roll is not clear.
    """
    config = config or TaskConfig()
    xy, yaw = belief.p_OB[:2], yaw_of(Mode.CRAWL, belief)
    end = xy - ROLL_LENGTH * np.array([np.cos(yaw), np.sin(yaw)])
    tight = tightest(xy, end, room, config)
    if tight is not None:
        (x, y), distance = tight
        here = np.array_equal(tight[0], xy)
        raise InvalidInput(
            f"no roll: it goes {ROLL_LENGTH:g} m tail first and needs {config.roll_room:g} m to"
            f" obstacles, and there are {distance:.2f} m at ({x:.2f}, {y:.2f}) m"
            + (", where it stands; move away first" if here else "; turn the tail to open floor")
        )
