"""The log: one MCAP file per run.

A run that can be repeated is kept in memory and saved at its end, whole or absent
(:meth:`McapRecorder.save`). One that cannot, somebody driving, is written while it goes on:
``McapRecorder(path=...)`` opens the file, and whatever ends the program the file can be read
up to the last half second (:mod:`mobius.bridge.log_file`).
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, BinaryIO

from numpy.typing import ArrayLike

from mobius.bridge.about import About
from mobius.bridge.log_file import LogFile
from mobius.bridge.messages import CLOCK_HZ, TOPICS, due_rows, encode, topic
from mobius.bridge.to_ros import STORE, time_ns
from mobius.errors import InvalidInput, MobiusError
from mobius.files import write_bytes_atomic
from mobius.types import (
    GridMap,
    JointCommand,
    ModeCommand,
    Plan,
    Pose,
    SensorFrame,
    StateEstimate,
)

if TYPE_CHECKING:
    from mobius.stack import Sample

__all__ = ["McapRecorder"]

_SAMPLE = CLOCK_HZ // 60
"""Ticks between two samples of the stack."""


class McapRecorder:
    """Records the messages of one run, in memory or straight into a file.

    Call :meth:`once` with what does not change, then :meth:`see` at every sample or
    :meth:`step` at every tick of the base clock or at every tenth. At the end :meth:`save`
    what was held in memory (0.2 MB per simulated second), or :meth:`close` the file; as a
    context manager it closes itself. The first recorder of a program takes 0.05 s to make
    (serialisers are compiled), so a program with a loop to keep makes one ahead. One thread
    at a time may use it.

    Args:
        topics: Which topics of the table to record; by default all that are not only live.
        path: File ending in ``.mcap`` to write as the run goes on; it must not exist.
        about: What is recorded.

    Raises:
        UnknownName: A topic is not in the table.
        InvalidInput: ``path`` has another ending, exists, or cannot be made.
    """

    def __init__(
        self,
        *,
        topics: tuple[str, ...] | None = None,
        path: str | Path | None = None,
        about: About | None = None,
    ) -> None:
        logged = tuple(name for name, row in TOPICS.items() if row.where != "live")
        rows = [topic(name) for name in (logged if topics is None else topics)]
        self._latched = [row for row in rows if row.latched]
        self._due = due_rows(rows)
        for row in rows:  # what the first message of a type would wait for
            STORE.get_msgdef(row.type)
        self._messages: list[tuple[str, int, bytes | memoryview]] = []
        self._count = 0
        self._last = self._shift = 0  # ticks
        self._about = about
        self.path = None if path is None else Path(path)
        self._stream: BinaryIO | None = None
        self._file: LogFile | None = None
        if self.path is not None:
            self._stream = _new_file(self.path)
            self._file = LogFile(self._stream, about=about)

    def __len__(self) -> int:
        """How many messages were recorded."""
        return self._count

    @property
    def time(self) -> float:
        """Log time of the last sample [s]; 0 before any."""
        return self._last / CLOCK_HZ

    def __enter__(self) -> McapRecorder:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def once(
        self,
        *,
        stamp: float | None = None,
        grid: GridMap | None = None,
        plan: Plan | None = None,
        pose_MO: Pose | None = None,
        obstacles: ArrayLike | None = None,
        description: str | None = None,
    ) -> None:
        """Record what is published once: map, plan, pose of odom in map, the robot; obstacles as
        they move.

        Args:
            stamp: When it was said [s]; the time of the last sample if not given, 0 before any.
                A log that begins in the middle of a drive gives that of its first sample.
            grid: For ``/map``.
            plan: For ``/plan`` and ``/mobius/plan_modes``.
            pose_MO: For ``/tf_static``.
            obstacles: (k, 7) poses of the scene's mocap bodies, x y z [m] qw qx qy qz.
            description: URDF, for ``/robot_description``.
        """
        nouns = {
            "grid": grid,
            "plan": plan,
            "pose_MO": pose_MO,
            "obstacles": obstacles,
            "description": description,
        }
        self._take(self._latched, self.time if stamp is None else stamp, nouns)

    def see(self, sample: Sample, truth: StateEstimate | None = None) -> None:
        """Record one 60 Hz sample of the stack, and the simulator's own state beside it."""
        self.step(
            sample.tick,
            frame=sample.frame,
            belief=sample.belief,
            command=sample.command,
            target=sample.sent,
            truth=truth,
        )

    def step(
        self,
        tick: int,
        *,
        frame: SensorFrame | None = None,
        belief: StateEstimate | None = None,
        command: ModeCommand | None = None,
        target: JointCommand | None = None,
        truth: StateEstimate | None = None,
    ) -> None:
        """Record the topics that are due at a tick; a noun left out is not recorded.

        Args:
            tick: Count of the 600 Hz base clock. Where it goes back, as after a reset, the
                log's time goes on.
            frame: What the devices said.
            belief: What the estimator believes, frame odom.
            command: Mode and twist asked for.
            target: What ``robot.write`` let through.
            truth: The simulator's own state, ``p_OB`` and ``q_OB`` holding the pose in map.
        """
        due = self._due[tick % CLOCK_HZ]
        if due:
            if tick + self._shift < self._last:
                self._shift = self._last + _SAMPLE - tick
            self._last = tick + self._shift
            stamp = self._last / CLOCK_HZ
            nouns = {
                "clock": stamp,
                "frame": frame,
                "belief": belief,
                "command": command,
                "target": target,
                "truth": truth,
            }
            self._take(due, stamp, nouns)

    def write(self, name: str, noun: Any, *, stamp: float) -> None:
        """Record one noun under one topic of the table at ``stamp`` [s].

        Raises:
            MobiusError: The file cannot be written any more, as where the disk is full; what
                was written before can be read.
        """
        data = encode(name, noun)
        if data is None:
            return
        if self.path is None:
            self._messages.append((name, time_ns(stamp), data))
        elif self._file is not None:
            with _writing(self.path):
                self._file.write(name, time_ns(stamp), data)
        else:
            raise MobiusError(f"{self.path}: the log is closed; open another one")
        self._count += 1

    def _take(self, rows: Any, stamp: float, nouns: dict[str, Any]) -> None:
        for row in rows:
            noun = nouns.get(row.noun)
            if noun is not None:
                self.write(row.name, noun, stamp=stamp)

    def save(self, path: str | Path) -> None:
        """Write everything held to ``path``, an MCAP file with zstd chunks.

        Raises:
            InvalidInput: ``path`` does not end in ``.mcap``, nothing was recorded, or the
                recorder writes a file already.
        """
        path = _checked(Path(path))
        if self.path is not None:
            raise InvalidInput(f"{path}: this recorder writes {self.path}; type .close()")
        if not self._messages:
            raise InvalidInput(f"{path}: nothing was recorded; call step() or once() first")
        stream = io.BytesIO()
        log = LogFile(stream, about=self._about, live=False)
        for name, stamp_ns, data in self._messages:
            log.write(name, stamp_ns, data)
        log.finish()
        write_bytes_atomic(path, stream.getbuffer())

    def close(self) -> None:
        """End the file with its index; does nothing for a recorder in memory or closed before."""
        file, stream = self._file, self._stream
        self._file = self._stream = None
        if file is not None and stream is not None and self.path is not None:
            with _writing(self.path), stream:
                file.finish()


def _checked(path: Path) -> Path:
    if path.suffix != ".mcap":
        raise InvalidInput(f"{path}: expected a file name ending in .mcap")
    return path


def _new_file(path: Path) -> BinaryIO:
    """A new file, open for writing. Raises :class:`InvalidInput`."""
    _checked(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        return open(path, "xb")
    except FileExistsError:
        raise InvalidInput(f"{path} exists; choose another name for the log") from None
    except OSError as error:
        raise InvalidInput(f"{path}: the log cannot be written ({error.strerror})") from None


@contextmanager
def _writing(path: Path) -> Iterator[None]:
    """Say in one line that a file can no longer be written."""
    try:
        yield
    except OSError as error:
        raise MobiusError(
            f"{path}: the log can no longer be written ({error.strerror}); what was written"
            " before can be read"
        ) from None
