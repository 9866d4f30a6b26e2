"""The log of a live drive, begun and ended by a button."""

from __future__ import annotations

import time
from contextlib import suppress
from dataclasses import asdict
from importlib import metadata
from pathlib import Path
from typing import Any

from mobius.bridge.about import About
from mobius.bridge.record import McapRecorder
from mobius.errors import MobiusError
from mobius.model.urdf import build_urdf
from mobius.robot import TICK
from mobius.stack import Sample
from mobius.types import Plan, Pose, StateEstimate
from mobius.world import World

FOLDER = Path("runs")
"""Where logs go, under the folder that the program was started in."""


class LiveLog:
    """Nothing, or one log that is being written: whatever ends the program, it can be read."""

    def __init__(self, folder: Path = FOLDER) -> None:
        self.folder, self.last = folder, ""
        self._recorder: McapRecorder | None = None
        McapRecorder()  # the first one compiles serialisers; later the loop would wait for it
        self._urdf = build_urdf()
        self._head: tuple[World, Plan | None] | None = None

    @property
    def name(self) -> str:
        """The file that is being written; empty while nothing is recorded."""
        return "" if self._recorder is None else str(self._recorder.path)

    def begin(
        self, world: World, plan: Plan | None, *, scene: str, seed: int, variation: Any
    ) -> None:
        """Start a log of what happens from now on.

        Args:
            world: The map.
            plan: That there is, if one is.
            scene: MJCF of everything.
            seed: Of the robot.
            variation: How it differs from the drawing.

        Raises:
            InvalidInput: The file cannot be made.
        """
        name = f"drive_{time.strftime('%Y%m%d-%H%M%S')}"
        taken = len(list(self.folder.glob(f"{name}*")))
        folder = self.folder / (f"{name}-{taken + 1}" if taken else name)
        about = About(
            map=world.name,
            seed=seed,
            variation=asdict(variation),
            versions=_versions(),
            scene=scene,
        )
        self._recorder = McapRecorder(path=folder / "run.mcap", about=about)
        self._head = (world, plan)

    def take(self, sample: Sample, truth: StateEstimate) -> None:
        """One sample of the loop."""
        if self._recorder is None:
            return
        if self._head is not None:
            world, plan = self._head
            here = Pose(p=[0.0, 0.0, 0.0], q=[1.0, 0.0, 0.0, 0.0])  # type: ignore[arg-type]
            stamp = sample.tick * TICK
            self._recorder.once(
                stamp=stamp,
                grid=world.grid,
                plan=plan,
                pose_MO=here,
                description=self._urdf,
            )
            self._head = None
        self._recorder.see(sample, truth)

    def plan(self, plan: Plan) -> None:
        """A plan that was made on the way."""
        if self._recorder is not None and self._head is None:
            self._recorder.once(plan=plan)

    def end(self) -> None:
        """Close the log that was begun, if one was."""
        recorder, self._recorder = self._recorder, None
        if recorder is not None:
            self.last = str(recorder.path)
            recorder.close()

    def drop(self) -> None:
        """End a log that can no longer be written; what was written before can be read."""
        with suppress(MobiusError):
            self.end()


def _versions() -> dict[str, str]:
    """Of what a run depends on."""
    return {name: metadata.version(name) for name in ("mobius", "mujoco", "onnxruntime")}
