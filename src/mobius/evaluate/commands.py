"""What an evaluation asks a robot to do: named commands, drawn by seed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mobius.control.bodies import body_of

Array = NDArray[np.float64]

AXES = ("vx", "vy", "wz")
"""Components of a command [m/s, m/s, rad/s]."""
FULL: dict[str, tuple[int, int]] = {
    "forward": (0, 1),
    "backward": (0, -1),
    "left": (1, 1),
    "right": (1, -1),
    "turn_left": (2, 1),
    "turn_right": (2, -1),
}
"""Commands at the end of the body's range: which component, which sign."""
NAMED = (*FULL, "mixed", "stand")
"""All commands; ``mixed`` is uniform over the body's range, ``stand`` is zero."""
STRAIGHT = ("forward", "backward", "left", "right")
"""Commands that go straight on; slip is measured over these."""


@dataclass(frozen=True)
class Segment:
    """One command that is held for a while."""

    name: str
    twist: tuple[float, float, float]
    """vx, vy [m/s], wz [rad/s] in the heading frame."""


def segment_of(name: str, body: str, rng: np.random.Generator, *, speed: float = 1.0) -> Segment:
    """The command called ``name`` for a body, ``speed`` times as fast as its range allows."""
    low, high = np.array(body_of(body).command_low), np.array(body_of(body).command_high)
    twist = np.zeros(3)
    if name == "mixed":
        twist = rng.uniform(low, high)
    elif name in FULL:
        axis, sign = FULL[name]
        twist[axis] = high[axis] if sign > 0 else low[axis]
    vx, vy, wz = (float(v) for v in speed * twist)
    return Segment(name, (vx, vy, wz))


def schedule(
    body: str,
    seed: int,
    *,
    count: int = 5,
    names: tuple[str, ...] = NAMED,
    speed: float = 1.0,
) -> list[Segment]:
    """``count`` commands of an episode, drawn from ``names`` without replacement."""
    rng = np.random.default_rng([seed, 77])
    order = rng.permutation(len(names))[:count]
    return [segment_of(names[i], body, rng, speed=speed) for i in order]


def moving(body: str, rng: np.random.Generator, *, share: float = 0.6) -> Segment:
    """A random command on the surface of ``share`` of the body's range: at least one component
    is at that share of its limit, so that the robot is certainly asked to move.
    """
    low, high = np.array(body_of(body).command_low), np.array(body_of(body).command_high)
    u = rng.uniform(-1.0, 1.0, 3)
    u /= np.abs(u).max()
    vx, vy, wz = (float(v) for v in share * np.where(u > 0, u * high, -u * low))
    return Segment("moving", (vx, vy, wz))
