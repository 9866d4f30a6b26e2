"""From a plan of several modes to commands: follow, stop, change body, roll, go on."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from mobius.geometry import wrap_angle
from mobius.modes.follow import CRAWLING, WALKING, FollowerConfig
from mobius.modes.legs import Leg, heading_of, legs_of
from mobius.modes.tasks import Become, Go, Hold, Roll, Room, Stand, Task, TaskConfig, yaw_of
from mobius.types import Mode, ModeCommand, Plan, StateEstimate

Array = NDArray[np.float64]

GAINS: Mapping[Mode, FollowerConfig] = {Mode.CRAWL: CRAWLING, Mode.BIPED: WALKING}
CHANGE_S = 8.0
"""What a change of body takes at most, as a rule [s]."""
ROLL_S = 12.0
"""And a roll with what goes before and after [s]."""


class ModalFollower:
    """Follows one plan from the belief and the mode the robot is really in.

    Crawl and biped legs are followed as paths. Before a change of body the robot crawls or
    walks to the point where the mode changes, stands, and waits until the new body is there. A
    roll moves the robot towards its tail: it turns its tail along the step, rolls once, and
    crawls what is left of the step, its heading corrected.
    """

    def __init__(
        self,
        plan: Plan,
        gains: Mapping[Mode, FollowerConfig] = GAINS,
        *,
        config: TaskConfig | None = None,
        room: Room | None = None,
        grid_yaw: float = 0.0,
    ) -> None:
        """Follow a plan.

        Args:
            plan: In the frame of the belief.
            gains: Of the crawl and biped follower.
            config: Of everything between.
            room: Distance to obstacles [m] at (2,) [m]; open ground everywhere if not given.
            grid_yaw: Of the grid's x axis [rad].
        """
        self.config, self._gains = config or TaskConfig(), gains
        self._room, self._grid_yaw = room, grid_yaw
        self.legs = legs_of(plan)
        self._end = np.array(plan.xy_M[-1])
        self._last = plan.modes[-1] if plan.modes else Mode.CRAWL
        self._todo: list[tuple[Task, Leg]] = self._tasks()
        self._at = 0

    # -- what there is to know ------------------------------------------------------------

    @property
    def arrived(self) -> bool:
        """Whether all is done."""
        return self._at >= len(self._todo)

    @property
    def task(self) -> Task | None:
        """What the robot is about."""
        return None if self.arrived else self._todo[self._at][0]

    @property
    def length(self) -> float:
        """Of the plan [m]."""
        return sum(leg.length for leg in self.legs)

    @property
    def progress(self) -> float:
        """How much of it is done [m]."""
        total = 0.0
        for done, leg in self._todo[: self._at]:
            if isinstance(done, Go):
                total += leg.length
            elif isinstance(done, Roll):
                total += leg.length / (len(leg.xy) - 1)
        task = self.task
        return total + (task.follower.progress if isinstance(task, Go) else 0.0)

    @property
    def expected_s(self) -> float:
        """What it takes if all goes well [s]."""
        total = 0.0
        for leg in self.legs:
            if leg.mode is Mode.ROLL:
                total += ROLL_S * (len(leg.xy) - 1)
            else:
                total += leg.length / self._gains[leg.mode].speed
        return total + CHANGE_S * sum(a.mode is not b.mode for a, b in pairwise(self.legs))

    @property
    def rolls(self) -> int:
        """Rolls carried out."""
        return sum(isinstance(t, Roll) and t.rolled for t, _ in self._todo)

    @property
    def rolls_refused(self) -> int:
        """Rolls left out because there was no room."""
        return sum(isinstance(t, Roll) and t.refused for t, _ in self._todo)

    @property
    def failures(self) -> int:
        """Changes of body and rolls that did not come about when asked for."""
        return sum(t.failures for t, _ in self._todo)

    @property
    def failed(self) -> list[Mode]:
        """The mode that each of these was for."""
        return [t.motion for t, _ in self._todo for _ in range(t.failures)]

    @property
    def share(self) -> float:
        """How much of it is done, 0 to 1."""
        return 1.0 if self.arrived else min(self.progress / max(self.length, 1e-9), 1.0)

    @property
    def leg_mode(self) -> Mode | None:
        """The plan's mode of what the robot is about; None at the end."""
        return None if self.arrived else self._todo[self._at][1].mode

    def mode(self) -> Mode:
        """The body for what the robot is about."""
        task = self.task
        return self._last_body() if task is None else task.mode

    def off_plan(self, p: Array) -> float:
        """Distance [m] of p (2,) [m] to where the plan has the robot about now."""
        if not self._todo:
            return float(np.linalg.norm(p - self._end))
        task, leg = self._todo[min(self._at, len(self._todo) - 1)]
        return task.follower.cross_track(p) if isinstance(task, Go) else leg.distance(p)

    # -- what to do -----------------------------------------------------------------------

    def take_over(self, before: ModalFollower) -> None:
        """Go on from the twist of the follower before, where both walk in the same body."""
        now, first = before.task, next((t for t, _ in self._todo if isinstance(t, Go)), None)
        if isinstance(now, Go) and first is not None and self.legs[0].mode is now.mode:
            first.follower.go_on(now.follower.twist)

    def command(self, belief: StateEstimate, dt: float, actual: Mode) -> ModeCommand:
        """The command to send now.

        Args:
            belief: What the robot knows of itself.
            dt: Since the last call [s].
            actual: The mode it is really in.
        """
        while not self.arrived:
            task, leg = self._todo[self._at]
            if task._began is None and self._needless(task, leg, belief, actual):
                self._at += 1
                continue
            command = task.command(belief, dt, actual)
            if not task.done:
                return command
            self._at += 1
            if not isinstance(task, Become):
                return command
        return ModeCommand(mode=self._last_body(), twist_H=np.zeros(3), stamp=belief.stamp)

    def _needless(self, task: Task, leg: Leg, belief: StateEstimate, actual: Mode) -> bool:
        """Whether a task has nothing to do: a turn before standing up that is none."""
        if isinstance(task, Hold) and leg.mode is Mode.BIPED:
            if actual is Mode.BIPED:
                return True
            error = wrap_angle(leg.heading - yaw_of(Mode.CRAWL, belief))
            return actual is Mode.CRAWL and abs(float(error)) <= self.config.faced
        return False

    def _last_body(self) -> Mode:
        return Mode.BIPED if self._last is Mode.BIPED else Mode.CRAWL

    def _tasks(self) -> list[tuple[Task, Leg]]:
        """Everything there is to do, in order, each with the leg it belongs to."""
        c = self.config
        todo: list[tuple[Task, Leg]] = []
        for k, leg in enumerate(self.legs):
            last = k == len(self.legs) - 1
            if leg.mode is Mode.ROLL:
                todo.append((Become(Mode.CRAWL, c), leg))
                todo += [(task, leg) for task in self._rolls(leg)]
                continue
            if leg.mode is Mode.BIPED:
                face = Hold(leg.xy[0], leg.heading, c, turned=c.faced, near=2 * c.near)
                todo.append((face, leg))
            todo.append((Become(leg.mode, c), leg))
            gains = self._gains[leg.mode]
            todo.append((Go(leg, gains, c, room=self._room, grid_yaw=self._grid_yaw), leg))
            if not last:
                todo.append((Stand(leg.mode, c), leg))
        return todo

    def _rolls(self, leg: Leg) -> list[Task]:
        """Turn the tail along the step, roll, crawl what is left; step by step."""
        c, tasks = self.config, list[Task]()
        for a, b in pairwise(leg.xy):
            tail_first = heading_of(b, a)
            tasks += [
                Hold(a, tail_first, c, turned=c.turned, near=c.near),
                Stand(Mode.CRAWL, c),
                Roll(a, b, c, room=self._room),
                Stand(Mode.CRAWL, c),
                Hold(b, tail_first, c, turned=2 * c.turned, near=c.near),
            ]
        return tasks
