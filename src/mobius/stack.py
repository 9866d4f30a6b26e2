"""The loop: the only file that knows all rooms.

One integer counts ticks of 1/600 s. At 300 Hz (every 2nd tick) the robot is read and the
belief updated; at 60 Hz (every 10th) the mode, its twist and the joint targets follow::

    frame   = senses.corrupt(robot.read())              robot    -> SensorFrame
    estimator.take(frame); belief = estimator.belief()  estimate -> StateEstimate
    command = machine.step(source(belief), seen)        modes    -> ModeCommand
    sent    = robot.write(limb.act(command, belief, frame))   control -> JointCommand

A controller with an attribute ``every`` acts every so many ticks in between, too (motions: 2).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from mobius.control.bodies import body_of
from mobius.control.observation import heading_twist
from mobius.errors import InvalidInput
from mobius.geometry import quat_conj, quat_to_rpy, rotate
from mobius.modes import DampedHold, ModeMachine, Seen, Trust
from mobius.robot import TICK, Robot
from mobius.types import (
    GridMap,
    JointCommand,
    Mode,
    ModeCommand,
    Plan,
    SensorFrame,
    StateEstimate,
)

Array = NDArray[np.float64]

READ_EVERY = 2
"""Ticks between readings and estimates (300 Hz)."""
ACT_EVERY = 10
"""Ticks between commands and targets (60 Hz)."""
FRAME_EVERY = 20
"""Ticks between video frames (30 Hz)."""

COLLISION_FORCE = 5.0
"""Contacts with obstacles above this count [N]."""
COLLISION_APART = 300
"""Ticks without contact after which a new contact is a new collision."""
_UP = np.array([0.0, 0.0, 1.0])

Heights = Callable[[Array], Array]
"""Height of the ground [m] at points (..., 2) [m]."""

Source = Callable[[StateEstimate], ModeCommand]
"""Where commands come from: a follower, a schedule, a joystick."""


class Controller(Protocol):
    """What serves a mode (Fig. 6, right column).

    It may have more: ``every``, ticks between two acts, a divisor of 10 and a multiple of 2;
    ``begin(targets)``, told the targets (22,) [rad] sent last, after each reset; ``state``
    (running, done, failed) and ``reason``, for the mode machine, and ``apart``, whether it stands
    elsewhere than where motions begin.
    """

    def reset(self) -> None:
        """Start anew."""

    def act(self, command: ModeCommand, belief: StateEstimate, frame: SensorFrame) -> JointCommand:
        """Targets of all joints."""


class Sensing(Protocol):
    """What makes perfect readings real."""

    def corrupt(self, frame: SensorFrame) -> SensorFrame:
        """Noise, drift, delay."""


class Believing(Protocol):
    """What turns readings into belief."""

    def take(self, frame: SensorFrame) -> None:
        """Take in one frame (300 Hz)."""

    def belief(self) -> StateEstimate:
        """What is believed now (60 Hz)."""

    def trust(self, *, vio: bool, legs: bool, ground: bool) -> None:
        """Which sources to hear from now on."""


@dataclass(frozen=True, eq=False)
class Sample:
    """One 60 Hz turn of the circle, for judges and recorders."""

    tick: int
    frame: SensorFrame
    """As the estimator saw it."""
    belief: StateEstimate
    command: ModeCommand
    sent: JointCommand
    energy: float
    """Mechanical work of all servos since the start, integral of sum |torque * rate| [J]."""
    power: float
    """The same over the last turn, as power [W]."""


class Stack:
    """Robot, senses, estimator, mode machine and controllers, turned by one counter."""

    def __init__(
        self,
        robot: Robot,
        *,
        senses: Sensing,
        estimator: Believing,
        machine: ModeMachine,
        controllers: Mapping[Mode, Controller],
    ) -> None:
        missing = [m.value for m in machine.available if m not in controllers]
        if missing:
            raise InvalidInput(
                f"no controller for mode {', '.join(missing)}; pass one or leave it out"
            )
        self.robot, self.senses, self.estimator = robot, senses, estimator
        self.machine = machine
        self.controllers: dict[Mode, Controller] = {Mode.STOP: DampedHold(), **controllers}
        self.tick = 0
        self.energy = 0.0
        self._active: Mode | None = None
        self._every = ACT_EVERY
        self._command: ModeCommand | None = None
        self._sent: JointCommand | None = None
        self._trust = Trust()
        self._frame: SensorFrame | None = None
        self._last_energy = 0.0

    def turn(self, source: Source) -> Sample | None:
        """One tick; a :class:`Sample` when it was a 60 Hz one."""
        if self.tick % READ_EVERY == 0:
            raw = self.robot.read()
            self.energy += float(np.abs(raw.torque) @ np.abs(raw.dq)) * READ_EVERY * TICK
            self._frame = self.senses.corrupt(raw)
            self.estimator.take(self._frame)
        sample = None
        due = self.machine.stopped and self._active is not Mode.STOP
        if self.tick % ACT_EVERY == 0:
            sample = self._act(source)
        elif due and self._frame is not None:  # an emergency stop waits for no one
            self._stop()
        elif self.tick % self._every == 0:
            self._write(self.estimator.belief())
        self.robot.wait()
        self.tick += 1
        return sample

    def _act(self, source: Source) -> Sample:
        frame = self._frame
        assert frame is not None  # tick 0 reads first
        belief = self.estimator.belief()
        if self.machine.stopped:  # whatever the source does, it is not asked
            wanted = ModeCommand(Mode.STOP, np.zeros(3), belief.stamp)
        else:
            wanted = source(belief)
        self._command = self.machine.step(wanted, self._seen(belief, frame))
        if self._command.mode is not self._active:
            self._change(self._command.mode)
        self._inform()
        sent = self._write(belief)
        power = (self.energy - self._last_energy) / (ACT_EVERY * TICK)
        self._last_energy = self.energy
        return Sample(self.tick, frame, belief, self._command, sent, self.energy, power)

    def replace(self, mode: Mode, controller: Controller) -> None:
        """Let another controller serve a mode from now on, also if it is the one that is on.

        Raises:
            InvalidInput: The mode has no controller that could be replaced.
        """
        if mode not in self.controllers:
            names = ", ".join(sorted(self.controllers))
            raise InvalidInput(f"mode '{mode}' has no controller to replace; there are: {names}")
        self.controllers[mode] = controller
        if mode is self._active:
            self._change(mode)

    def _stop(self) -> None:
        """Soft servos at once, between two samples."""
        belief = self.estimator.belief()
        self._command = ModeCommand(Mode.STOP, np.zeros(3), belief.stamp)
        self._change(Mode.STOP)
        self._write(belief)

    def _seen(self, belief: StateEstimate, frame: SensorFrame) -> Seen:
        """What the mode machine goes by."""
        active: Any = None if self._active is None else self.controllers[self._active]
        state, reason = getattr(active, "state", "running"), getattr(active, "reason", "")
        end = getattr(self.controllers.get(Mode.GATHER), "end", None)
        home = None if end is None else end.q
        return Seen(belief, frame.q, state, reason, getattr(active, "apart", False), home)

    def _change(self, mode: Mode) -> None:
        """Another controller takes over."""
        controller: Any = self.controllers[mode]
        self._every = getattr(controller, "every", ACT_EVERY)
        if ACT_EVERY % self._every or self._every % READ_EVERY:
            raise InvalidInput(
                f"controller of mode '{mode}': expected every = 2 or 10 ticks, got {self._every}"
            )
        controller.reset()
        if self._sent is not None and hasattr(controller, "begin"):
            controller.begin(self._sent.q)
        self._active = mode

    def _inform(self) -> None:
        """Tell the estimator what to trust from now on."""
        trust = self.machine.trust
        if trust != self._trust:
            self.estimator.trust(vio=trust.vio, legs=trust.legs, ground=trust.ground)
            self._trust = trust

    def _write(self, belief: StateEstimate) -> JointCommand:
        """Targets of the active controller, as the robot lets them through."""
        frame, command = self._frame, self._command
        assert frame is not None and command is not None  # tick 0 acts first
        self._sent = self.robot.write(self.controllers[command.mode].act(command, belief, frame))
        return self._sent


@dataclass(eq=False)
class RunRecord:
    """Everything one run leaves for the report, the plots and the video.

    Rows are samples at 60 Hz unless said otherwise; n samples, m video frames.
    """

    t: Array
    """(n,) [s]."""
    q: Array
    """(n, 22) joint angles [rad]."""
    q_target: Array
    """(n, 22) what ``robot.write`` let through [rad]."""
    torque: Array
    """(n, 22) servo torque [N m]."""
    power: Array
    """(n,) mechanical power, sum of |torque * rate| [W]."""
    true_p: Array
    """(n, 3) trunk position in M [m]."""
    true_rpy: Array
    """(n, 3) trunk roll, pitch, yaw [rad]."""
    true_twist_H: Array
    """(n, 3) vx, vy [m/s], wz [rad/s] in the heading frame."""
    belief_p: Array
    """(n, 3) [m], frame M."""
    belief_rpy: Array
    """(n, 3) [rad]."""
    belief_twist_H: Array
    """(n, 3)."""
    cmd_twist_H: Array
    """(n, 3) commanded."""
    contact_force: Array
    """(n, 4) size of the true contact force per limb end [N], order LIMBS."""
    contact_belief: Array
    """(n, 4) believed contact probability."""
    modes: list[str]
    """n mode names."""
    frame_t: Array
    """(m,) [s] video frames, 30 Hz."""
    frame_qpos: Array
    """(m, nq) full simulator configuration, for rendering."""
    grid: GridMap
    plan: Plan
    summary: dict[str, Any] = field(default_factory=dict)
    """What ``summary.json`` holds."""


class Judge:
    """Watches a simulated run with the truth at hand: falls, collisions, record rows."""

    def __init__(self, robot: Any, *, body: str = "crawl", ground: Heights | None = None) -> None:
        """Watch ``robot``.

        Args:
            robot: A SimRobot, or what offers all this asks of one.
            body: Decides how low and how steep a trunk has fallen.
            ground: Height of the floor, which the trunk's height is counted from; 0 if not given.
        """
        self.robot, self.body, self.ground = robot, body_of(body), ground
        self.samples: list[Sample] = []
        self.truths: list[StateEstimate] = []
        self.measured: list[tuple[Array, Array]] = []
        self.frames: list[Array] = []
        self.collisions = 0
        self.loop_residual = 0.0
        """Largest gap of the five-bar loops so far [m]."""
        self.fallen = False
        self._touching_until = -1

    def see(self, sample: Sample) -> StateEstimate:
        """Judge one sample; returns the truth."""
        truth: StateEstimate = self.robot.truth()
        if self.robot.obstacle_force() > COLLISION_FORCE:
            if sample.tick > self._touching_until:
                self.collisions += 1
            self._touching_until = sample.tick + COLLISION_APART
        up = float(rotate(quat_conj(truth.q_OB), _UP)[2 if self.body.heading == "crawl" else 0])
        floor = 0.0 if self.ground is None else float(self.ground(truth.p_OB[:2]))
        low = truth.p_OB[2] - floor < self.body.fallen_below
        self.fallen = bool(self.fallen or low or up < 0.6 or self.robot.trunk_grounded())
        self.samples.append(sample)
        self.truths.append(truth)
        self.loop_residual = max(self.loop_residual, self.robot.loop_residual())
        self.measured.append((self.robot.torque(), self.robot.contact_force()))
        if sample.tick % FRAME_EVERY == 0:
            self.frames.append(np.array(self.robot.data.qpos))
        return truth

    def columns(self) -> dict[str, Array]:
        """The record's columns by name, a row a sample."""
        samples = self.samples
        beliefs = [s.belief for s in samples]
        return {
            "t": TICK * np.array([s.tick for s in samples], dtype=float),
            "q": np.stack([s.frame.q for s in samples]),
            "q_target": np.stack([s.sent.q for s in samples]),
            "torque": np.stack([m[0] for m in self.measured]),
            "power": np.array([s.power for s in samples]),
            "true_p": np.stack([x.p_OB for x in self.truths]),
            "true_rpy": quat_to_rpy(np.stack([x.q_OB for x in self.truths])),
            "true_twist_H": self._twists(self.truths),
            "belief_p": np.stack([x.p_OB for x in beliefs]),
            "belief_rpy": quat_to_rpy(np.stack([x.q_OB for x in beliefs])),
            "belief_twist_H": self._twists(beliefs),
            "cmd_twist_H": np.stack([s.command.twist_H for s in samples]),
            "contact_force": np.stack([m[1] for m in self.measured]),
            "contact_belief": np.stack([x.contact for x in beliefs]),
        }

    def _twists(self, states: list[StateEstimate]) -> Array:
        q, v, w = (np.stack([getattr(x, k) for x in states]) for k in ("q_OB", "v_B", "w_B"))
        v_H, w_H = heading_twist(self.body, q, v, w)
        return np.column_stack([v_H[:, :2], w_H[:, 2]])

    def record(self, grid: GridMap, plan: Plan) -> RunRecord:
        """All rows as arrays."""
        columns: dict[str, Any] = self.columns()
        return RunRecord(
            **columns,
            modes=[s.command.mode.value for s in self.samples],
            frame_t=FRAME_EVERY * TICK * np.arange(len(self.frames), dtype=float),
            frame_qpos=np.stack(self.frames),
            grid=grid,
            plan=plan,
        )
