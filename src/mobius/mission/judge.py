"""Falls, recoveries and velocities of a run in several bodies, by the truth."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mobius.control.bodies import BODIES, Body
from mobius.control.observation import heading_twist
from mobius.geometry import quat_conj, rotate
from mobius.mission.floor import Heights
from mobius.robot import TICK
from mobius.stack import FRAME_EVERY, Judge, Sample
from mobius.types import Mode, StateEstimate

Array = NDArray[np.float64]

LOST_S = 40.0
"""A robot that lies for so long is lost [s]."""
UPRIGHT = 0.6
"""Least share of the vertical along the trunk's axis that points up."""
_UP = np.array([0.0, 0.0, 1.0])
_BODY: dict[str, Body] = {body.mode.value: body for body in BODIES.values()}


class MissionJudge(Judge):
    """A judge that knows which body the robot is in, and that it may get up again.

    While crawling or on two legs the robot is down by the same rules as ever: trunk low,
    steep, or on the ground. In RECOVER it is down, too; motions between bodies and rolls are
    not judged. It is up again once it crawls or walks and is not down.
    """

    def __init__(self, robot: Any, *, recovers: bool, ground: Heights | None = None) -> None:
        """Args: a SimRobot; whether a fall may be recovered from, else it ends the run; height of
        the floor [m], which the trunk's is counted from, 0 if not given.
        """
        super().__init__(robot, ground=ground)
        self.recovers = recovers
        self.falls: list[float] = []
        """When it fell [s]."""
        self.recoveries: list[float] = []
        """When it was up again [s]."""
        self.mocap: list[Array] = []
        """(k, 7) poses of the scene's movable obstacles, one per video frame."""

    @property
    def down(self) -> bool:
        """Whether it lies now."""
        return len(self.falls) > len(self.recoveries)

    def see(self, sample: Sample) -> StateEstimate:
        """Judge one sample; returns the truth."""
        truth = super().see(sample)
        self.fallen = False
        down, now = self._is_down(sample.command.mode, truth), sample.tick * TICK
        if down is True and not self.down:
            self.falls.append(now)
        elif down is False and self.down:
            self.recoveries.append(now)
        if self.down:
            self.fallen = not self.recovers or now - self.falls[-1] > LOST_S
        if sample.tick % FRAME_EVERY == 0:
            data = self.robot.data
            self.mocap.append(np.hstack([data.mocap_pos, data.mocap_quat]))
        return truth

    def _is_down(self, mode: Mode, truth: StateEstimate) -> bool | None:
        """Whether it lies; None where that cannot be said."""
        if mode is Mode.RECOVER:
            return True
        body = _BODY.get(mode.value)
        if body is None:
            return None
        up = float(rotate(quat_conj(truth.q_OB), _UP)[2 if body.heading == "crawl" else 0])
        floor = 0.0 if self.ground is None else float(self.ground(truth.p_OB[:2]))
        low = truth.p_OB[2] - floor < body.fallen_below
        return bool(low or up < UPRIGHT or self.robot.trunk_grounded())

    def _twists(self, states: list[StateEstimate]) -> Array:
        """(n, 3) in the heading frame of the body of each sample; the crawl's between them."""
        biped = np.array([s.command.mode is Mode.BIPED for s in self.samples])
        crawl = super()._twists(states)
        if not biped.any():
            return crawl
        q, v, w = (np.stack([getattr(x, k) for x in states]) for k in ("q_OB", "v_B", "w_B"))
        v_H, w_H = heading_twist(BODIES["biped"], q, v, w)
        return np.where(biped[:, None], np.column_stack([v_H[:, :2], w_H[:, 2]]), crawl)
