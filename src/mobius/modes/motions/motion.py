"""A motion as data: key poses of all joints, how fast, until when, and what must hold."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf, isfinite
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mobius.errors import InvalidInput, UnknownName
from mobius.model.build import joint_ranges
from mobius.model.dimensions import MIN_CRANK_SPREAD
from mobius.model.joints import JOINTS, LIMB_JOINTS, joint_index
from mobius.modes.motions.tilt import ANGLES, Tilt, wrapped
from mobius.modes.posture import Posture
from mobius.types import frozen_array

Array = NDArray[np.float64]

SLACK = 1e-6
"""Key poses may miss a joint limit by this [rad]: their files hold rounded numbers."""


def number(owner: str, name: str, value: Any, *, low: float = -inf) -> None:
    """Refuse what is no finite number, or one below ``low``."""
    fine = isinstance(value, int | float) and not isinstance(value, bool) and isfinite(value)
    if not fine or value < low:
        least = "" if low == -inf else f" >= {low:g}"
        raise InvalidInput(f"{owner}.{name}: expected a finite number{least}, got {value!r}")


@dataclass(frozen=True)
class Until:
    """A condition on the believed trunk angle: above one bound, below another, or both.

    With ``above`` > ``below`` the angles from ``above`` over pi to ``below`` are meant.
    """

    angle: str
    """``pitch_B`` or ``roll_B`` (:mod:`mobius.modes.motions.tilt`)."""
    above: float | None = None
    """[rad]."""
    below: float | None = None
    """[rad]."""

    def __post_init__(self) -> None:
        if self.angle not in ANGLES:
            raise UnknownName("trunk angle", str(self.angle), ANGLES)
        if self.above is None and self.below is None:
            raise InvalidInput("Until: expected 'above', 'below' or both [rad], got neither")
        for name in ("above", "below"):
            if getattr(self, name) is not None:
                number("Until", name, getattr(self, name))

    def holds(self, tilt: Tilt) -> bool:
        """Whether the condition is met."""
        angle = tilt.pitch_B if self.angle == "pitch_B" else tilt.roll_B
        over = self.above is None or angle > self.above
        under = self.below is None or angle < self.below
        if self.above is not None and self.below is not None and self.above > self.below:
            return over or under
        return over and under


@dataclass(frozen=True)
class Feedback:
    """Moves one joint's target with the trunk: ``k_p (pitch_B - pitch) + k_d w_B[1]``."""

    joint: str
    """Of JOINTS."""
    k_p: float
    """[rad/rad]."""
    k_d: float
    """[rad s/rad]."""
    pitch: float = 0.0
    """``pitch_B`` at which it adds nothing [rad], unless the stage gives its course."""

    def __post_init__(self) -> None:
        joint_index(str(self.joint))
        for name in ("k_p", "k_d", "pitch"):
            number(f"Feedback of {self.joint}", name, getattr(self, name))


@dataclass(frozen=True)
class Window:
    """Where the trunk may be during a stage; leaving it fails the motion."""

    pitch: float = 0.0
    """Middle of the allowed ``pitch_B`` [rad]."""
    within: float = inf
    """Half of the allowed range of ``pitch_B`` [rad], counted round the circle."""
    lean: float = inf
    """Largest ``|lean_B|`` [rad]."""

    def __post_init__(self) -> None:
        number("Window", "pitch", self.pitch)
        for name in ("within", "lean"):
            if not getattr(self, name) > 0:
                raise InvalidInput(
                    f"Window.{name}: expected an angle > 0 [rad], got {getattr(self, name)!r}"
                )

    def holds(self, tilt: Tilt) -> bool:
        """Whether the trunk is inside."""
        return (
            abs(wrapped(tilt.pitch_B - self.pitch)) <= self.within and abs(tilt.lean_B) <= self.lean
        )


@dataclass(frozen=True, eq=False)
class Stage:
    """One move to a key pose, and what follows before the next."""

    q: Array
    """(22,) servo targets at its end [rad], order JOINTS."""
    seconds: float
    """Time of the move [s]; targets start and end without speed and acceleration."""
    hold: float = 0.0
    """Time at the pose afterwards [s]; a stage with ``until`` does not use it."""
    until: Until | None = None
    """Ends the stage as soon as it holds, even within the move, and only then."""
    timeout: float = 1.0
    """Fails the motion when ``until`` does not hold this long after the move's end [s]."""
    feedback: tuple[Feedback, ...] = ()
    """Added to the targets while the stage lasts."""
    window: Window | None = None
    """Where the trunk must be meanwhile."""
    through: Array = field(default_factory=lambda: np.zeros((0, len(JOINTS))))
    """(k, 22) targets on the way to ``q`` [rad], evenly spaced along it; the way is a monotone
    cubic (PCHIP), so that it overshoots none of them."""
    pitch: tuple[float, ...] = ()
    """Course of ``pitch_B`` [rad] that the feedback compares with, evenly spaced from the start
    of the move to its end; each feedback's own pitch where it is empty."""

    def __post_init__(self) -> None:
        frozen_array(self, "q", self.q, (len(JOINTS),))
        frozen_array(self, "through", self.through, (None, len(JOINTS)))
        for pose in self.through:
            check_pose(pose)
        object.__setattr__(self, "pitch", tuple(self.pitch))
        for value in self.pitch:
            number("Stage", "pitch", value)
        number("Stage", "seconds", self.seconds, low=1e-3)
        number("Stage", "hold", self.hold, low=0.0)
        number("Stage", "timeout", self.timeout, low=0.0)
        object.__setattr__(self, "feedback", tuple(self.feedback))
        check_pose(self.q)


@dataclass(frozen=True)
class Guard:
    """When a motion is blocked: joints stay far from their targets for long."""

    error: float = 1.0
    """Angle between a joint and its target that counts as far [rad]. A servo gives its stall
    torque from 0.22 rad on, and a fast move trails its target by more than that."""
    seconds: float = 0.8
    """How long [s]."""

    def __post_init__(self) -> None:
        number("Guard", "error", self.error, low=1e-3)
        number("Guard", "seconds", self.seconds, low=0.0)


@dataclass(frozen=True, eq=False)
class Motion:
    """A named sequence of stages from one posture to another."""

    name: str
    start: Posture
    """Posture it begins in."""
    end: Posture
    """Posture it ends in."""
    stages: tuple[Stage, ...]
    guard: Guard = field(default_factory=Guard)

    def __post_init__(self) -> None:
        for what in ("start", "end"):
            if getattr(self, what) not in list(Posture):
                raise UnknownName("posture", str(getattr(self, what)), list(Posture))
            object.__setattr__(self, what, Posture(getattr(self, what)))
        object.__setattr__(self, "stages", tuple(self.stages))
        if not self.stages:
            raise InvalidInput(f"motion '{self.name}': expected at least one stage, got none")

    @property
    def seconds(self) -> float:
        """Shortest time [s] without conditions: all moves and holds."""
        return sum(s.seconds + (0.0 if s.until else s.hold) for s in self.stages)


_LOW, _HIGH = np.array([joint_ranges()[j] for j in JOINTS]).T
_TOP = np.array([s.start + 1 for s in LIMB_JOINTS.values()])


def check_pose(q: Array) -> None:
    """Refuse targets (22,) [rad] beyond a joint's limits or off the five-bars' branch."""
    off = np.flatnonzero((q < _LOW - SLACK) | (q > _HIGH + SLACK))
    if off.size:
        k = int(off[0])
        raise InvalidInput(
            f"q of {JOINTS[k]}: expected {_LOW[k]:.4f} to {_HIGH[k]:.4f} rad, got {q[k]:.4f}"
        )
    spread = q[_TOP + 1] - q[_TOP]
    close = np.flatnonzero(spread < MIN_CRANK_SPREAD - SLACK)
    if close.size:
        k = int(close[0])
        raise InvalidInput(
            f"q of {JOINTS[_TOP[k]]} and {JOINTS[_TOP[k] + 1]}: expected cranks at least"
            f" {MIN_CRANK_SPREAD:.2f} rad apart, got {spread[k]:.4f}"
        )
