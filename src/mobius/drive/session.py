"""One robot under live control: requests in, commands to the stack, snapshots out.

Who commands, from strongest to weakest: the emergency stop (nobody), held keys (they take the
robot from the plan), the plan while it is followed, else it stands in the body that was asked for
last. The session knows no clock of its own: whoever turns it says what time it is, so that the
dead man's switch can be tested in simulated time.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobius.control.bodies import BODIES
from mobius.control.peers import controller_of
from mobius.drive.guide import Guide, Planner
from mobius.drive.hands import Hands
from mobius.drive.log import LiveLog
from mobius.drive.stage import MODES, build_stage, check_place, put_at, robot_on, scene_of
from mobius.drive.touch import body_in, let_loose, pose_of, pull, push, twist_of
from mobius.errors import InvalidInput, MobiusError, UnknownName
from mobius.modes import check_roll
from mobius.modes.machine import WALKING
from mobius.stack import Sample
from mobius.types import Mode, ModeCommand, StateEstimate
from mobius.view.live import nouns
from mobius.view.live.nouns import Keeping, Scene, Snapshot, Way

MOVING = (nouns.WantMode, nouns.Go, nouns.Release, nouns.UsePolicy)
"""Requests that can make the robot move: who asks one must be there, and stay."""


class Looked(NamedTuple):
    """What the true robot was like right after a sample, for :meth:`Session.see` to tell later."""

    truth: StateEstimate
    qpos: NDArray[np.float64]
    """(nq,) of the simulator."""
    contact: NDArray[np.float64]
    """(4,) size of the contact force at each limb's end [N]."""


class Session:
    """The robot, its stage and who commands it."""

    def __init__(
        self, source: str, planner: Planner, *, seed: int = 0, randomised: bool = True
    ) -> None:
        """Put the robot on a map.

        Args:
            source: A map file or a shipped map's name.
            planner: Makes plans.
            seed: Of friction, mass, delay and sensors; a reset draws the next.
            randomised: Whether they are drawn at all.

        Raises:
            MobiusError: The map cannot be used.
        """
        self._planner, self._seed, self._randomised = planner, seed, randomised
        self.hands, self.policies = Hands(), dict[str, str]()
        self.message, self.frozen, self.log = "", False, LiveLog()
        self._wanted = self._was = Mode.CRAWL
        self._belief: StateEstimate | None = None
        self._numbers = {"scene": 0, "snapshot": 0}
        self._logged = 0
        self._stage = build_stage(source)
        self._begin()

    # -- what a viewer is shown ----------------------------------------------------------

    @property
    def scene(self) -> Scene:
        """The world as it is now."""
        return scene_of(
            self._stage, self.robot.model, self._numbers["scene"], policies=self.policies
        )

    @property
    def scene_number(self) -> int:
        """Counts the scenes so far."""
        return self._numbers["scene"]

    @property
    def way(self) -> Way:
        """The plan to draw."""
        return self.guide.way

    def look(self) -> Looked:
        """What the robot is like now."""
        robot = self.robot
        return Looked(robot.truth(), np.array(robot.data.qpos), robot.contact_force())

    def see(self, sample: Sample, looked: Looked, keeping: Keeping) -> Snapshot:
        """A snapshot of a sample and what the robot was like then; also logs it."""
        self._belief = sample.belief
        said, plans = self.guide.look(), self.guide.way.number
        self.message = said or self.message
        try:
            if self.log.name:
                self.log.take(sample, looked.truth)
            if plans != self._logged and self.guide.plan is not None:
                self.log.plan(self.guide.plan)
        except MobiusError as error:  # as where the disk is full: the robot goes on
            self.log.drop()
            self.message = str(error)
        self._logged = plans
        return self.show(sample, looked, keeping)

    def show(self, sample: Sample, looked: Looked, keeping: Keeping) -> Snapshot:
        """A snapshot of a sample, with what has been asked since."""
        truth, machine = looked.truth, self.stack.machine
        body = body_in(machine.mode)
        self._numbers["snapshot"] += 1
        return Snapshot(
            number=self._numbers["snapshot"],
            scene=self._numbers["scene"],
            t=truth.stamp,
            qpos=looked.qpos,
            mode=machine.mode.value,
            wanted=self._wanted.value,
            stopped=machine.stopped,
            notice=machine.notice,
            message=self.message,
            twist=np.stack(
                [sample.command.twist_H, twist_of(body, sample.belief), twist_of(body, truth)]
            ),
            true_pose=pose_of(body, truth),
            believed_pose=pose_of(body, sample.belief),
            power=sample.power,
            contact=looked.contact,
            wrench=np.array(sample.frame.wrench_S),
            keeping=keeping,
            plan=self.guide.way.number,
            following=self.guide.following,
            arrived=self.guide.arrived,
            frozen=self.frozen,
            recording=self.log.name,
        )

    # -- who commands ----------------------------------------------------------------------

    def source(self, now: Callable[[], float]) -> Callable[[StateEstimate], ModeCommand]:
        """What the stack asks at 60 Hz.

        Args:
            now: Wall clock [s], the same as beats are stamped with.
        """

        def command(belief: StateEstimate) -> ModeCommand:
            return self._command(belief, now())

        return command

    def _command(self, belief: StateEstimate, now: float) -> ModeCommand:
        actual = self.stack.machine.mode
        self._note_change(actual)
        if self.hands.holding(now):
            self.guide.pause()
        if self.guide.following:
            command = self.guide.command(belief, actual)
            if actual in WALKING:
                self._wanted = actual
            return command
        if self._wanted is Mode.ROLL and actual is Mode.CRAWL:
            self._look_before_rolling(belief)
        twist = self.hands.twist(actual, now) if actual is self._wanted else np.zeros(3)
        return ModeCommand(self._wanted, twist, belief.stamp)

    def _note_change(self, actual: Mode) -> None:
        """A motion that is over is not asked for again; nor is what a fall broke off."""
        was, self._was = self._was, actual
        if was in (Mode.ROLL, Mode.PUSH_UPS, Mode.RECOVER) and actual in WALKING:
            self._wanted = actual

    def watch(self, now: float) -> None:
        """Stop where nobody is at the controls any more."""
        why = self.hands.lost(now)
        if why:
            let_loose(self.robot)
            if not self.stack.machine.stopped:
                self._halt(why)
        if self.stack.machine.stopped:  # also where it stopped by itself
            self.guide.pause()
            self.hands.let_go()

    # -- requests --------------------------------------------------------------------------

    def take(self, request: nouns.Request, now: float) -> None:
        """Carry out a request; what is wrong with it goes into :attr:`message`."""
        try:
            if isinstance(request, MOVING):
                self.hands.touch(now)
            if isinstance(request, nouns.WantMode | nouns.Go) and self.stack.machine.stopped:
                raise InvalidInput("not done: the robot is stopped; release the stop first (R)")
            self._take(request, now)
        except MobiusError as error:
            self.message = str(error)

    def _take(self, request: Any, now: float) -> None:
        match request:
            case nouns.Beat():
                self.hands.take(request, now)
            case nouns.Halt():
                self._halt(request.why)
            case nouns.Release():
                self.hands.let_go()
                self._wanted, self.message = Mode.CRAWL, ""
                self.stack.machine.release()
            case nouns.WantMode():
                self._want(request.mode)
            case nouns.SpeedLimit():
                self.hands.set_limit(request.share)
            case nouns.Push():
                push(self.robot, self.stack.machine.mode, request.dv, request.bearing)
            case nouns.Drag():
                pull(self.robot, request.xfrc)
            case nouns.Freeze():
                self.frozen = request.on
            case nouns.Record():
                self._record(request.on)
            case nouns.UsePolicy():
                self._use_policy(request)
            case _:
                self._take_place(request)

    def _take_place(self, request: Any) -> None:
        """Requests about map, plan and where the robot is."""
        mode = self.stack.machine.mode
        body = mode if mode in WALKING else Mode.CRAWL
        match request:
            case nouns.LoadMap():
                self._stage = build_stage(request.name)
                self._begin()
            case nouns.Reset():
                self._begin_again()
            case nouns.Place():
                if request.goal is not None:
                    check_place(self._stage.world, request.goal, "goal")
                    self.guide.aim(request.goal)
                if request.start is not None:
                    self._stage = put_at(self._stage, request.start)
                    self._begin_again()
            case nouns.MakePlan():
                self.guide.ask(self._here(), body, request.modes)
                self.message = "planning"
            case nouns.Go():
                self.guide.go(self._here(), body, request.modes)
                self.message = "planning" if self.guide.planning else "going"
            case nouns.Wait():
                self.guide.pause()
            case _:
                raise InvalidInput(f"unknown request {type(request).__name__}")

    def _begin_again(self) -> None:
        """A fresh robot with the goal there was."""
        goal = self.guide.goal
        self._begin()
        if goal is not None:
            self.guide.aim((float(goal[0]), float(goal[1])))

    def _begin(self) -> None:
        """A fresh robot at the start; a log ends with the one that was there."""
        recorded = self.log.name
        self.log.end()
        self.stack, self.robot = robot_on(
            self._stage, seed=self._seed, randomised=self._randomised, policies=self.policies
        )
        self._seed += 1
        self.guide = Guide(self._stage.world, self._planner)
        self._wanted = self._was = self.stack.machine.mode
        self._belief = None
        self._numbers["scene"] += 1
        self.message = f"saved {recorded}" if recorded else ""

    def _here(self) -> StateEstimate:
        if self._belief is None:
            raise InvalidInput("the robot does not know yet where it is; ask again")
        return self._belief

    def _halt(self, why: str) -> None:
        self.guide.pause()
        self.stack.machine.emergency_stop(why)
        self.message = why

    def _want(self, name: str) -> None:
        if name not in MODES:
            raise UnknownName("mode", name, MODES)
        self.guide.pause()
        self._wanted, self.message = Mode(name), ""

    def _look_before_rolling(self, belief: StateEstimate) -> None:
        """Give a roll up that would run into what the map knows of, right before it begins."""
        try:
            check_roll(belief, self._stage.room)
        except InvalidInput as error:
            self._wanted, self.message = Mode.CRAWL, str(error)

    def _record(self, on: bool) -> None:
        self.log.end()
        if on:
            self.log.begin(
                self._stage.world,
                self.guide.plan,
                scene=self._stage.xml,
                seed=self._seed - 1,
                variation=self.robot.variation,
            )
        self.message = f"recording {self.log.name}" if on else f"saved {self.log.last}"

    def _use_policy(self, request: nouns.UsePolicy) -> None:
        controller = controller_of(request.name, request.body, seed=self._seed)
        self.policies[request.body] = request.name
        self.stack.replace(BODIES[request.body].mode, controller)
        self.message = f"{request.body} is driven by {request.name}"
