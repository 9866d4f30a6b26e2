"""One pull-up as files: video, sheet of moments, plot of heights and wrenches, JSON."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from mobius.control.pullup import PullUp
from mobius.evaluate.pullup import PullUpDraw, PullUpTrial, bar_model, run_pullup
from mobius.files import write_json_atomic
from mobius.model.hang import hand_rotation
from mobius.robot.interface import TICK
from mobius.robot.sim import SimRobot
from mobius.stack import FRAME_EVERY, Stack
from mobius.view.camera import ChaseCamera
from mobius.view.sheet import draw_moments, write_sheet
from mobius.view.video import render_video

__all__ = ["Recording", "record_pullup", "write_pullup"]

Array = NDArray[np.float64]

SIZE = (640, 480)
CAMERA = ChaseCamera(distance=1.75, elevation=0.12, side=2.5, smooth=1.5)
"""From before the robot and a little from the side."""
_LEFT, _RIGHT, _WISH, _BAR = "#2a7fd4", "#d9772b", "#2f9e6e", "#8a8f98"


class Recording:
    """What one run leaves at 30 Hz."""

    def __init__(self) -> None:
        self.qpos: list[Array] = []
        self.phases: list[str] = []
        self.rows: list[Array] = []
        self._up = hand_rotation().T @ np.array([0.0, 0.0, 1.0])

    def see(self, stack: Stack, robot: SimRobot, controller: PullUp) -> None:
        """After each tick."""
        if stack.tick % FRAME_EVERY:
            return
        script: Any = controller.script
        self.qpos.append(np.array(robot.data.qpos))
        self.phases.append(str(script.phase))
        heard, wished = controller.heard, controller.wished
        left, right = robot.grasps
        self.rows.append(
            np.array(
                [
                    stack.tick * TICK,
                    robot.data.qpos[2],
                    robot.data.site("gaze").xpos[2],
                    *(heard[:, :3] @ self._up),
                    *heard[:, 0],
                    wished[0],
                    *heard[:, 4],
                    wished[4],
                    left.load,
                    right.load,
                ]
            )
        )

    @property
    def series(self) -> Array:
        """(m, 12) time, trunk, eyes [m], load, inner force (left, right, wished) [N], torsion
        (the same) [N m], share of the limit surface.
        """
        return np.array(self.rows)


def record_pullup(draw: PullUpDraw, **options: Any) -> tuple[PullUpTrial, Recording]:
    """One pull-up with its film; ``options`` as for :func:`run_pullup`."""
    recording = Recording()
    return run_pullup(draw, see=recording.see, **options), recording


def _plot(path: Path, draw: PullUpDraw, recording: Recording) -> None:
    s = recording.series
    t = s[:, 0]
    figure = Figure(figsize=(8.0, 8.6), layout="constrained")
    height, load, inner, twist = figure.subplots(4, 1, sharex=True)
    height.plot(t, s[:, 1], color=_LEFT, label="trunk")
    height.plot(t, s[:, 2], color=_WISH, label="eyes")
    height.axhline(draw.bar_height, color=_BAR, ls="--", label="bar")
    height.set_ylabel("height [m]")
    for column, colour, name in ((3, _LEFT, "left hand"), (4, _RIGHT, "right hand")):
        load.plot(t, s[:, column], color=colour, lw=1.0, label=name)
        inner.plot(t, s[:, column + 2], color=colour, lw=1.0, label=name)
        twist.plot(t, s[:, column + 5], color=colour, lw=1.0, label=name)
    load.set_ylabel("load [N]")
    inner.plot(t, s[:, 7], color=_WISH, ls="--", lw=1.0, label="wished")
    inner.set_ylabel("along the bar [N]")
    twist.plot(t, s[:, 10], color=_WISH, ls="--", lw=1.0, label="wished")
    twist.set_ylabel("torsion [N m]")
    twist.set_xlabel("time [s]")
    for at in (height, load, inner, twist):
        at.legend(frameon=False, fontsize="small", loc="upper right")
        at.grid(alpha=0.25)
    figure.savefig(path, dpi=110)


def write_pullup(
    folder: Path,
    draw: PullUpDraw,
    trial: PullUpTrial,
    recording: Recording,
    *,
    video: bool = True,
    progress: Callable[[str, float], None] | None = None,
) -> list[Path]:
    """Write ``pullup.mp4``, ``.png``, ``_forces.png`` and ``.json``; returns them.

    Args:
        folder: Where to.
        draw: Of the trial.
        trial: What came out.
        recording: Its film.
        video: Whether to draw the video, too.
        progress: Called with what is going on and the share done.

    Raises:
        NoOpenGL: Nothing can be drawn here.
    """
    files = [
        folder / name for name in ("pullup.mp4", "pullup.png", "pullup_forces.png", "pullup.json")
    ]
    model, qpos = bar_model(draw), np.stack(recording.qpos)
    fps = 1.0 / (FRAME_EVERY * TICK)
    lines = [
        f"{t:5.1f} s  {phase}"
        for t, phase in zip(recording.series[:, 0], recording.phases, strict=True)
    ]
    if video:

        def tell(done: int, count: int) -> None:
            if progress is not None:
                progress("draw", done / count)

        render_video(
            files[0], model, qpos, qpos_fps=fps, fps=fps, size=SIZE, captions=lines,
            camera=CAMERA, progress=tell,
        )  # fmt: skip
    rows = np.unique(np.linspace(0, len(qpos) - 1, 12).round().astype(int)).tolist()
    pictures = draw_moments(
        model, qpos, rows, captions=[lines[k] for k in rows], qpos_fps=fps, size=(320, 240),
        camera=CAMERA,
    )  # fmt: skip
    write_sheet(files[1], pictures, columns=4)
    _plot(files[2], draw, recording)
    summary = {
        "seed": trial.seed,
        "success": trial.success,
        "possible": trial.possible,
        "why": trial.why,
    }
    write_json_atomic(files[3], summary | trial.truth.as_json())
    return files if video else files[1:]
