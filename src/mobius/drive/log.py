"""The log of a live drive, begun and ended by a button."""

from __future__ import annotations

import time
from pathlib import Path

from mobius.bridge.record import McapRecorder
from mobius.stack import Sample
from mobius.types import Plan, Pose, StateEstimate
from mobius.world import World

FOLDER = Path("runs")
"""Where logs go, under the folder that the program was started in."""


class LiveLog:
    """Nothing, or one log that is being written."""

    def __init__(self, folder: Path = FOLDER) -> None:
        self.folder, self.last = folder, ""
        self._recorder: McapRecorder | None = None
        self._path: Path | None = None

    @property
    def name(self) -> str:
        """The file that will be written; empty while nothing is recorded."""
        return "" if self._path is None else str(self._path)

    def begin(self, world: World, plan: Plan | None) -> None:
        """Start a log of what happens from now on."""
        stamp = time.strftime("%Y%m%d-%H%M%S")
        self._path = self.folder / f"drive_{stamp}" / "run.mcap"
        self._recorder = McapRecorder()
        here = Pose(p=[0.0, 0.0, 0.0], q=[1.0, 0.0, 0.0, 0.0])  # type: ignore[arg-type]
        self._recorder.once(grid=world.grid, plan=plan, pose_MO=here)

    def take(self, sample: Sample, truth: StateEstimate) -> None:
        """One sample of the loop."""
        if self._recorder is not None:
            self._recorder.step(
                sample.tick,
                frame=sample.frame,
                belief=sample.belief,
                command=sample.command,
                target=sample.sent,
                truth=truth,
            )

    def end(self) -> None:
        """Write the log that was begun, if one was."""
        recorder, path = self._recorder, self._path
        self._recorder = self._path = None
        if recorder is not None and path is not None:
            path.parent.mkdir(parents=True, exist_ok=True)
            recorder.save(path)
            self.last = str(path)
