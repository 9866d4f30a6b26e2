"""A gait clock: a phase that runs while a robot is asked to move.

Ours, not the paper's (which forbids motion priors); the ``fast`` preset uses it because a
policy that sees a clock steps regularly from early on.
In the crawl diagonal limbs share a phase (trot), the other pair is half a period behind.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Gait:
    """When each foot of a body is in the air."""

    period: float
    """Of one slow stride [s]."""
    offsets: tuple[float, ...]
    """Phase of each foot ahead of the clock, in strides."""
    swing: tuple[float, float]
    """Part of a foot's own phase in which it should be in the air."""
    height: float
    """Of the sole in the middle of a swing [m]."""
    lift: float = 0.6
    """Exponent that skews the swing: below 1 a foot leaves the ground faster than it lands."""
    slack: float = 0.0
    """Part of the phase before and after a swing in which the foot may do either."""
    quicken: float = 0.0
    """Strides are this much more frequent a unit of commanded speed [s/m]."""
    unrest: float = 0.0
    """Believed horizontal speed [m/s] from which the clock of a standing robot runs though the
    command is zero: it was pushed, and steps until a whole period was calm; 0 switches it off."""
    settled: float = 0.0
    """Believed horizontal speed [m/s] below which a stepping robot is calm; at least
    ``unrest``. It sways while it steps, which must not keep it stepping."""


MOVE_GATE = 0.05
"""A command whose norm (m/s and rad/s mixed) is below this means standing still."""


def is_moving(command: Array) -> NDArray[np.bool_]:
    """(n,) whether a command (n, 3) asks for motion."""
    return np.linalg.norm(command, axis=-1) > MOVE_GATE


class GaitClock:
    """Phases of n robots, in [0, 1)."""

    def __init__(self, gait: Gait, n: int = 1) -> None:
        self.gait = gait
        self._offsets = np.array(gait.offsets)
        self.phase = np.zeros(n)
        self.moving = np.zeros(n, dtype=bool)
        self.calm = np.full(n, np.inf)
        """(n,) time since the robot was last seen faster than ``gait.unrest`` [s]."""

    def reset(
        self, which: NDArray[np.bool_] | slice = slice(None), phase: Array | float = 0.0
    ) -> None:
        """Set the phase of these robots and call them calm."""
        self.phase[which] = phase
        self.calm[which] = np.inf

    def advance(self, command: Array, dt: float, speed: Array | float = 0.0) -> None:
        """Run on by ``dt`` [s] where the command (n, 3) asks for motion or the robot is shoved.

        Args:
            command: (n, 3) vx, vy [m/s], wz [rad/s].
            dt: [s].
            speed: (n,) believed horizontal speed of the trunk [m/s].
        """
        gate = np.where(self.moving, max(self.gait.settled, self.gait.unrest), self.gait.unrest)
        shoved = (self.gait.unrest > 0) & (np.asarray(speed) > gate)
        self.calm = np.where(shoved, 0.0, self.calm + dt)
        self.refresh(command)
        speed_asked = np.linalg.norm(command[..., :2], axis=-1)
        step = dt / self.gait.period * (1.0 + self.gait.quicken * speed_asked)
        self.phase = np.where(self.moving, (self.phase + step) % 1.0, self.phase)

    def refresh(self, command: Array) -> None:
        """See new commands (n, 3) without running on."""
        self.moving = is_moving(command) | (self.calm < self.gait.period)

    def observe(self) -> Array:
        """(n, 2) sine and cosine of the phase; zeros while standing still."""
        angle = 2 * np.pi * self.phase
        return np.stack([np.sin(angle), np.cos(angle)], axis=-1) * self.moving[:, None]

    def limb_phase(self) -> Array:
        """(n, feet) each foot's own phase in [0, 1)."""
        return (self.phase[:, None] + self._offsets) % 1.0

    def swing_wanted(self) -> Array:
        """(n, feet) how high a swinging foot should be, in parts of the top; 0 on the ground.

        It leaves the ground fast, so that it does not scrape, and lands softly.
        """
        phase = self.limb_phase()
        start, end = self.gait.swing
        inside = (phase > start) & (phase < end) & self.moving[:, None]
        part = np.clip((phase - start) / (end - start), 0.0, 1.0) ** self.gait.lift
        return np.where(inside, np.sin(np.pi * part) ** 2, 0.0)

    def contact_wanted(self) -> Array:
        """(n, feet) 1 where a foot should be on the ground, -1 in the air, 0 either.

        ``slack`` makes room at both ends of a swing; standing still all feet should be down.
        """
        start, end = self.gait.swing
        slack, phase = self.gait.slack, self.limb_phase()
        inside = (phase > start + slack) & (phase < end - slack)
        near = (phase - start + slack) % 1.0 <= end - start + 2 * slack
        wanted = np.where(inside, -1.0, np.where(near & (slack > 0), 0.0, 1.0))
        return np.where(self.moving[:, None], wanted, 1.0)
