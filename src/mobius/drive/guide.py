"""The way to a goal: planned in a process of its own, then followed by the mission's pilot."""

from __future__ import annotations

import multiprocessing
import signal
from dataclasses import replace
from multiprocessing.connection import Connection

import numpy as np
from numpy.typing import NDArray

from mobius.errors import InvalidInput, MapError, MobiusError, PlanError
from mobius.mission.body import check_modes
from mobius.mission.pilot import Pilot, footholds
from mobius.mission.prepare import plan_mission, with_ends
from mobius.robot import TICK
from mobius.stack import ACT_EVERY
from mobius.types import Mode, ModeCommand, Plan, StateEstimate
from mobius.view.live.nouns import Way
from mobius.world import World

Array = NDArray[np.float64]
NO_WAY = Way(0, np.zeros((0, 2)), (), "", None)


class Planner:
    """Plans in another process, so that the loop keeps its time. Close it at the end.

    The process ends by itself when this one does, however it ends.
    """

    def __init__(self) -> None:
        self._asked = 0
        self._start()

    def ask(self, world: World, modes: tuple[Mode, ...], start: Array, body: Mode) -> int:
        """Begin to plan from ``start`` (2,) [m] to the world's goal in ``body``.

        Returns:
            The number of the question.
        """
        self._asked += 1
        question = (self._asked, world, modes, start, body)
        try:
            self._line.send(question)
        except OSError:  # it was ended from outside
            self._again()
            self._line.send(question)
        return self._asked

    def answer(self, number: int) -> Plan | MobiusError | None:
        """The plan that was asked for, why there is none, or None while it is being made."""
        try:
            while self._line.poll():
                came, plan = self._line.recv()
                if came == number:
                    return plan  # type: ignore[no-any-return]
        except (EOFError, OSError):
            self._again()
            return PlanError("the planner's process has ended without a plan; ask again")
        return None

    def close(self) -> None:
        """End the process."""
        self._line.close()
        self._process.terminate()
        self._process.join()

    def _start(self) -> None:
        context = multiprocessing.get_context("spawn")
        self._line, theirs = context.Pipe()
        self._process = context.Process(target=_plan_on_demand, args=(theirs,), daemon=True)
        self._process.start()
        theirs.close()

    def _again(self) -> None:
        """Another process in place of one that has ended."""
        self.close()
        self._start()


def _plan_on_demand(line: Connection) -> None:
    """The planner's process: answers one question after the other until the line breaks."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        while True:
            number, world, modes, start, body = line.recv()
            try:
                line.send((number, plan_mission(world, modes, start=start, last_mode=body)))
            except MobiusError as error:
                line.send((number, error))
    except (EOFError, BrokenPipeError, ConnectionResetError):
        return


class Guide:
    """Holds the goal, the plan and the pilot that follows it."""

    def __init__(self, world: World, planner: Planner) -> None:
        self.world, self._planner = world, planner
        self.goal = world.grid.goal
        self.following = False
        self.way = replace(NO_WAY, goal=self._goal())
        self._question = 0
        self._from: World | None = None
        self._pilot: Pilot | None = None
        self._modes: tuple[Mode, ...] = (Mode.CRAWL,)
        self._go = False
        self._replans = 0
        self._number = 0

    @property
    def arrived(self) -> bool:
        """Whether the plan has been followed to its end."""
        return self._pilot is not None and self._pilot.arrived

    @property
    def plan(self) -> Plan | None:
        """The plan that is there, if one is."""
        return None if self._pilot is None else self._plan

    @property
    def planning(self) -> bool:
        """Whether a plan is being made."""
        return self._question > 0

    def aim(self, xy: tuple[float, float]) -> None:
        """Another goal [m]; an older plan is forgotten."""
        self.goal = np.array(xy, dtype=float)
        self.forget()

    def pause(self) -> None:
        """Follow no plan, nor one that is still being made once it comes; keep it."""
        self.following = self._go = False

    def forget(self) -> None:
        """Drop the plan."""
        self.following, self._pilot, self._question, self._go = False, None, 0, False
        self._show(np.zeros((0, 2)), (), "")

    def ask(
        self, belief: StateEstimate, body: Mode, modes: tuple[str, ...], *, go: bool = False
    ) -> None:
        """Begin to plan from where the robot believes to be.

        Args:
            belief: Of the robot.
            body: It is in.
            modes: That the plan may use.
            go: Follow the plan as soon as it is there.

        Raises:
            InvalidInput: There is no goal, or no such mode.
        """
        if self.goal is None:
            raise InvalidInput("no goal: click one on the map, or type its x and y")
        self._modes = check_modes(modes)
        self.following, self._pilot = False, None
        here = np.array(belief.p_OB[:2])
        grid = replace(self.world.grid, start=here, goal=self.goal)
        self._from, self._go = replace(self.world, grid=grid), go
        starts = footholds(self._from, here)
        if not starts:
            raise MapError(
                f"no free cell is near the robot at ({here[0]:.2f}, {here[1]:.2f}) m; drive it"
                " away from the obstacles"
            )
        self._question = self._planner.ask(self._from, self._modes, starts[0], body)

    def go(self, belief: StateEstimate, body: Mode, modes: tuple[str, ...]) -> None:
        """Follow the plan; where there is none, or it has been followed, plan first."""
        if self._pilot is None or self._pilot.arrived:
            self.ask(belief, body, modes, go=True)
        else:
            self.following = True

    def look(self) -> str:
        """Take a plan that has come; returns what to say of it, or an empty text."""
        plan = self._planner.answer(self._question) if self._question else None
        if plan is None:
            return self._look_at_pilot()
        self._question = 0
        if isinstance(plan, MobiusError):
            self._show(np.zeros((0, 2)), (), "")
            return str(plan)
        assert self._from is not None  # set when it was asked for
        self._plan, self._pilot = plan, Pilot(self._from, plan, self._modes)
        self._replans, self.following = 0, self._go
        shown = with_ends(plan, self._from.grid)
        status = f"{plan.status}, {len(plan.modes)} steps, {1e3 * plan.solve_s:.0f} ms"
        self._show(shown.xy_M, tuple(m.value for m in shown.modes), status)
        return f"plan: {status}"

    def command(self, belief: StateEstimate, actual: Mode) -> ModeCommand:
        """The pilot's command; call only while :attr:`following`."""
        assert self._pilot is not None  # following begins with one
        command = self._pilot.command(belief, ACT_EVERY * TICK, actual)
        if self._pilot.arrived:
            self.following = False
        return command

    def _look_at_pilot(self) -> str:
        """Show a plan that the pilot made on the way."""
        pilot = self._pilot
        if pilot is None or len(pilot.replans) == self._replans:
            return ""
        self._replans, last = len(pilot.replans), pilot.replans[-1]
        if last.plan is None:
            return f"no new plan ({last.why}): {last.problem}"
        modes = tuple(m.value for m in last.plan.modes)
        self._show(last.plan.xy_M, modes, f"{last.plan.status}, made on the way ({last.why})")
        return f"new plan: {last.why}"

    def _goal(self) -> tuple[float, float] | None:
        return None if self.goal is None else (float(self.goal[0]), float(self.goal[1]))

    def _show(self, xy: Array, modes: tuple[str, ...], status: str) -> None:
        self._number += 1
        self.way = Way(self._number, xy, modes, status, self._goal())
