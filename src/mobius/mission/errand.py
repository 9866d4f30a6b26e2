"""Go there: a goal that somebody gives while the robot is live, planned and driven at once.

Planning runs in a thread of its own; until it is done the robot stands. On the maps that come
with the package it takes milliseconds. While a large map is planned, ticks of the stack may come
late; :class:`mobius.pace.Pace` tells.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import replace
from queue import SimpleQueue
from threading import Thread

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.errors import InvalidInput, MapError, MobiusError
from mobius.mission.pilot import BODIES, Pilot
from mobius.mission.prepare import plan_mission
from mobius.modes.machine import WALKING
from mobius.robot import TICK
from mobius.stack import ACT_EVERY
from mobius.types import Mode, ModeCommand, Plan, StateEstimate
from mobius.world import World

Array = NDArray[np.float64]

NEARBY = 0.75
"""A goal in a cell where the robot does not fit moves to the nearest one that it does, at most so
far away [m]."""


def place_on(world: World, xy: ArrayLike) -> Array:
    """(2,) [m] the centre of the free cell at a place, or of the nearest one.

    Raises :class:`MapError` where there is none within :data:`NEARBY`.
    """
    grid, (x, y) = world.grid, np.asarray(xy, dtype=float)
    cells = np.argwhere(~grid.blocked)
    centers = grid.center_of(cells)
    with np.errstate(over="ignore"):  # a place may be anywhere
        far = np.linalg.norm(centers - (x, y), axis=1) if len(cells) else np.array([np.inf])
    k = int(np.argmin(far))
    if not far[k] <= NEARBY:
        raise MapError(
            f"map '{world.name}': the robot does not fit within {NEARBY:g} m of"
            f" ({x:.2f}, {y:.2f}) m; choose a place in the open"
        )
    nearest: Array = centers[k]
    return nearest


class Errand:
    """Plans to a goal and drives there; a new goal takes the place of the old one."""

    def __init__(
        self,
        world: World,
        modes: Sequence[Mode],
        *,
        planning: Callable[..., Plan] = plan_mission,
        wait: bool = False,
    ) -> None:
        """Begin with nowhere to go.

        Args:
            world: As the robot knows it.
            modes: That plans may use.
            planning: Makes the plans.
            wait: Plan in the caller's thread, for runs that must come out the same.
        """
        if Mode.CRAWL not in modes:
            raise InvalidInput("errand: expected crawl among the modes; recoveries end in it")
        self._world, self._modes, self._planning = world, tuple(modes), planning
        self._wait, self._planner = wait, _Planner()
        self._pilot: Pilot | None = None
        self._made: Future[tuple[World, Plan]] | None = None
        self.plan: Plan | None = None
        """The newest plan, of this errand or the last."""
        self.state = "idle"
        """``idle``, ``planning``, ``driving``, ``arrived`` or ``refused``."""
        self.notice = ""
        """Why it was refused, or what there is to say."""

    @property
    def world(self) -> World:
        """As the robot knows it."""
        return self._world

    def go(self, goal: Array, at: Array, actual: Mode) -> None:
        """Plan from ``at`` to ``goal``, (2,) [m] each, frame map, and set out."""
        self.cancel()
        try:
            there = place_on(self._world, goal)
            foothold = place_on(self._world, at)
        except MapError as error:
            self.state, self.notice = "refused", str(error)
            return
        grid = replace(self._world.grid, start=np.asarray(at, dtype=float), goal=there)
        world = replace(self._world, grid=grid)
        body = actual if actual in BODIES else Mode.CRAWL
        self.state = "planning"
        self._made = self._planner.submit(lambda: self._make(world, foothold, body))

    def _make(self, world: World, start: Array, body: Mode) -> tuple[World, Plan]:
        return world, self._planning(world, self._modes, start=start, last_mode=body)

    def cancel(self) -> None:
        """Forget the goal; the robot stands."""
        if self._made is not None:
            self._made.cancel()
        self._made = self._pilot = None
        if self.state in ("planning", "driving"):
            self.state, self.notice = "idle", "somebody took the controls"

    def close(self) -> None:
        """End the planning thread; a plan that is being made is not waited for."""
        self.cancel()
        self._planner.close()

    def command(self, belief: StateEstimate, actual: Mode) -> ModeCommand | None:
        """The next 60 Hz command; None while there is nowhere to go."""
        if self._made is not None and (self._wait or self._made.done()):
            self._set_out()
        if self._pilot is None:
            return None
        known = len(self._pilot.replans)
        command = self._pilot.command(belief, ACT_EVERY * TICK, actual)
        for replan in self._pilot.replans[known:]:
            self.plan = replan.plan or self.plan
        if self._pilot.arrived and actual in WALKING:
            self._pilot, self.state, self.notice = None, "arrived", ""
        elif self._pilot.hopeless:
            problems = [r.problem for r in self._pilot.replans if r.problem]
            self._pilot, self.state = None, "refused"
            self.notice = problems[-1] if problems else "there is no way"
        return command

    def _set_out(self) -> None:
        made, self._made = self._made, None
        assert made is not None
        try:
            world, plan = made.result()
        except MobiusError as error:
            self.state, self.notice = "refused", str(error)
            return
        self.plan = plan
        self._pilot = Pilot(world, plan, self._modes, planning=self._planning)
        self.state, self.notice = "driving", ""


Made = Future[tuple[World, Plan]]


class _Planner:
    """Makes plans one after another, in a thread that the end of the program does not wait for, as
    it would for one of a ThreadPoolExecutor: a large map may take minutes.
    """

    def __init__(self) -> None:
        self._jobs: SimpleQueue[_Job | None] = SimpleQueue()
        self._thread: Thread | None = None

    def submit(self, make: Callable[[], tuple[World, Plan]]) -> Made:
        if self._thread is None:
            self._thread = Thread(target=_work, args=(self._jobs,), name="planner", daemon=True)
            self._thread.start()
        made: Made = Future()
        self._jobs.put((made, make))
        return made

    def close(self) -> None:
        self._jobs.put(None)


_Job = tuple[Made, Callable[[], tuple[World, Plan]]]


def _work(jobs: SimpleQueue[_Job | None]) -> None:
    while (job := jobs.get()) is not None:
        made, make = job
        if made.set_running_or_notify_cancel():
            try:
                made.set_result(make())
            except BaseException as error:  # raised where the plan is asked for
                made.set_exception(error)
