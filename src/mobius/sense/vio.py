"""A T265-like camera that says where the trunk is, 200 times a second, and drifts.

It dead-reckons in a frame V of its own that starts on O: each true step is scaled, turned
by a heading error that grows, and joined by a random walk, all in proportion to the way
travelled, so that a robot at rest does not drift away. What it says is late, its attitude
carries a slow noise, sometimes it says nothing for a while, and it comes back elsewhere.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, replace
from math import cos, exp, sin, sqrt
from typing import Self

import numpy as np

from mobius.types import Pose

Quaternion = tuple[float, float, float, float]
Point = tuple[float, float, float]


@dataclass(frozen=True)
class VioParameters:
    """One camera."""

    latency: float = 0.0075
    """Age of a pose when it arrives [s]."""
    drift: float = 0.01
    """Random walk of the position per axis: spread after one metre [m]; grows as its root."""
    scale: float = 0.0
    """Steps are reported longer by this, relative."""
    yaw_drift: float = 0.0017
    """Random walk of the heading: spread after one metre [rad]; grows as its root."""
    yaw_rate: float = 0.0
    """Heading error gained per second [rad/s]."""
    position: float = 0.001
    """White noise of the position per axis [m]."""
    orientation: float = float(np.radians(0.5))
    """Slow noise of the attitude per axis, rms [rad]."""
    orientation_time: float = 0.5
    """Correlation time of that noise [s]."""
    dropout_rate: float = 0.1
    """Drop-outs per second of tracking [1/s]."""
    dropout_time: tuple[float, float] = (0.1, 0.5)
    """Shortest and longest drop-out [s]."""
    jump: float = 0.02
    """Spread of the jump after a drop-out per axis [m]."""
    yaw_jump: float = 0.005
    """And of the heading [rad]."""

    @classmethod
    def draw(cls, rng: np.random.Generator) -> Self:
        """A camera as it might come: latency 5-10 ms, its own scale and heading drift."""
        return cls(
            latency=float(rng.uniform(0.005, 0.010)),
            drift=float(rng.uniform(0.007, 0.013)),
            scale=float(rng.normal(0.0, 0.004)),
            yaw_drift=float(rng.uniform(0.001, 0.0025)),
            yaw_rate=float(rng.normal(0.0, 1e-4)),
            dropout_rate=float(rng.uniform(0.05, 0.15)),
        )

    def scaled(self, factor: float) -> Self:
        """The same camera with ``factor`` times its drifts, noise and jumps."""
        noisy = ("drift", "scale", "yaw_drift", "yaw_rate", "position", "orientation")
        names = (*noisy, "jump", "yaw_jump")
        return replace(self, **{name: factor * getattr(self, name) for name in names})


class VioModel:
    """Turns true trunk poses into what the camera says."""

    def __init__(self, parameters: VioParameters, rng: np.random.Generator) -> None:
        self.parameters, self._rng = parameters, rng
        self.blind = False
        """Nothing to be seen, as while rolling; the camera comes back with a jump."""
        self.yaw_error = 0.0
        """Heading of V's axes in O, as it has drifted [rad]."""
        self._true: Point | None = None
        self._place: Point = (0.0, 0.0, 0.0)
        self._turn: Point = (0.0, 0.0, 0.0)
        self._stamp, self._silent_until, self._lost = 0.0, -np.inf, False
        self._track: deque[tuple[float, Point, Quaternion]] = deque(maxlen=8)

    def corrupt(self, pose: Pose, stamp: float) -> Pose | None:
        """What the camera says at ``stamp`` [s] while the trunk is at ``pose``, if anything."""
        c = self.parameters
        x, y, z = pose.p.tolist()
        draw = self._rng.standard_normal(10).tolist()
        if self._true is None:
            self._true = self._place = (x, y, z)
            self._turn = (c.orientation * draw[7], c.orientation * draw[8], c.orientation * draw[9])
            self._stamp = stamp
        self._advance((x, y, z), self._true, stamp, draw)
        if self._is_silent(stamp):
            self._lost = True
            self._track.clear()
            return None
        if self._lost:
            self._jump()
            self._lost = False
        half = 0.5 * self.yaw_error
        yawed = _product((cos(half), 0.0, 0.0, sin(half)), pose.q.tolist())
        self._track.append((stamp, self._place, yawed))
        (x, y, z), late = self._at(stamp - c.latency)
        a, b, d = self._turn
        qw, qx, qy, qz = _product(late, (1.0, 0.5 * a, 0.5 * b, 0.5 * d))
        unit = 1.0 / sqrt(qw * qw + qx * qx + qy * qy + qz * qz)
        k = c.position
        return Pose(
            p=np.array([x + k * draw[4], y + k * draw[5], z + k * draw[6]]),
            q=np.array([unit * qw, unit * qx, unit * qy, unit * qz]),
        )

    def _advance(self, true: Point, last: Point, stamp: float, draw: list[float]) -> None:
        """One step of the camera's dead reckoning and of its attitude noise."""
        c, dt = self.parameters, stamp - self._stamp
        dx, dy, dz = true[0] - last[0], true[1] - last[1], true[2] - last[2]
        root = sqrt(sqrt(dx * dx + dy * dy + dz * dz))  # of the way
        self.yaw_error += c.yaw_rate * dt + c.yaw_drift * root * draw[3]
        cy, sy, k, walk = cos(self.yaw_error), sin(self.yaw_error), 1.0 + c.scale, c.drift * root
        x, y, z = self._place
        self._place = (
            x + k * (cy * dx - sy * dy) + walk * draw[0],
            y + k * (sy * dx + cy * dy) + walk * draw[1],
            z + k * dz + walk * draw[2],
        )
        keep = exp(-dt / c.orientation_time)
        fresh = c.orientation * sqrt(1.0 - keep * keep)
        a, b, d = self._turn
        self._turn = (
            keep * a + fresh * draw[7],
            keep * b + fresh * draw[8],
            keep * d + fresh * draw[9],
        )
        self._true, self._stamp = true, stamp
        if stamp >= self._silent_until and self._rng.random() < c.dropout_rate * dt:
            self._silent_until = stamp + self._rng.uniform(*c.dropout_time)

    def _is_silent(self, stamp: float) -> bool:
        return self.blind or stamp < self._silent_until

    def _jump(self) -> None:
        c = self.parameters
        dx, dy, dz, turn = self._rng.standard_normal(4).tolist()
        x, y, z = self._place
        self._place = (x + c.jump * dx, y + c.jump * dy, z + c.jump * dz)
        self.yaw_error += c.yaw_jump * turn

    def _at(self, stamp: float) -> tuple[Point, Quaternion]:
        """The track at a time past, linear between its points; its oldest point before that."""
        after = self._track[-1]
        for before in reversed(self._track):
            if before[0] <= stamp:
                span = after[0] - before[0]
                if span <= 0.0:
                    return before[1:]
                k = (stamp - before[0]) / span
                (x, y, z), (w, a, b, c) = before[1:]
                (x1, y1, z1), (w1, a1, b1, c1) = after[1:]
                return (x + k * (x1 - x), y + k * (y1 - y), z + k * (z1 - z)), (
                    w + k * (w1 - w),
                    a + k * (a1 - a),
                    b + k * (b1 - b),
                    c + k * (c1 - c),
                )
            after = before
        return after[1:]


def _product(a: Quaternion, b: Quaternion) -> Quaternion:
    """Hamilton product of two wxyz quaternions, in floats."""
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )
