"""The robot's own part of a mission: follow the plan, and plan again when that is due."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mobius.errors import MapError, MobiusError
from mobius.mission.prepare import plan_mission, room_of, with_ends
from mobius.mission.prices import NO_PRICES, Prices
from mobius.modes import FollowerConfig, ModalFollower
from mobius.modes.modal import GAINS
from mobius.plan import NoPlan
from mobius.types import Mode, ModeCommand, Plan, StateEstimate
from mobius.world import World
from mobius.world.load import blocked_pixels

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
AGAIN = 3
"""A robot that found no way looks so often for one again; a map without a way stays so."""
FOOTHOLD = 1.2
"""A robot whose cell is no place to plan from sets out from one at most this far away [m]."""
FOOTHOLDS = 6
"""So many of them are tried."""
NEAR = 0.5
"""Motions that failed within this distance of each other [m] failed in the same place."""
GIVE_UP = 2
"""After so many failures there the plan makes that motion elsewhere, if it can."""
GIVE_UP_AT_LAST = 4
"""After so many, it makes it there no more even where there is no other way."""
BODIES = (Mode.CRAWL, Mode.BIPED)


@dataclass(frozen=True, eq=False)
class Replan:
    """One plan made on the way."""

    t: float
    """[s]."""
    why: str
    """``map``, ``fall``, ``motion``, ``off plan``, or ``again`` where there was no way."""
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
        prices: Prices = NO_PRICES,
    ) -> None:
        """Set out on a plan.

        Args:
            world: As the robot knows it.
            plan: Over the world's cells.
            modes: That it may use.
            config: Of the crawling follower.
            planning: Makes the plans on the way.
            prices: Of these plans.
        """
        self.world, self.modes = world, tuple(modes)
        self._gains = dict(GAINS) if config is None else {**GAINS, Mode.CRAWL: config}
        self._planning, self._prices = planning, prices
        self._room, self._solid = room_of(world), _solid(world)
        self.follower, self._planned = self._follow(with_ends(plan, world.grid)), len(plan.modes)
        self.replans: list[Replan] = []
        self.stuck = False
        """Whether there is no way from here; a changed map may give one."""
        self._due: str | None = None
        self._off_since: float | None = None
        self._last_plan = 0.0
        self._failures, self._fell = 0, False
        self._failed_at: list[tuple[Mode, Array]] = []
        self._tries = 0
        self._rolls = self._refused = self._failed = 0
        self._steps = 0.0
        self._was: Mode | None = None
        self.switches = 0
        """Changes between biped, crawl and roll, as plans count them: between the rolls of one
        stretch, where the robot crawls for a moment, there is none."""

    @property
    def arrived(self) -> bool:
        """Whether the robot believes that it is at the goal, in a body that stands."""
        return self.follower.arrived and not self.stuck and self._due is None

    @property
    def hopeless(self) -> bool:
        """Whether there is no way, and it looks for none until the map changes."""
        return self.stuck and not self._tries and self._due is None

    @property
    def steps(self) -> float:
        """Steps made so far of this plan and those before, as their shares of the way."""
        return self._steps + self._planned * self.follower.share

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
        self._room, self._solid = room_of(world), _solid(world)

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
        if actual is self.follower.leg_mode:
            self.switches += self._was not in (None, actual)
            self._was = actual
        return self.follower.command(belief, dt, actual)

    # -- planning again -------------------------------------------------------------------

    def _watch(self, belief: StateEstimate, actual: Mode) -> None:
        """Notice what makes the plan useless."""
        if self.follower.failures > self._failures:
            new = self.follower.failed[self._failures :]
            self._failed_at += [(mode, belief.p_OB[:2].copy()) for mode in new]
            self._failures = self.follower.failures
            self._due = self._due or "motion"
        if actual is Mode.RECOVER:
            self._fell = True
        elif self._fell and actual in BODIES:
            self._fell = False
            self._due = self._due or "fall"
        if self.stuck and self._tries and belief.stamp - self._last_plan > AGAIN_S:
            self._due = self._due or "again"
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
            self._tries = {"map": 0, "again": self._tries - 1}.get(why, AGAIN)
            return
        self.replans.append(Replan(belief.stamp, why, plan))
        self.stuck, self._failures, self._tries = False, 0, 0
        old = self.follower
        self._steps += self._planned * old.share
        self._planned = max(len(plan.modes) - 2, 0)  # without the ways to and from its cells
        self._rolls, self._refused = self._rolls + old.rolls, self._refused + old.rolls_refused
        self._failed += old.failures
        self.follower = self._follow(plan)
        self.follower.take_over(old)

    def _plan_from(self, xy: Array, actual: Mode) -> Plan:
        """A plan from the robot's cell, or from the nearest one that there is a way from."""
        problem: MobiusError = MapError("no free cell is near the robot")
        for world in self._worlds():
            for start in footholds(self.world, xy, solid=self._solid):
                try:
                    plan = self._planning(
                        world, self.modes, start=start, last_mode=actual, prices=self._prices
                    )
                except (NoPlan, MapError) as error:
                    problem = error
                    continue
                return with_ends(plan, self.world.grid, start=xy, body=actual)
        raise problem

    def _worlds(self) -> list[World]:
        """The world without the motions that failed where they did; then with those that are
        not to be given up yet.
        """
        first, last = (self._without(count) for count in (GIVE_UP, GIVE_UP_AT_LAST))
        return [first] if first is self.world else [first, last]

    def _without(self, count: int) -> World:
        """The world in which no cell near ``count`` failures of a motion admits its mode."""
        grid = self.world.grid
        allowed, centers = (
            grid.allowed.copy(),
            grid.center_of(np.moveaxis(np.indices(grid.shape), 0, -1)),
        )
        for mode, at in self._failed_at:
            same = [p for m, p in self._failed_at if m is mode]
            often = sum(np.linalg.norm(p - at) <= NEAR for p in same) >= count
            if often and mode is not Mode.CRAWL:  # recoveries end in it
                allowed[np.linalg.norm(centers - at, axis=-1) <= NEAR] &= np.uint8(255 - mode.bit)
        if (allowed == grid.allowed).all():
            return self.world
        return replace(self.world, grid=replace(grid, allowed=allowed))

    def _follow(self, plan: Plan) -> ModalFollower:
        return ModalFollower(
            plan,
            self._gains,
            room=self._room,
            grid_yaw=float(self.world.grid.origin_M[2]),
        )


def _solid(world: World) -> NDArray[np.bool_]:
    """(h, w) pixels in which something stands that the trunk cannot pass."""
    return blocked_pixels(world.occupancy, world.raised, unknown_blocks=False)


def footholds(world: World, xy: Array, *, solid: NDArray[np.bool_] | None = None) -> list[Array]:
    """Points (2,) [m] to plan from for a robot at ``xy`` (2,) [m], the nearest first.

    The robot's own if its cell is free, else the centres of free cells near it that nothing
    stands before.

    Args:
        world: Where.
        xy: The trunk.
        solid: Pixels that the trunk cannot pass, where they are known already.
    """
    grid = world.grid
    cell = tuple(grid.cell_of(xy))
    if grid.holds(cell) and not grid.blocked[cell]:
        return [xy]
    blocked = _solid(world) if solid is None else solid
    centers = grid.center_of(np.argwhere(~grid.blocked))
    far = np.linalg.norm(centers - xy, axis=1)
    near = [centers[k] for k in np.argsort(far, kind="stable") if far[k] <= FOOTHOLD]
    return [c for c in near if _is_open(world, blocked, xy, c)][:FOOTHOLDS]


def _is_open(world: World, solid: NDArray[np.bool_], a: Array, b: Array) -> bool:
    """Whether nothing is on the line from a to b, (2,) [m] each, but what a may be in."""
    raster = world.occupancy
    count = int(np.ceil(np.linalg.norm(b - a) / (0.4 * raster.resolution))) + 1
    pixels = raster.pixel_of(a + np.linspace(0.0, 1.0, count)[:, None] * (b - a))
    hits = [not raster.holds(p) or bool(solid[tuple(p)]) for p in pixels]
    return not any(hits[hits.index(False) :]) if False in hits else False
