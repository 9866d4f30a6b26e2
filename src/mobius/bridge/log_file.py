"""A MCAP file as it grows: one chunk each half second, on the disk as soon as it is full.

Whatever ends the program, all chunks before the last are whole, and each message stands
behind the schema and channel it needs: a file cut off anywhere reads up to the last chunk.
Only the index at the end is missing then, which readers can do without (docs/logs.md).

The bytes reach the operating system, which survives ``kill -9``; no ``fsync`` holds up the
loop, so a power cut may take what the system had not written yet.
"""

from __future__ import annotations

import time
from functools import cache
from importlib.metadata import version
from typing import BinaryIO

from mcap.writer import CompressionType, Writer

from mobius.bridge.about import RECORD, SCENE, About
from mobius.bridge.messages import topic
from mobius.bridge.to_ros import STORE

__all__ = ["FLUSH_EVERY", "LogFile"]

FLUSH_EVERY = 0.5
"""At most so much of a run, and of a live run's wall time, is in memory only [s]."""

_FOREVER = "{sec: 9223372036, nsec: 854775807}"
_QOS = """\
- history: keep_last
  depth: {depth}
  reliability: reliable
  durability: {durability}
  deadline: {forever}
  lifespan: {forever}
  liveliness: automatic
  liveliness_lease_duration: {forever}
  avoid_ros_namespace_conventions: false
"""


@cache
def _schema(kind: str) -> tuple[bytes, str]:
    """Message definition and RIHS01 hash of a ROS type."""
    return STORE.generate_msgdef(kind, ros_version=2)[0].encode(), STORE.hash_rihs01(kind)


def qos(*, latched: bool) -> str:
    """Offered quality of service as rosbag2 (metadata version 9) writes it beside a topic."""
    return _QOS.format(
        depth=1 if latched else 10,
        durability="transient_local" if latched else "volatile",
        forever=_FOREVER,
    )


class LogFile:
    """Writes messages of the table's topics into a stream."""

    def __init__(self, stream: BinaryIO, *, about: About | None = None, live: bool = True) -> None:
        """Write the head of a log.

        Args:
            stream: Where to; the caller closes it.
            about: What is recorded.
            live: Whether wall time, too, ends a chunk; without, the same messages give the
                same bytes.
        """
        self._live = live
        self._writer = Writer(stream, compression=CompressionType.ZSTD)
        self._writer.start(profile="ros2", library=f"mobius {version('mobius')}")
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._chunk_ns: int | None = None
        self._chunk_wall = 0.0
        if about is not None:
            if about.scene:
                self._writer.add_attachment(0, 0, SCENE, "application/gzip", about.packed_scene())
            self._writer.add_metadata(RECORD, about.as_record())
        self.flush()

    def write(self, name: str, stamp_ns: int, data: bytes | memoryview) -> None:
        """Add CDR bytes under a topic of the table at a time [ns]."""
        if self._chunk_ns is None:
            self._chunk_ns, self._chunk_wall = stamp_ns, time.monotonic()
        elif self._is_due(stamp_ns):
            self.flush()
            self._chunk_ns, self._chunk_wall = stamp_ns, time.monotonic()
        channel = self._channels.get(name) or self._add_channel(name)
        self._writer.add_message(channel, stamp_ns, bytes(data), stamp_ns)

    def flush(self) -> None:
        """End the chunk and hand all bytes to the operating system."""
        self._writer.flush()

    def finish(self) -> None:
        """Write index and footer; the file is complete."""
        self._writer.finish()

    def _is_due(self, stamp_ns: int) -> bool:
        assert self._chunk_ns is not None
        if abs(stamp_ns - self._chunk_ns) >= FLUSH_EVERY * 1e9:
            return True
        return self._live and time.monotonic() - self._chunk_wall >= FLUSH_EVERY

    def _add_channel(self, name: str) -> int:
        row = topic(name)
        definition, digest = _schema(row.type)
        if row.type not in self._schemas:
            self._schemas[row.type] = self._writer.register_schema(row.type, "ros2msg", definition)
        told = {"offered_qos_profiles": qos(latched=row.latched), "topic_type_hash": digest}
        self._channels[name] = self._writer.register_channel(
            name, "cdr", self._schemas[row.type], told
        )
        return self._channels[name]
