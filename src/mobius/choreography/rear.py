"""From four limbs to two and back: feet under the hips, rear up over them, rise (Fig. 13 B, D).

Everything but the last rise is quasi-static: the centre of mass stays over the limbs that
stand. The arms cannot push the trunk all the way up, so it leans back until its weight is on
the feet, and only then the hands let go.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mobius.choreography.keys import sampled, within_limits
from mobius.model.dimensions import HIP_X
from mobius.model.reach import body_joints, nose_up
from mobius.model.robot import keyframe_joints
from mobius.modes.motions import Feedback, Motion, Stage, Window
from mobius.modes.posture import Posture

Array = NDArray[np.float64]
Numbers = Mapping[str, float]

HEIGHT = 0.275
"""Trunk of the crawl stance [m]."""
HAND, FOOT = np.array([0.26, 0.266, 0.0]), np.array([-0.221, 0.259, 0.0])
"""Left hand and foot of the crawl stance [m], trunk over the origin."""
FOOT_Y = 0.136
"""Left foot under its hip [m]."""
STAND_HEIGHT = 0.474
"""Trunk of the stand [m]."""
MIRROR = np.array([1.0, -1.0, 1.0])
UPRIGHT = -0.5 * np.pi
ON_FOUR = Window(pitch=0.0, within=0.6, lean=0.5)
"""Guard of the stages on all limbs: the trunk stays within 34 deg of level."""
BETWEEN = Window(pitch=-0.6, within=1.2, lean=0.5)
"""Of rearing up and coming down on the hands."""
ON_FEET = Window(pitch=-1.2, within=1.0, lean=0.5)
"""Of rising and bowing: no nearer to level than 11 deg, no further back than 36 deg past upright.
A trunk that leaves it falls, and the motion hands over to the recovery."""

NUMBERS: dict[str, tuple[float, float, float]] = {
    "foot_x": (-0.21, -0.08, 0.02),
    "lift": (0.03, 0.08, 0.01),
    "shift_x": (0.0, 0.06, 0.01),
    "shift_y": (0.0, 0.05, 0.01),
    "hand_x": (0.08, 0.26, 0.03),
    "rear_deg": (25.0, 65.0, 5.0),
    "hip_height": (0.24, 0.33, 0.015),
    "hip_x": (-0.17, -0.03, 0.02),
    "bow_x": (-0.06, 0.06, 0.02),
    "bow_z": (-0.05, 0.05, 0.02),
    "end_x": (-0.09, 0.0, 0.01),
    "k_p": (0.0, 1.5, 0.2),
    "k_d": (0.0, 0.3, 0.05),
    "rear_s": (0.6, 1.6, 0.2),
    "rise_s": (0.6, 1.8, 0.2),
    "arms": (1.0, 4.0, 0.3),
}
"""Name -> (lowest, highest, first spread) of what the search may choose: where the feet go, how
high they step, how far the trunk shifts beforehand, where the hands end, how far it rears, where
the hips are over the feet then [m], how the hips' way bows while it rises, where they end, gains
of the ankles on the trunk's pitch, times [s], and how early the arms are tucked (share of the
rise is 1/arms)."""


def _both(place: Array) -> tuple[Array, Array]:
    return place, place * MIRROR


class _Way:
    """The places and poses that the stages share."""

    def __init__(self, n: Numbers) -> None:
        self.n = n
        self.hands, self.feet = _both(HAND), _both(FOOT)
        self.under = _both(np.array([n["foot_x"], FOOT_Y, 0.0]))
        self.rear_angle = float(np.radians(n["rear_deg"]))
        self.stand = keyframe_joints("stand")

    def shifted(self, u: float) -> Array:
        """Trunk forward and to the right, so that the left foot is free."""
        p = np.array([self.n["shift_x"] * u, -self.n["shift_y"] * u, HEIGHT])
        return body_joints(np.eye(3), p, hands_M=self.hands, feet_M=self.feet)

    def left_steps(self, u: float) -> Array:
        """The left foot goes under its hip."""
        feet = (self._step(self.feet[0], self.under[0], u), self.feet[1])
        p = np.array([self.n["shift_x"], -self.n["shift_y"], HEIGHT])
        return body_joints(np.eye(3), p, hands_M=self.hands, feet_M=feet)

    def shifted_over(self, u: float) -> Array:
        """Trunk from the right to the left."""
        p = np.array([self.n["shift_x"], self.n["shift_y"] * (2.0 * u - 1.0), HEIGHT])
        feet = (self.under[0], self.feet[1])
        return body_joints(np.eye(3), p, hands_M=self.hands, feet_M=feet)

    def right_steps(self, u: float) -> Array:
        """The right foot goes under its hip."""
        feet = (self.under[0], self._step(self.feet[1], self.under[1], u))
        p = np.array([self.n["shift_x"], self.n["shift_y"], HEIGHT])
        return body_joints(np.eye(3), p, hands_M=self.hands, feet_M=feet)

    def _step(self, a: Array, b: Array, u: float) -> Array:
        return a + (b - a) * u + np.array([0.0, 0.0, 4.0 * self.n["lift"] * u * (1.0 - u)])

    def reared(self, u: float) -> Array:
        """The trunk rears about the feet while the hands follow along the floor."""
        n, angle = self.n, self.rear_angle
        end = self._trunk(angle, n["hip_x"], n["hip_height"])
        begin = np.array([n["shift_x"], n["shift_y"], HEIGHT])
        hand = HAND + np.array([(n["hand_x"] - HAND[0]) * u, 0.0, 0.0])
        p = begin + (end - begin) * u
        return body_joints(nose_up(angle * u), p, hands_M=_both(hand), feet_M=self.under)

    def risen(self, u: float) -> Array:
        """Upright over the feet, arms tucked."""
        n = self.n
        angle = self.rear_angle + (0.5 * np.pi - self.rear_angle) * u
        bow = 4.0 * u * (1.0 - u)
        hip_z = n["hip_height"] + (STAND_HEIGHT - HIP_X - n["hip_height"]) * u + n["bow_z"] * bow
        hip_x = n["hip_x"] + (n["end_x"] - n["hip_x"]) * u + n["bow_x"] * bow
        share = min(1.0, u * n["arms"])
        q = body_joints(nose_up(angle), self._trunk(angle, hip_x, hip_z), feet_M=self.under)
        q[:12] = (1.0 - share) * self.reared(1.0)[:12] + share * self.stand[1][:12]
        return q

    def _trunk(self, angle: float, hip_x: float, hip_z: float) -> Array:
        """Trunk (3,) [m] whose hips are ``hip_x`` from the feet and ``hip_z`` high."""
        x = self.n["foot_x"] + hip_x + HIP_X * np.cos(angle)
        return np.array([x, 0.0, hip_z + HIP_X * np.sin(angle)])

    def ankles(self) -> tuple[Feedback, ...]:
        """Toes down as the trunk tips forward."""
        names = ("left_ankle_pitch", "right_ankle_pitch")
        return tuple(Feedback(j, self.n["k_p"], self.n["k_d"], UPRIGHT) for j in names)


def along(poses: Array, seconds: float, **more: object) -> Stage:
    """A stage over poses (k, 22) to the last of them."""
    return Stage(poses[-1], seconds, through=poses[:-1], **more)  # type: ignore[arg-type]


def _pitches(begin: float, end: float, count: int) -> tuple[float, ...]:
    return tuple(float(v) for v in np.linspace(begin, end, count + 1))


def feet_under(n: Numbers) -> tuple[Stage, ...]:
    """Crawl stance to a crouch with both feet under the hips."""
    way = _Way(n)
    return (
        along(sampled(way.shifted, 4), 0.4, window=ON_FOUR),
        along(sampled(way.left_steps, 6), 0.5, window=ON_FOUR),
        along(sampled(way.shifted_over, 4), 0.4, window=ON_FOUR),
        along(sampled(way.right_steps, 6), 0.5, window=ON_FOUR),
    )


def rear_up(n: Numbers) -> Stage:
    """The crouch to a rear from which it can fall neither forward nor back."""
    return along(sampled(_Way(n).reared, 8), n["rear_s"], window=BETWEEN)


def rise(n: Numbers) -> tuple[Stage, ...]:
    """The rear to the stand, ankles on the trunk's pitch."""
    way = _Way(n)
    pitch = _pitches(-way.rear_angle, UPRIGHT, 8)
    more: dict[str, Any] = {"feedback": way.ankles(), "window": ON_FEET}
    up = along(sampled(way.risen, 8), n["rise_s"], pitch=pitch, **more)
    return up, Stage(way.stand[1], 0.3, hold=0.1, **more)


def crawl_to_stand(n: Numbers) -> Motion:
    """Fig. 13 D."""
    stages = (*feet_under(n), rear_up(n), *rise(n))
    return Motion("crawl_to_stand", Posture.CRAWLING, Posture.STANDING, stages)


def stand_to_crawl(n: Numbers) -> Motion:
    """Fig. 13 B: the same way back, hands first."""
    way = _Way(n)

    def back(path: Callable[[float], Array], count: int) -> Array:
        poses = [path(1.0 - k / count) for k in range(1, count + 1)]
        return within_limits(np.stack(poses))

    pitch = _pitches(UPRIGHT, -way.rear_angle, 8)
    bow = along(
        np.vstack([back(way.risen, 8)[:-1], within_limits(way.reared(1.0))[None]]),
        1.2,
        feedback=way.ankles(),
        pitch=pitch,
        window=ON_FEET,
    )
    stages = (
        bow,
        along(back(way.reared, 8), 1.0, window=BETWEEN),
        along(back(way.right_steps, 6), 0.5, window=ON_FOUR),
        along(back(way.shifted_over, 4), 0.4, window=ON_FOUR),
        along(back(way.left_steps, 6), 0.5, window=ON_FOUR),
        Stage(keyframe_joints("crawl")[1], 0.4, hold=0.3, window=ON_FOUR),
    )
    return Motion("stand_to_crawl", Posture.STANDING, Posture.CRAWLING, stages)
