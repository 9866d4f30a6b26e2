"""How well a robot moves: slip, chatter, joint speed, torque, power, height, stillness.

A :class:`Gauge` looks at the simulated robot 300 times a second; what it saw becomes
:class:`Readings`, whose methods are the figures. All is measured on the true state.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mobius.control.bodies import body_of
from mobius.model.joints import LIMB_JOINTS
from mobius.model.robot import keyframe
from mobius.robot import TICK
from mobius.stack import READ_EVERY, Heights
from mobius.types import LIMBS

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

CONTACT_FORCE = 1.0
"""A foot is on the ground while it presses with more than this [N]; the robot weighs 101 N."""
CHATTER_S = 0.05
"""Contacts shorter than this are chatter [s]."""
SATURATED = 0.95
"""Share of the stall torque from which a servo counts as saturated."""
DT = READ_EVERY * TICK
"""Time between two looks [s]."""
_LIMB = slice(0, max(s.stop for s in LIMB_JOINTS.values()))
_RPM = 60 / (2 * np.pi)


@dataclass(frozen=True, eq=False)
class Readings:
    """n looks at a robot with f feet and 20 limb joints, 1/300 s apart."""

    tick: NDArray[np.int64]
    """(n,) of 1/600 s."""
    force: Array
    """(n, f) normal force on the ground [N]."""
    slide: Array
    """(n, f) speed of a foot along the ground at its contact points [m/s]."""
    dq: Array
    """(n, 20) joint rates [rad/s]."""
    torque: Array
    """(n, 20) servo torque at the output, drive minus back-EMF [N m]."""
    p: Array
    """(n, 3) trunk [m]."""
    height: Array
    """(n,) of the trunk over the ground below it [m]."""
    stance: float
    """The height it stands at [m]."""
    stall: Array
    """(20,) stall torque [N m]."""
    slope: Array
    """(20,) loss of torque with speed [N m s/rad]."""

    @property
    def t(self) -> Array:
        """(n,) [s]."""
        return np.asarray(TICK * self.tick, dtype=float)

    @property
    def contact(self) -> Flags:
        """(n, f) whether a foot is on the ground."""
        return self.force > CONTACT_FORCE

    def slip(self, rows: Flags) -> tuple[float, float]:
        """Path [m] that the feet slid while on the ground, mean over feet, and how far [m] the
        trunk came, straight from the first to the last of ``rows`` (n,), which are one run.
        """
        at = np.flatnonzero(rows)
        if len(at) < 2:
            return 0.0, 0.0
        slid = float((self.slide[at] * self.contact[at]).sum(axis=0).mean() * DT)
        return slid, float(np.linalg.norm(self.p[at[-1], :2] - self.p[at[0], :2]))

    def contact_times(self, *, after_s: float = 0.0) -> Array:
        """(k,) lengths [s] of all contacts that begin after ``after_s`` and end in sight."""
        times: list[float] = []
        for on in self.contact.T:
            steps = np.diff(on.astype(np.int8))
            begin, end = np.flatnonzero(steps > 0) + 1, np.flatnonzero(steps < 0) + 1
            if on[0]:
                end = end[1:]
            begin = begin[: len(end)]
            seen = self.t[begin] >= after_s
            times += ((end - begin)[seen] * DT).tolist()
        return np.array(times)

    def chatter(self, *, after_s: float = 0.0) -> tuple[int, int]:
        """How many contacts were chatter, and of how many."""
        times = self.contact_times(after_s=after_s)
        return int((times < CHATTER_S - 0.5 * DT).sum()), len(times)

    def lifts(self, rows: Flags) -> int:
        """How often a foot left the ground within ``rows`` (n,), which are one run."""
        return int((np.diff(self.contact[rows].astype(np.int8), axis=0) < 0).sum())

    def max_dq_rpm(self) -> float:
        """Fastest joint [rpm]."""
        return float(np.abs(self.dq).max() * _RPM)

    def saturation(self) -> float:
        """Share of joint-samples whose output torque exceeds 95 % of stall."""
        return float((np.abs(self.torque) > SATURATED * self.stall).mean())

    def torque_peak(self) -> Array:
        """(20,) largest torque as a share of the servo's torque-speed line at that moment.

        A servo that drives its joint may give stall torque less the slope times speed, one that
        brakes stall torque. MuJoCo's servo keeps to the line when driving by construction;
        when braking its back-EMF can carry it above 1.
        """
        driving = self.torque * self.dq > 0
        line = self.stall - np.where(driving, self.slope * np.abs(self.dq), 0.0)
        return np.asarray((np.abs(self.torque) / np.maximum(line, 0.01 * self.stall)).max(axis=0))

    def power(self) -> Array:
        """(n,) mechanical power, sum of |torque * rate| [W]."""
        return np.abs(self.torque * self.dq).sum(axis=1)

    def height_error(self, rows: Flags | slice = slice(None)) -> float:
        """Largest difference between the trunk's height and that of the stance [m]."""
        return float(np.abs(self.height[rows] - self.stance).max())


class Gauge:
    """Watches a simulated robot; :meth:`look` at every tick that the stack reads at."""

    def __init__(self, robot: Any, *, body: str, ground: Heights | None = None) -> None:
        """Watch ``robot``.

        Args:
            robot: A SimRobot.
            body: Which limbs are feet, and how high it stands.
            ground: Height of the floor; flat at 0 if not given.
        """
        self.robot, self.ground = robot, ground
        self._feet = [LIMBS.index(limb) for limb in body_of(body).feet]
        self._stance = float(keyframe(body_of(body).keyframe)[0][2])
        self._tick: list[int] = []
        self._rows: list[tuple[Array, ...]] = []

    def look(self) -> None:
        """Take one reading."""
        robot = self.robot
        force, slide = robot.sole_contact()
        rates = robot.data.qvel[robot.at.dof]
        self._tick.append(robot.tick)
        self._rows.append((force, slide, rates, robot.torque(), robot.data.qpos[:3].copy()))

    def readings(self) -> Readings:
        """All that was seen so far."""
        force, slide, dq, torque, p = (np.stack(column) for column in zip(*self._rows, strict=True))
        floor = 0.0 if self.ground is None else self.ground(p[:, :2])
        stall, slope = self.robot.servo_line()
        return Readings(
            tick=np.array(self._tick),
            force=force[:, self._feet],
            slide=slide[:, self._feet],
            dq=dq[:, _LIMB],
            torque=torque[:, _LIMB],
            p=p,
            height=p[:, 2] - floor,
            stance=self._stance,
            stall=stall[_LIMB],
            slope=slope[_LIMB],
        )
