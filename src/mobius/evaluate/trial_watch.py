"""What a trial is judged by: posture, rotation, way and torque of the true robot at 300 Hz."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mobius.evaluate.trial_start import TrialStart
from mobius.geometry import heading_yaw, quat_conj, rotate, wrap_angle
from mobius.model.robot import keyframe
from mobius.modes import Posture, posture_of
from mobius.robot import TICK
from mobius.stack import READ_EVERY
from mobius.types import StateEstimate

Array = NDArray[np.float64]

DT = READ_EVERY * TICK
"""Time between two looks [s]."""
LEVEL = float(np.radians(20.0))
"""A roll ends when the trunk, turned over, is level again within this."""
OVER = float(np.radians(80.0))
"""A trunk that has turned back by this is going over: its hands were on the floor for the last
time, and that is where the roll began [rad]."""
NEARLY_ROUND = float(np.radians(300.0))
"""Turned back by this, the next level is the one after the roll [rad]."""
TOUCH = 1.0
"""Force of a hand on the floor [N]."""
PUSH_UP = 0.05
"""The trunk goes down and up again by this [m] in a push-up."""
UPRIGHT = float(np.cos(np.radians(30.0)))
"""Share of the floor's normal along the trunk's proper axis in a good stance (30 deg)."""
STANCE_HEIGHT = {
    Posture.CRAWLING: (float(keyframe("crawl")[0][2]), 0.07),
    Posture.STANDING: (float(keyframe("stand")[0][2]), 0.09),
}
"""Trunk's height in a stance [m] and how far off it may be."""
_AXIS = {Posture.CRAWLING: 2, Posture.STANDING: 0}
LIMBS_END = 20
"""Joints of arms and legs; grippers are not looked at."""


@dataclass
class PushUpCounter:
    """Counts how often a height went down by :data:`PUSH_UP` and up again."""

    count: int = 0
    _down: bool = False
    _extreme: float = -np.inf

    def see(self, height: float) -> None:
        """Take in one height [m]."""
        if not self._down:
            self._extreme = max(self._extreme, height)
            if height < self._extreme - PUSH_UP:
                self._down, self._extreme = True, height
        else:
            self._extreme = min(self._extreme, height)
            if height > self._extreme + PUSH_UP:
                self._down, self._extreme = False, height
                self.count += 1


@dataclass
class Gathering:
    """What feet and trunk did while the robot gathered."""

    begun: int = 0
    """How often it did."""
    done: int = 0
    """How often it came to the end of it."""
    lean: float = 0.0
    """Farthest that the trunk was off the floor's normal [rad]."""
    slid: float = 0.0
    """Longest way that one foot slid while it pressed, each time by itself [m]."""
    force: float = 0.0
    """Hardest that a foot pressed on the floor [N]."""
    _slid: Array = field(default_factory=lambda: np.zeros(4))

    def begin(self) -> None:
        """Once more."""
        self.begun += 1
        self._slid = np.zeros(4)

    def see(self, normal_B: Array, force: Array, speed: Array) -> None:
        """Take in one look at the floor's normal (3,), forces (4,) [N] and speeds (4,) [m/s]."""
        self.lean = max(self.lean, float(np.arccos(min(1.0, float(normal_B[2])))))
        self._slid = self._slid + DT * np.where(force > TOUCH, speed, 0.0)
        self.slid = max(self.slid, float(self._slid.max()))
        self.force = max(self.force, float(force.max()))


@dataclass(eq=False)
class Watch:
    """Looks at the true robot whenever the stack has read it."""

    robot: Any
    """A SimRobot."""
    floor: TrialStart
    push_ups: PushUpCounter = field(default_factory=PushUpCounter)
    peak: Array = field(default_factory=lambda: np.zeros(LIMBS_END))
    """(20,) largest torque [N m]."""
    over_line: float = 0.0
    """Most that a driving servo gave beyond its torque-speed line [N m]."""
    rotation: float = 0.0
    """About the trunk's lateral axis since :meth:`start_roll` [rad]; backwards is negative."""
    roll_way: float = 0.0
    """Horizontal distance from where the hands let go of the floor to where the trunk was level
    again [m]."""
    roll_s: float = 0.0
    """Time between these [s]."""
    gathering: Gathering = field(default_factory=Gathering)
    gathers: bool = False
    """Whether it does now."""

    def __post_init__(self) -> None:
        self._stall, self._slope = (x[:LIMBS_END] for x in self.robot.servo_line())
        self._square, self._looks = np.zeros(LIMBS_END), 0
        self._left: tuple[float, Array] | None = None
        self.truth: StateEstimate = self.robot.truth()

    @property
    def rms(self) -> Array:
        """(20,) root mean square torque [N m]."""
        return np.sqrt(self._square / max(self._looks, 1))

    @property
    def now(self) -> float:
        """[s]."""
        return float(self.robot.tick * TICK)

    def look(self) -> None:
        """Take one reading."""
        robot, self.truth = self.robot, self.robot.truth()
        torque = robot.torque()[:LIMBS_END]
        rates = robot.data.qvel[robot.at.dof][:LIMBS_END]
        self.peak = np.maximum(self.peak, np.abs(torque))
        self._square, self._looks = self._square + torque**2, self._looks + 1
        driving = torque * rates > 0
        line = self._stall - self._slope * np.abs(rates)
        excess = np.where(driving, np.abs(torque) - np.maximum(line, 0.0), 0.0)
        self.over_line = max(self.over_line, float(excess.max()))
        self.rotation += float(self.truth.w_B[1]) * DT
        self.push_ups.see(self.height)
        self._follow_roll()
        if self.gathers:
            self.gathering.see(self._normal_B, *robot.sole_contact())

    @property
    def height(self) -> float:
        """Of the trunk over the floor [m]."""
        return self.floor.height(self.truth.p_OB)

    @property
    def heading(self) -> float:
        """Of the crawling body [rad]."""
        return float(heading_yaw("crawl", self.truth.q_OB))

    def start_roll(self) -> None:
        """Count rotation and way from here."""
        self.rotation, self.roll_way, self.roll_s = 0.0, 0.0, 0.0
        self._left = None

    def _follow_roll(self) -> None:
        if self.rotation > -OVER:
            if float(self.robot.contact_force()[:2].max()) > TOUCH:
                self._left = self.now, self.truth.p_OB.copy()
            return
        level = float(self._normal_B[2]) > np.cos(LEVEL)
        if level and self.rotation < -NEARLY_ROUND and self.roll_s == 0.0 and self._left:
            began, where = self._left
            self.roll_s = self.now - began
            self.roll_way = float(np.linalg.norm(self.truth.p_OB[:2] - where[:2]))

    @property
    def _normal_B(self) -> Array:
        return rotate(quat_conj(self.truth.q_OB), self.floor.normal)

    def is_in(self, posture: Posture) -> bool:
        """Whether the true robot is in a good stance: limbs, height and tilt over the floor."""
        height, off = STANCE_HEIGHT[posture]
        upright = float(self._normal_B[_AXIS[posture]]) > UPRIGHT
        high = abs(self.height - height) < off
        return upright and high and self.posture() is posture

    def fell_from(self, posture: Posture) -> bool:
        """Whether the true robot is no longer near a stance it was in."""
        height, off = STANCE_HEIGHT[posture]
        upright = float(self._normal_B[_AXIS[posture]]) > 0.6
        low = self.height < height - 1.5 * off
        return bool(not upright or low or self.robot.trunk_grounded())

    def posture(self) -> Posture:
        """The true posture."""
        return posture_of(self.truth, self.robot.data.qpos[self.robot.at.qpos])

    def belief_error(self, belief: StateEstimate) -> tuple[float, float]:
        """Distance over the floor [m] and angle of heading [rad] between belief and truth."""
        away = float(np.linalg.norm(belief.p_OB[:2] - self.truth.p_OB[:2]))
        yaw = float(heading_yaw("crawl", belief.q_OB)) - self.heading
        return away, float(abs(wrap_angle(yaw)))
