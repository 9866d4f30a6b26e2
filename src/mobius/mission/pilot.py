"""The robot's own part of a mission: follow the plan, and plan again when that is due."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mobius.errors import MapError, MobiusError
from mobius.mission.prepare import plan_mission, room_of, with_ends
from mobius.modes import FollowerConfig, ModalFollower
from mobius.modes.modal import GAINS
from mobius.plan import NoPlan
from mobius.types import Mode, ModeCommand, Plan, StateEstimate
from mobius.world import World

Array = NDArray[np.float64]

SETTLE_S = 1.5
"""The robot stands this long before it sets out [s]: at rest the estimator finds the gyro's
bias."""
OFF_PLAN = 0.5
"""A robot this far from its leg plans anew [m]."""
OFF_PLAN_S = 0.5
"""If it is so for this long [s]."""
AGAIN_S = 3.0
"""And not sooner than this after the last plan [s]; a changed map is not waited for."""
DEADLINE_S = 0.5
"""Of a search on the way [s]."""
FOOTHOLD = 1.2
"""A robot whose cell is no place to plan from sets out from one at most this far away [m]."""
FOOTHOLDS = 6
"""So many of them are tried."""
BODIES = (Mode.CRAWL, Mode.BIPED)


@dataclass(frozen=True, eq=False)
class Replan:
    """One plan made on the way."""

    t: float
    """[s]."""
    why: str
    """``map``, ``fall``, ``motion`` or ``off plan``."""
    plan: Plan | None
    """With its ends; None where there was no way."""
    problem: str = ""
    """Why there was none."""


Planning = Callable[..., Plan]
"""Called as :func:`mobius.mission.prepare.plan_mission`."""


class Pilot:
    """Source of commands: sees the belief and the mode the robot is in, never the truth."""

    def __init__(
        self,
        world: World,
        plan: Plan,
        modes: Sequence[Mode],
        *,
        config: FollowerConfig | None = None,
        planning: Planning = plan_mission,
    ) -> None:
        """Set out on a plan.

        Args:
            world: As the robot knows it.
            plan: Over the world's cells.
            modes: That it may use.
            config: Of the crawling follower.
            planning: Makes the plans on the way.
        """
        self.world, self.modes = world, tuple(modes)
        self._gains = dict(GAINS) if config is None else {**GAINS, Mode.CRAWL: config}
        self._planning = planning
        self.follower = self._follow(with_ends(plan, world.grid))
        self.replans: list[Replan] = []
        self.stuck = False
        """Whether there is no way from here; a changed map may give one."""
        self._due: str | None = None
        self._off_since: float | None = None
        self._last_plan = 0.0
        self._failures, self._fell = 0, False
        self._rolls = self._refused = self._failed = 0

    @property
    def arrived(self) -> bool:
        """Whether the robot believes that it is at the goal, in a body that stands."""
        return self.follower.arrived and not self.stuck and self._due is None

    @property
    def rolls(self) -> int:
        """Rolls carried out."""
        return self._rolls + self.follower.rolls

    @property
    def rolls_refused(self) -> int:
        """Rolls that there was no room for; they were crawled."""
        return self._refused + self.follower.rolls_refused

    @property
    def failures(self) -> int:
        """Changes of body and rolls that did not come about."""
        return self._failed + self.follower.failures

    def know(self, world: World) -> None:
        """The map has changed."""
        self.world, self._due = world, "map"

    def command(self, belief: StateEstimate, dt: float, actual: Mode) -> ModeCommand:
        """The command to send now, ``dt`` [s] after the last one."""
        body = actual if actual in BODIES else self.follower.mode()
        if belief.stamp < SETTLE_S:
            return ModeCommand(mode=body, twist_H=np.zeros(3), stamp=belief.stamp)
        self._watch(belief, actual)
        if self._due is not None and actual in BODIES:
            self._replan(belief, actual)
        if self.stuck:
            return ModeCommand(mode=body, twist_H=np.zeros(3), stamp=belief.stamp)
        return self.follower.command(belief, dt, actual)

    # -- planning again -------------------------------------------------------------------

    def _watch(self, belief: StateEstimate, actual: Mode) -> None:
        """Notice what makes the plan useless."""
        if actual is Mode.RECOVER:
            self._fell = True
        elif self._fell and actual in BODIES:
            self._fell = False
            self._due = self._due or "fall"
        if self.follower.failures > self._failures:
            self._failures = self.follower.failures
            self._due = self._due or "motion"
        off = actual in BODIES and self.follower.off_plan(belief.p_OB[:2]) > OFF_PLAN
        if not off or self.follower.arrived:
            self._off_since = None
        elif self._off_since is None:
            self._off_since = belief.stamp
        elif (
            belief.stamp - self._off_since > OFF_PLAN_S
            and belief.stamp - self._last_plan > AGAIN_S
            and not self.stuck
        ):
            self._due = self._due or "off plan"

    def _replan(self, belief: StateEstimate, actual: Mode) -> None:
        """Plan from where the robot believes to be, in the body it is in."""
        why, self._due = str(self._due), None
        self._off_since, self._last_plan = None, belief.stamp
        try:
            plan = self._plan_from(belief.p_OB[:2], actual)
        except MobiusError as error:
            self.replans.append(Replan(belief.stamp, why, None, str(error)))
            self.stuck = True
            return
        self.replans.append(Replan(belief.stamp, why, plan))
        self.stuck, self._failures = False, 0
        old = self.follower
        self._rolls, self._refused = self._rolls + old.rolls, self._refused + old.rolls_refused
        self._failed += old.failures
        self.follower = self._follow(plan)

    def _plan_from(self, xy: Array, actual: Mode) -> Plan:
        """A plan from the robot's cell, or from the nearest one that there is a way from."""
        problem: MobiusError = MapError("no free cell is near the robot")
        for start in self._footholds(xy):
            try:
                plan = self._planning(
                    self.world, self.modes, start=start, last_mode=actual, deadline_s=DEADLINE_S
                )
            except (NoPlan, MapError) as error:
                problem = error
                continue
            return with_ends(plan, self.world.grid, start=xy, body=actual)
        raise problem

    def _footholds(self, xy: Array) -> list[Array]:
        """Points (2,) [m] to plan from, the nearest first: the robot's own if its cell is free."""
        grid = self.world.grid
        cell = tuple(grid.cell_of(xy))
        if grid.holds(cell) and not grid.blocked[cell]:
            return [xy]
        centers = grid.center_of(np.argwhere(~grid.blocked))
        far = np.linalg.norm(centers - xy, axis=1)
        order = [k for k in np.argsort(far)[:FOOTHOLDS] if far[k] <= FOOTHOLD]
        return [centers[k] for k in order]

    def _follow(self, plan: Plan) -> ModalFollower:
        return ModalFollower(
            plan,
            self._gains,
            room=room_of(self.world),
            grid_yaw=float(self.world.grid.origin_M[2]),
        )
