"""Finished rows on disk, a line each, synced before the next: a kill loses none of them.

The first line says which sweep it is. A kill in the middle of a write leaves a last line
without its end; it is cut off when the sweep goes on.
"""

from __future__ import annotations

import fcntl
import json
import os
from pathlib import Path
from types import TracebackType

from mobius.errors import InvalidInput
from mobius.sweep.settings import Row

__all__ = ["PartFile"]


class PartFile:
    """The rows of one sweep by the number of their setting; one process may hold it."""

    def __init__(self, path: Path, stamp: str) -> None:
        """Open a part file, or begin one.

        Args:
            path: In a folder that exists.
            stamp: Names settings and work; rows of another stamp are refused.

        Raises:
            InvalidInput: The file is of another sweep, damaged, or held by another process.
        """
        self.path = path
        self.rows: dict[int, Row] = {}
        self._file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o666)
        try:
            self._lock()
            self._read(stamp)
        except BaseException:
            os.close(self._file)
            raise

    def __enter__(self) -> PartFile:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        os.close(self._file)

    def append(self, number: int, row: Row) -> None:
        """Keep the row of setting ``number``; on disk when this returns."""
        self._write({"n": number, "row": row})
        self.rows[number] = row

    def _lock(self) -> None:
        """Not inherited by the workers and gone with this process, however it ends."""
        try:
            fcntl.lockf(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise InvalidInput(
                f"{self.path}: another sweep is writing here; wait for it or choose another --out"
            ) from None

    def _read(self, stamp: str) -> None:
        data = self._whole()
        whole = data.rfind(b"\n") + 1
        if whole < len(data):
            os.ftruncate(self._file, whole)
        lines = data[:whole].splitlines()
        if not lines:
            self._write({"sweep": stamp})
            return
        try:
            found = json.loads(lines[0])["sweep"]
            rows = [json.loads(line) for line in lines[1:]]
            self.rows = {int(entry["n"]): entry["row"] for entry in rows}
        except (ValueError, KeyError, TypeError):
            raise InvalidInput(
                f"{self.path} is damaged before its last line; choose another --out"
            ) from None
        if found != stamp:
            raise InvalidInput(
                f"{self.path} holds another sweep (other settings, map or version of mobius);"
                " choose another --out"
            )

    def _whole(self) -> bytes:
        """Through the one open handle: closing a second one would give up the lock."""
        pieces = []
        while piece := os.read(self._file, 1 << 20):
            pieces.append(piece)
        return b"".join(pieces)

    def _write(self, entry: Row) -> None:
        line = json.dumps(entry, allow_nan=False).encode() + b"\n"
        while line:
            line = line[os.write(self._file, line) :]
        os.fsync(self._file)
