"""From a plan to body twists: pure pursuit along the plan's cells.

The robot moves in any direction, so position and heading are steered apart: the velocity
points at a spot a little ahead on the path, the heading turns towards the path, and while
the heading is far off the robot slows down and turns first. Where there is no room to turn,
it keeps its sides parallel to the grid and goes sideways if it must.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mobius.geometry import heading_yaw, wrap_angle
from mobius.types import Mode, ModeCommand, Plan, StateEstimate

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FollowerConfig:
    """Gains of the follower."""

    speed: float = 0.36
    """Cruising speed [m/s]."""
    turn_rate: float = 0.55
    """Largest yaw rate [rad/s]."""
    lookahead: float = 0.28
    """Distance ahead on the path that is aimed at [m]."""
    heading_lookahead: float = 0.60
    """Distance ahead that the heading turns to [m]."""
    heading_gain: float = 1.6
    """Yaw rate per heading error [1/s]."""
    position_gain: float = 1.2
    """Speed per distance near the goal [1/s]."""
    acceleration: float = 0.6
    """Largest change of the commanded velocity [m/s^2]."""
    tolerance: float = 0.08
    """Distance to the goal that counts as there [m]."""
    turn_room: float = 0.48
    """Distance to obstacles that turning on the spot needs [m]: corner radius and a margin."""
    narrow_speed: float = 0.22
    """Speed where there is less room than that [m/s]."""
    sideways: float = np.inf
    """Largest speed to a side [m/s]."""


CRAWLING = FollowerConfig()
WALKING = FollowerConfig(
    speed=0.20,
    turn_rate=0.40,
    lookahead=0.25,
    heading_lookahead=0.50,
    heading_gain=1.2,
    position_gain=0.8,
    acceleration=0.3,
    tolerance=0.12,
    turn_room=0.0,
    narrow_speed=0.20,
    sideways=0.12,
)
"""On two legs: what is asked stays within 0.25 m/s forward, 0.15 m/s sideways and 0.5 rad/s."""


class PathFollower:
    """Follows one plan from the belief alone; the path is in the frame of the belief."""

    def __init__(
        self,
        plan: Plan,
        config: FollowerConfig | None = None,
        *,
        room: Callable[[Array], float] | None = None,
        grid_yaw: float = 0.0,
    ) -> None:
        """Args: the plan; gains; ``room`` gives the distance to obstacles [m] at (2,) [m],
        open ground everywhere if not given; ``grid_yaw`` [rad] of the grid's x axis.
        """
        self.config = config or FollowerConfig()
        self._room, self._grid_yaw = room, grid_yaw
        steps = np.linalg.norm(np.diff(plan.xy_M, axis=0), axis=1)
        keep = [0, *(1 + np.flatnonzero(steps > 1e-9))]
        self._xy = plan.xy_M[keep]
        self._modes = [plan.modes[max(i - 1, 0)] for i in keep] if plan.modes else [Mode.CRAWL]
        steps = np.linalg.norm(np.diff(self._xy, axis=0), axis=1)
        self._s: list[float] = [0.0, *np.cumsum(steps).tolist()]
        self._progress = 0.0
        self._twist = np.zeros(3)
        self.arrived = False

    @property
    def length(self) -> float:
        """Length of the path [m]."""
        return self._s[-1]

    @property
    def progress(self) -> float:
        """Distance along the path of the robot's projection [m]."""
        return self._progress

    @property
    def twist(self) -> Array:
        """(3,) commanded last [m/s, rad/s]."""
        return self._twist.copy()

    def go_on(self, twist: Array) -> None:
        """Begin from a twist (3,) [m/s, rad/s] that another follower was commanding."""
        self._twist = np.array(twist, dtype=float)

    def halt(self) -> None:
        """Begin again from standing, as after something else has moved the robot."""
        self._twist = np.zeros(3)

    def point(self, s: float) -> Array:
        """(2,) path point at distance s [m]."""
        s = min(max(s, 0.0), self._s[-1])
        i = min(max(int(np.searchsorted(self._s, s)) - 1, 0), max(len(self._s) - 2, 0))
        if i + 1 >= len(self._s):
            return self._xy[-1].copy()
        share = (s - self._s[i]) / (self._s[i + 1] - self._s[i])
        return self._xy[i] + share * (self._xy[i + 1] - self._xy[i])

    def cross_track(self, p: Array) -> float:
        """Distance [m] of p (2,) to the path near the current progress."""
        return float(np.linalg.norm(p - self.point(self._project(p))))

    def _project(self, p: Array) -> float:
        """Distance along the path nearest to p, looking 0.3 m back and 1 m ahead."""
        low, high = max(self._progress - 0.3, 0.0), min(self._progress + 1.0, self._s[-1])
        best, nearest = self._progress, np.inf
        first = max(int(np.searchsorted(self._s, low)) - 1, 0)
        for i in range(first, len(self._s) - 1):
            if self._s[i] > high:
                break
            step = self._xy[i + 1] - self._xy[i]
            length = self._s[i + 1] - self._s[i]
            along = min(max(float((p - self._xy[i]) @ step) / length, 0.0), length)
            s = min(max(self._s[i] + along, low), high)
            gap = self._xy[i] + (s - self._s[i]) / length * step - p
            distance = float(gap @ gap)
            if distance < nearest:
                best, nearest = s, distance
        return best

    def mode(self) -> Mode:
        """The plan's mode where the robot is."""
        i = int(np.searchsorted(self._s, self._progress, side="right"))
        return self._modes[min(i, len(self._modes) - 1)]

    def command(self, belief: StateEstimate, dt: float) -> ModeCommand:
        """The twist to send now; ``dt`` [s] since the last call."""
        cfg, p = self.config, belief.p_OB[:2]
        mode = self.mode()
        yaw = float(heading_yaw("biped" if mode is Mode.BIPED else "crawl", belief.q_OB))
        self._progress = max(self._progress, self._project(p))
        goal = float(np.linalg.norm(self._xy[-1] - p))
        near_end = self._s[-1] - self._progress < cfg.lookahead
        if near_end and goal < cfg.tolerance:
            self.arrived = True
        ahead = self.point(self._progress + cfg.lookahead) - p
        wanted = self._towards(ahead, goal, near_end)
        narrow = self._is_narrow(p)
        if narrow:
            wanted *= min(1.0, cfg.narrow_speed / cfg.speed)
        error = self._heading_error(p, yaw, narrow)
        wanted *= max(np.cos(min(abs(error), np.pi / 2)), 0.15)
        c, s = np.cos(yaw), np.sin(yaw)
        twist = np.array(
            [
                c * wanted[0] + s * wanted[1],
                -s * wanted[0] + c * wanted[1],
                np.clip(cfg.heading_gain * error, -cfg.turn_rate, cfg.turn_rate),
            ]
        )
        twist[:2] *= min(1.0, cfg.sideways / max(abs(twist[1]), 1e-9))
        if self.arrived:
            twist[:] = 0.0
        step = np.array([cfg.acceleration, cfg.acceleration, 3.0 * cfg.acceleration]) * dt
        self._twist += np.clip(twist - self._twist, -step, step)
        return ModeCommand(mode=mode, twist_H=self._twist, stamp=belief.stamp)

    def _is_narrow(self, p: Array) -> bool:
        """Whether here or a stride ahead there is no room to turn."""
        if self._room is None:
            return False
        ahead = self.point(self._progress + 0.35)
        return min(self._room(p), self._room(ahead)) < self.config.turn_room

    def _heading_error(self, p: Array, yaw: float, narrow: bool) -> float:
        """Angle to turn [rad]: along the path, or to the nearest grid axis."""
        if narrow:
            quarter = 0.5 * np.pi
            turns = round((yaw - self._grid_yaw) / quarter)
            return float(wrap_angle(self._grid_yaw + turns * quarter - yaw))
        far = self.point(self._progress + self.config.heading_lookahead) - p
        if np.linalg.norm(far) < 0.15:
            return 0.0
        return float(wrap_angle(np.arctan2(far[1], far[0]) - yaw))

    def _towards(self, ahead: Array, goal: float, near_end: bool) -> Array:
        """World velocity (2,) [m/s] at the point ahead, slower near the goal."""
        distance = float(np.linalg.norm(ahead))
        if distance < 1e-6:
            return np.zeros(2)
        speed = self.config.speed
        if near_end:
            speed = min(speed, max(self.config.position_gain * goal, 0.08))
        return ahead / distance * speed
