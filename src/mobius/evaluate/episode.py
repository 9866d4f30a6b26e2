"""One robot under a schedule of commands: drive it in the whole stack, compare with the truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mobius.assemble import Start, build_sim_stack, flat_model
from mobius.control.bodies import body_of
from mobius.evaluate.commands import Segment
from mobius.evaluate.gauge import Gauge, Readings
from mobius.robot import TICK
from mobius.robot.sim import SimRobot
from mobius.robot.variation import Variation
from mobius.stack import ACT_EVERY, READ_EVERY, Controller, Heights, Judge, Stack
from mobius.types import Mode, ModeCommand, StateEstimate

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Policy = Path | str | Controller | None
"""What drives: an ONNX file, ``zero``, ``random``, a controller, or the shipped policy."""

HOLD_S = 4.0
"""Each command is held this long [s]."""
SETTLE_S = 1.0
"""After a new command nothing is counted for this long [s]."""
WINDOW_S = 0.64
"""Velocities are averaged over this long before they are compared: a stride of the biped and a
slow one of the crawl. A window that is no stride would count part of the sway as error [s]."""


@dataclass(frozen=True)
class Setup:
    """Who is evaluated; plain values, so that it can be sent to another process."""

    body: str
    seed: int
    policy: Policy = None
    randomised: bool = True
    """Draw robot and sensors from the seed."""
    variation: Variation | None = None
    """Robot instead of the draw."""
    noise: float = 1.0
    """Factor on the noise of all sensors."""
    xy: tuple[float, float] = (0.0, 0.0)
    """Where the trunk begins [m]."""

    def start(self) -> Start:
        """How the run begins."""
        return Start(
            body=self.body,
            seed=self.seed,
            randomised=self.randomised,
            variation=self.variation,
            noise=self.noise,
            xy=self.xy,
        )


def build(
    setup: Setup, *, model: Any = None, ground: Heights | None = None
) -> tuple[Stack, SimRobot, Judge]:
    """Stack, robot and judge on a flat floor, or in ``model`` over ``ground``."""
    model = flat_model() if model is None else model
    stack, robot = build_sim_stack(model, setup.start(), policy=setup.policy, ground=ground)
    return stack, robot, Judge(robot, body=setup.body, ground=ground)


@dataclass(eq=False)
class Episode:
    """A finished episode."""

    segments: Sequence[Segment]
    hold_s: float
    """How long each segment was held [s]."""
    fallen: bool
    rows: dict[str, Array]
    """Columns of the judge at 60 Hz."""
    readings: Readings
    loop_residual: float
    """Largest gap of the five-bar loops [m]."""

    def segment_at(self, t: Array) -> NDArray[np.int64]:
        """(n,) which segment is on at times (n,) [s]; the last one from then on."""
        return np.minimum(np.floor(t / self.hold_s + 1e-9), len(self.segments) - 1).astype(np.int64)

    def since(self, t: Array) -> Array:
        """(n,) how long the command has been on at times (n,) [s]."""
        return t - self.hold_s * self.segment_at(t)

    @property
    def fell_in(self) -> int | None:
        """The segment during which it fell."""
        return int(self.segment_at(self.rows["t"][-1:])[0]) if self.fallen else None

    @cached_property
    def smooth(self) -> Array:
        """(n, 3) true vx, vy [m/s], wz [rad/s], running means over a stride."""
        width = round(WINDOW_S / (ACT_EVERY * TICK))
        kernel, true = np.ones(width) / width, self.rows["true_twist_H"]
        ahead = (width - 1) // 2
        columns = [np.convolve(column, kernel)[ahead : ahead + len(true)] for column in true.T]
        return np.stack(columns, axis=1)

    def counted(self, *, margin_s: float = 0.0) -> Flags:
        """(n,) rows at 60 Hz that count: settled, and ``margin_s`` before the command's end or
        the fall. All rows count where none does, as when the robot fell at once.
        """
        t = self.rows["t"]
        since = self.since(t)
        rows = (since > SETTLE_S) & (since < self.hold_s - margin_s) & (t <= t[-1] - margin_s)
        return rows if rows.any() else np.ones_like(rows)

    def error(self) -> Array:
        """(3,) mean |mean over a stride - command| in vx, vy [m/s], wz [rad/s]."""
        rows = self.counted(margin_s=0.5 * WINDOW_S)
        return np.asarray(np.abs(self.smooth - self.rows["cmd_twist_H"])[rows].mean(axis=0))

    def raw_error(self) -> Array:
        """(3,) the same without averaging."""
        rows = self.counted()
        error = self.rows["true_twist_H"] - self.rows["cmd_twist_H"]
        return np.asarray(np.abs(error)[rows].mean(axis=0))

    def estimate_error(self) -> Array:
        """(3,) RMS of believed minus true vx, vy [m/s], wz [rad/s]."""
        error = self.rows["belief_twist_H"] - self.rows["true_twist_H"]
        return np.asarray(np.sqrt(np.mean(error**2, axis=0)))

    def distance(self) -> float:
        """Way of the trunk over the floor [m], in steps of a stride: without its sway."""
        step = round(WINDOW_S / (ACT_EVERY * TICK))
        xy = self.rows["true_p"][::step, :2]
        return float(np.linalg.norm(np.diff(xy, axis=0), axis=1).sum())


def drive(
    setup: Setup,
    segments: Sequence[Segment],
    *,
    hold_s: float = HOLD_S,
    model: Any = None,
    ground: Heights | None = None,
) -> Episode:
    """Follow the segments, each for ``hold_s`` [s], until they end or the robot falls.

    Args:
        setup: Who drives.
        segments: At least one.
        hold_s: [s].
        model: Scene with the robot; a flat floor if not given.
        ground: Height of the scene's floor.
    """
    stack, robot, judge = build(setup, model=model, ground=ground)
    gauge = Gauge(robot, body=setup.body, ground=ground)
    mode: Mode = body_of(setup.body).mode
    hold = round(hold_s / TICK)
    twists = [np.array(s.twist) for s in segments]

    def source(belief: StateEstimate) -> ModeCommand:
        return ModeCommand(mode=mode, twist_H=twists[stack.tick // hold], stamp=belief.stamp)

    while stack.tick < hold * len(segments) and not judge.fallen:
        if stack.tick % READ_EVERY == 0:
            gauge.look()
        sample = stack.turn(source)
        if sample is not None:
            judge.see(sample)
    return Episode(
        segments=segments,
        hold_s=hold_s,
        fallen=judge.fallen,
        rows=judge.columns(),
        readings=gauge.readings(),
        loop_residual=judge.loop_residual,
    )
