"""A MCAP log as far as it reads: messages by topic, what it is about, and where it breaks off.

The file is read from its head, record by record, so that a log without an index (still being
written, or its writer killed) gives all that reached the disk.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any, cast

from mcap.exceptions import EndOfFile, McapError
from mcap.records import Attachment, Channel, Chunk, DataEnd, McapRecord, Message, Metadata, Schema
from mcap.stream_reader import StreamReader, breakup_chunk

from mobius.bridge.about import FORMAT, RECORD, SCENE, About
from mobius.bridge.messages import HEARD, TOPICS
from mobius.bridge.to_ros import STORE
from mobius.errors import InvalidInput, did_you_mean

__all__ = ["Log", "find_log", "read_log"]

_MAGIC = b"\x89MCAP0\r\n"
_OTHERS = {(heard.name, heard.type) for heard in HEARD}
"""Topics and types that others say to the robot."""
_CUT = "cut off, or still being written"


@dataclass(eq=False)
class Log:
    """What a file holds of the topics we know."""

    path: Path
    messages: dict[str, list[tuple[float, bytes]]] = field(default_factory=dict)
    """Per topic of the table (log time [s], CDR bytes), in the order of time."""
    counts: dict[str, int] = field(default_factory=dict)
    """Messages of every topic, those of others' too."""
    about: About = field(default_factory=About)
    problem: str = ""
    """Why the file was not read to its end; empty if it was."""
    remarks: list[str] = field(default_factory=list)
    """What else is wrong with it."""

    @property
    def end(self) -> float:
        """Time of the last message read [s]; 0 without any."""
        return max((rows[-1][0] for rows in self.messages.values() if rows), default=0.0)

    def series(
        self, name: str, codec: Callable[[Any], Any] | None = None
    ) -> tuple[list[float], list[Any]]:
        """Times [s] and what a topic said then, by ``codec``, else by the table's ``from_ros``.

        Raises:
            InvalidInput: A message cannot be understood, e.g. has other joints.
        """
        rows = self.messages.get(name, [])
        try:
            kind, codec = TOPICS[name].type, codec or TOPICS[name].from_ros
            said = [codec(STORE.deserialize_cdr(data, kind)) for _, data in rows]
            return [t for t, _ in rows], said
        except InvalidInput as error:
            raise InvalidInput(f"{self.path}: {name}: {error}") from None
        except (ValueError, TypeError, LookupError, AttributeError, struct.error) as error:
            raise InvalidInput(
                f"{self.path}: {name}: expected {TOPICS[name].type} in CDR, got bytes that do not"
                f" read as that ({error})"
            ) from None


def find_log(path: str | Path) -> Path:
    """The log that a path means: a ``.mcap`` file, or the one in the folder of a run.

    Raises:
        InvalidInput: There is none, or there are several.
    """
    path = Path(path)
    try:
        return _found(path)
    except OSError as error:  # a name that is too long, a folder that may not be looked into
        raise InvalidInput(f"{path}: the log cannot be read ({error.strerror})") from None


def _found(path: Path) -> Path:
    if path.is_file():
        return path
    if not path.exists():
        beside = [p.name for p in path.parent.iterdir()] if path.parent.is_dir() else []
        hint = did_you_mean(path.name, beside)
        raise InvalidInput(f"{path}: there is no such run folder or log.{hint}")
    if not path.is_dir():
        raise InvalidInput(f"{path}: expected the folder of a run or a .mcap file")
    logs = sorted(path.glob("*.mcap"))
    named = [log for log in logs if log.name == "run.mcap"]
    if len(named or logs) == 1:
        return (named or logs)[0]
    if logs:
        raise InvalidInput(
            f"{path} holds several logs; name one of {', '.join(log.name for log in logs)}"
        )
    raise InvalidInput(
        f"{path}: expected the folder of a run, with run.mcap in it; mobius run makes one"
    )


def read_log(path: str | Path) -> Log:
    """Everything readable in a log.

    Args:
        path: A ``.mcap`` file, or the folder of a run.

    Raises:
        InvalidInput: There is no log, it is none, or nothing in it can be read.
    """
    log = Log(find_log(path))
    try:
        with open(log.path, "rb") as file:
            size = file.seek(0, 2)
            file.seek(0)
            magic = file.read(len(_MAGIC))
            file.seek(0)
            if not size:
                raise InvalidInput(f"{log.path} is empty; nothing was recorded")
            if magic != _MAGIC[: len(magic)]:
                raise InvalidInput(f"{log.path} is no log: expected a MCAP file (run.mcap)")
            _Filling(log).take(_records(file, size, log))
    except OSError as error:
        raise InvalidInput(f"{log.path}: the log cannot be read ({error.strerror})") from None
    for rows in log.messages.values():
        rows.sort(key=lambda row: row[0])
    return log


class _Whole:
    """A stream that gives all the bytes asked for, or says that the file has ended.

    MCAP's reader takes what there is. It also asks for as many bytes as a damaged length says.
    """

    def __init__(self, file: IO[bytes], size: int) -> None:
        self._file, self._left = file, size

    def read(self, size: int) -> bytes:
        self._left -= size
        data = self._file.read(size) if self._left >= 0 else b""
        if len(data) < size:
            raise EndOfFile()
        return data


def _records(file: IO[bytes], size: int, log: Log) -> Iterator[McapRecord]:
    """Records in the order of the file, chunks taken apart; says in the log where it breaks."""
    said_all = False
    stream = cast(Any, _Whole(file, size))
    reader = StreamReader(stream, emit_chunks=True, record_size_limit=None)
    try:
        for record in reader.records:
            said_all = said_all or isinstance(record, DataEnd)
            if isinstance(record, Chunk):
                yield from breakup_chunk(record, validate_crc=True)
            elif not said_all:  # what follows is the index, which repeats
                yield record
    except EndOfFile:
        log.problem = "its index is cut off; every message is there" if said_all else _CUT
    except InvalidInput:
        raise
    except Exception as error:  # whatever broken bytes make MCAP's readers and unpackers say
        reason = str(error) if isinstance(error, McapError | ValueError) else type(error).__name__
        log.problem = f"damaged before byte {file.tell()} ({reason})"


class _Filling:
    """Sorts records into a log."""

    def __init__(self, log: Log) -> None:
        self._log = log
        self._schemas: dict[int, str] = {}
        self._channels: dict[int, str | None] = {}  # None: not of the table
        self._topics: dict[int, str] = {}
        self._record: dict[str, str] = {}
        self._scene = b""

    def take(self, records: Iterator[McapRecord]) -> None:
        for record in records:
            if isinstance(record, Message):
                self._message(record)
            elif isinstance(record, Schema):
                self._schemas[record.id] = record.name
            elif isinstance(record, Channel):
                self._channel(record)
            elif isinstance(record, Metadata) and record.name == RECORD:
                self._record = record.metadata
            elif isinstance(record, Attachment) and record.name == SCENE:
                self._scene = record.data
        try:
            self._log.about = About.from_record(self._record, self._scene)
        except InvalidInput as error:
            if self._record.get("format", FORMAT) != FORMAT:
                raise InvalidInput(f"{self._log.path}: {error}") from None
            self._log.remarks.append(str(error))

    def _channel(self, channel: Channel) -> None:
        self._topics[channel.id] = channel.topic
        row = TOPICS.get(channel.topic)
        kind = self._schemas.get(channel.schema_id, "")
        if row is not None and kind != row.type and (row.name, kind) in _OTHERS:
            row = None  # said by somebody else, as /cmd_vel in a bag of ros2 bag record
        if row is not None and (kind != row.type or channel.message_encoding != "cdr"):
            raise InvalidInput(
                f"{self._log.path}: {channel.topic}: expected {row.type} in cdr, got"
                f" {kind or 'no type'} in {channel.message_encoding or 'no encoding'}"
            )
        self._channels[channel.id] = None if row is None else channel.topic
        self._log.counts.setdefault(channel.topic, 0)

    def _message(self, message: Message) -> None:
        topic = self._topics.get(message.channel_id)
        if topic is None:
            raise InvalidInput(f"{self._log.path}: a message belongs to no topic; damaged log")
        self._log.counts[topic] += 1
        if self._channels[message.channel_id] is not None:
            rows = self._log.messages.setdefault(topic, [])
            rows.append((1e-9 * message.log_time, message.data))
