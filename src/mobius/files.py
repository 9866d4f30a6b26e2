"""Files that are whole or absent: written beside their place, synced, then moved into it.

A kill at any moment leaves the old file, the new file or no file under the name asked
for, never half of one. Standing below all rooms so that every room may write this way.
"""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, BinaryIO

from mobius.errors import InvalidInput

__all__ = ["copy_atomic", "write_bytes_atomic", "write_json_atomic", "write_text_atomic"]


def write_bytes_atomic(path: str | Path, data: bytes | memoryview) -> None:
    """Write ``data`` to ``path``; folders that lack are made."""
    _replace(Path(path), lambda file: file.write(data))


def write_text_atomic(path: str | Path, text: str) -> None:
    """Write ``text`` to ``path`` as UTF-8."""
    write_bytes_atomic(path, text.encode())


def write_json_atomic(path: str | Path, value: Any) -> None:
    """Write ``value`` to ``path`` as indented JSON.

    Raises:
        InvalidInput: ``value`` holds what JSON cannot (an array, NaN, an object).
    """
    try:
        text = json.dumps(value, indent=2, allow_nan=False) + "\n"
    except (TypeError, ValueError) as error:
        raise InvalidInput(
            f"{path}: expected plain finite JSON values, got something else ({error});"
            " convert arrays with .tolist() and drop NaN"
        ) from None
    write_text_atomic(path, text)


def copy_atomic(source: str | Path, path: str | Path) -> None:
    """Copy a finished file to ``path``, from any file system."""
    with open(source, "rb") as whole:
        _replace(Path(path), lambda file: shutil.copyfileobj(whole, file))


def _replace(path: Path, write: Callable[[BinaryIO], object]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.", suffix=".tmp")
    try:
        with os.fdopen(handle, "wb") as file:
            write(file)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(name, 0o666 & ~_umask())
        os.replace(name, path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
