"""A run of the whole stack, recorded for pictures: configurations, modes, support, faults."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mobius.modes import Event
from mobius.reel.acts import Script
from mobius.robot import TICK
from mobius.stack import FRAME_EVERY, READ_EVERY, Stack
from mobius.types import LIMBS, Mode

Array = NDArray[np.float64]

FPS = 1.0 / (FRAME_EVERY * TICK)
"""Recorded configurations per second: 30."""
PRESSED = 1.0
"""A limb's end that presses on the floor with more than this stands [N]."""


@dataclass
class Faults:
    """What would look wrong, in one mode; looked for at 300 Hz, on the truth."""

    into_floor: float = 0.0
    """Deepest that anything went into the floor [m]."""
    into_itself: float = 0.0
    """Deepest that links went into one another [m]."""
    slid: Array = field(default_factory=lambda: np.zeros(len(LIMBS)))
    """(4,) way that each limb's end slid while it pressed on the floor [m], order LIMBS."""
    pressed_s: Array = field(default_factory=lambda: np.zeros(len(LIMBS)))
    """(4,) time that it pressed [s]."""


@dataclass(eq=False)
class Footage:
    """m frames at 30 Hz of one run."""

    t: Array
    """(m,) [s]."""
    qpos: Array
    """(m, nq) configurations."""
    modes: list[Mode]
    """m modes."""
    acts: list[int]
    """m indices of acts."""
    com: Array
    """(m, 3) centre of mass [m]."""
    support: list[Array]
    """m arrays (k, 2): where the robot has touched the floor since the frame before [m]."""
    faults: dict[Mode, Faults]
    """By mode, where the run has been in it."""
    events: list[Event]
    failed: str
    """Why the script did not come to its end; empty when it did."""


class _Camera:
    """Takes the frames."""

    def __init__(self, robot: Any) -> None:
        self.robot, model = robot, robot.model
        self.floor = model.geom("floor").id
        self.trunk = model.body("base_link").id
        self.rows: list[tuple[Array, Array, Array]] = []
        self.modes: list[Mode] = []
        self.acts: list[int] = []
        self.faults: dict[Mode, Faults] = {}
        self.touched = [np.zeros((0, 2))]

    def shoot(self, mode: Mode, act: int) -> None:
        """One frame."""
        data = self.robot.data
        com = np.array(data.subtree_com[self.trunk])
        self.rows.append((np.array(data.qpos), com, np.concatenate(self.touched)))
        self.touched = [np.zeros((0, 2))]
        self.modes.append(mode)
        self.acts.append(act)

    def inspect(self, mode: Mode) -> None:
        """Look for faults."""
        faults = self.faults.setdefault(mode, Faults())
        contact = self.robot.data.contact
        if len(contact.dist):
            floor = (contact.geom == self.floor).any(axis=1)
            depth = np.maximum(-contact.dist, 0.0)
            self.touched.append(np.array(contact.pos[floor & (depth > 0.0)][:, :2]))
            faults.into_floor = max(faults.into_floor, float(depth[floor].max(initial=0.0)))
            faults.into_itself = max(faults.into_itself, float(depth[~floor].max(initial=0.0)))
        force, speed = self.robot.sole_contact()
        dt, pressed = READ_EVERY * TICK, force > PRESSED
        faults.slid += dt * np.where(pressed, speed, 0.0)
        faults.pressed_s += dt * pressed


def film(stack: Stack, robot: Any, script: Script, *, limit_s: float) -> Footage:
    """Run a script to its end, or until it fails or ``limit_s`` [s] have passed.

    Args:
        stack: The whole robot, not yet turned.
        robot: Its SimRobot.
        script: What is asked.
        limit_s: Longest run [s].
    """
    camera, mode = _Camera(robot), script.first
    while not script.over and not script.failed:
        if stack.tick * TICK > limit_s:
            script.failed = f"not over after {limit_s:g} s"
            break
        if stack.tick % READ_EVERY == 0:
            camera.inspect(mode)
        if stack.tick % FRAME_EVERY == 0:
            camera.shoot(mode, script.act)
        sample = stack.turn(script)
        if sample is not None:
            mode = sample.command.mode
            script.see(sample, robot)
    return Footage(
        t=FRAME_EVERY * TICK * np.arange(len(camera.rows), dtype=float),
        qpos=np.stack([r[0] for r in camera.rows]),
        modes=camera.modes,
        acts=camera.acts,
        com=np.stack([r[1] for r in camera.rows]),
        support=[r[2] for r in camera.rows],
        faults=camera.faults,
        events=list(stack.machine.events),
        failed=script.failed,
    )
