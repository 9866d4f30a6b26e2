"""The log: one MCAP file per run, whole or absent.

While the run goes on the recorder only serialises (a few microseconds per message) and
keeps the bytes. :meth:`McapRecorder.save` compresses and writes them in a folder of its
own, then moves the finished file into place, so a kill never leaves half a log.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

from mobius.bridge.messages import CLOCK_HZ, TOPICS, due_rows, encode, topic
from mobius.bridge.to_ros import STORE, time_ns
from mobius.errors import InvalidInput
from mobius.files import copy_atomic
from mobius.types import (
    GridMap,
    JointCommand,
    ModeCommand,
    Plan,
    Pose,
    SensorFrame,
    StateEstimate,
)

__all__ = ["McapRecorder"]


class McapRecorder:
    """Collects the messages of one run in memory and saves them as ``run.mcap``.

    Call :meth:`once` with what does not change, :meth:`step` at every tick of the base
    clock or at every tenth, :meth:`save` at the end. About 0.2 MB of memory per simulated
    second.

    Args:
        topics: Which topics of the table to record; by default all that are not only live.
    """

    def __init__(self, *, topics: tuple[str, ...] | None = None) -> None:
        logged = tuple(name for name, row in TOPICS.items() if row.where != "live")
        rows = [topic(name) for name in (logged if topics is None else topics)]
        self._latched = [row for row in rows if row.latched]
        self._due = due_rows(rows)
        self._messages: list[tuple[str, int, bytes | memoryview]] = []

    def __len__(self) -> int:
        """How many messages are held."""
        return len(self._messages)

    def once(
        self,
        *,
        stamp: float = 0.0,
        grid: GridMap | None = None,
        plan: Plan | None = None,
        pose_MO: Pose | None = None,
        description: str | None = None,
    ) -> None:
        """Record what is published once: map, plan, the pose of odom in map, the robot.

        Args:
            stamp: When it was said [s]; a new plan may be recorded later in the run.
            grid: For ``/map``.
            plan: For ``/plan`` and ``/mobius/plan_modes``.
            pose_MO: For ``/tf_static``.
            description: URDF, for ``/robot_description``.
        """
        nouns = {"grid": grid, "plan": plan, "pose_MO": pose_MO, "description": description}
        self._take(self._latched, stamp, nouns)

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
            tick: Count of the 600 Hz base clock.
            frame: What the devices said.
            belief: What the estimator believes, frame odom.
            command: Mode and twist asked for.
            target: What ``robot.write`` let through.
            truth: The simulator's own state, ``p_OB`` and ``q_OB`` holding the pose in map.
        """
        due = self._due[tick % CLOCK_HZ]
        if due:
            stamp = tick / CLOCK_HZ
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
        """Record one noun under one topic of the table at ``stamp`` [s]."""
        data = encode(name, noun)
        if data is not None:
            self._messages.append((name, time_ns(stamp), data))

    def _take(self, rows: Any, stamp: float, nouns: dict[str, Any]) -> None:
        for row in rows:
            noun = nouns[row.noun]
            if noun is not None:
                self.write(row.name, noun, stamp=stamp)

    def save(self, path: str | Path) -> None:
        """Write everything held to ``path``, an MCAP file with zstd chunks.

        Raises:
            InvalidInput: ``path`` does not end in ``.mcap``, or nothing was recorded.
        """
        path = Path(path)
        if path.suffix != ".mcap":
            raise InvalidInput(f"{path}: expected a file name ending in .mcap")
        if not self._messages:
            raise InvalidInput(f"{path}: nothing was recorded; call step() or once() first")
        with tempfile.TemporaryDirectory(prefix="mobius-log-") as folder:
            bag = Path(folder) / "bag"
            self._write_bag(bag)
            copy_atomic(bag / "bag.mcap", path)

    def _write_bag(self, bag: Path) -> None:
        writer = Writer(bag, version=9, storage_plugin=StoragePlugin.MCAP)
        writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
        with writer:
            connections = {
                name: writer.add_connection(
                    name,
                    TOPICS[name].type,
                    typestore=STORE,
                    offered_qos_profiles=[_qos(latched=TOPICS[name].latched)],
                )
                for name in dict.fromkeys(name for name, _, _ in self._messages)
            }
            for name, stamp_ns, data in self._messages:
                writer.write(connections[name], stamp_ns, data)


def _qos(*, latched: bool) -> Qos:
    forever = QosTime(sec=9223372036, nsec=854775807)
    return Qos(
        history=QosHistory.KEEP_LAST,
        depth=1 if latched else 10,
        reliability=QosReliability.RELIABLE,
        durability=QosDurability.TRANSIENT_LOCAL if latched else QosDurability.VOLATILE,
        deadline=forever,
        lifespan=forever,
        liveliness=QosLiveliness.AUTOMATIC,
        liveliness_lease_duration=forever,
        avoid_ros_namespace_conventions=False,
    )
