"""Settings in, rows out: in their order, each exactly once, whatever happens in between."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from importlib.metadata import version
from pathlib import Path

from mobius.errors import InvalidInput
from mobius.sweep.on_ray import RowsOf, connected
from mobius.sweep.output import write_table
from mobius.sweep.parts import PartFile
from mobius.sweep.settings import Row, Setting
from mobius.sweep.workers import Work, rows_here

__all__ = ["PART", "Progress", "Swept", "run_sweep"]

Progress = Callable[[float], None]
"""Called with the share of the settings that is done (0 to 1)."""
PART = "rows.jsonl"
"""Finished rows, in the order of their completion."""


@dataclass(frozen=True)
class Swept:
    """A finished sweep."""

    rows: list[Row]
    """Setting and result of every setting, in the order of the settings."""
    table: Path
    """The same as Parquet or CSV."""
    resumed: int
    """Rows that an earlier run had finished."""


def run_sweep(
    work: Work,
    settings: Sequence[Setting],
    folder: str | Path,
    *,
    stamp: str = "",
    resume: bool = False,
    workers: int = 0,
    ray: str | None = None,
    progress: Progress | None = None,
) -> Swept:
    """Do ``work`` on every setting.

    Every finished row is synced to ``folder/rows.jsonl`` before the next; when all are done
    the table is written whole. Killed at any point, the same call with ``resume`` does the
    rest.

    Args:
        work: Pure: the same setting gives the same row (apart from times it measures).
        settings: At least one.
        folder: New or empty; with ``resume`` that of the sweep to go on with.
        stamp: Whatever else the rows depend on, e.g. a digest of the map.
        resume: Go on where the sweep in ``folder`` stopped, or begin it.
        workers: Processes, >= 0; 0 takes one a CPU.
        ray: Address of a Ray cluster, or ``local``; None takes processes of this machine.
        progress: Called after every row.

    Raises:
        InvalidInput: No settings; the folder holds something else.
    """
    folder = Path(folder)
    if not settings:
        raise InvalidInput("a sweep needs at least one setting")
    _check_folder(folder, resume=resume)
    with ExitStack() as held:
        rows_of: RowsOf = partial(rows_here, workers=workers)
        if ray is not None:  # before anything is written
            rows_of = held.enter_context(connected(ray, workers=workers))
        part = held.enter_context(_part_file(folder, _stamp(settings, stamp)))
        resumed = len(part.rows)
        jobs = [(n, s) for n, s in enumerate(settings) if n not in part.rows]
        tell = progress or (lambda share: None)
        tell(resumed / len(settings))
        for number, row in rows_of(work, jobs):
            part.append(number, row)
            tell(len(part.rows) / len(settings))
        rows = [{**setting, **part.rows[n]} for n, setting in enumerate(settings)]
        return Swept(rows, write_table(folder, rows), resumed)


def _part_file(folder: Path, stamp: str) -> PartFile:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        return PartFile(folder / PART, stamp)
    except OSError as error:
        raise InvalidInput(
            f"{folder} cannot be written ({error.strerror}); choose another --out"
        ) from None


def _check_folder(folder: Path, *, resume: bool) -> None:
    if not folder.exists():
        return
    held = {p.name for p in folder.iterdir()} if folder.is_dir() else {folder.name}
    if not held:
        return
    if PART not in held:
        raise InvalidInput(f"{folder} exists and is not empty; choose another --out")
    if not resume:
        raise InvalidInput(
            f"{folder} holds a sweep; add --resume to go on with it, or choose another --out"
        )


def _stamp(settings: Sequence[Setting], more: str) -> str:
    """One name for settings, version and whatever else the rows depend on."""
    text = json.dumps([version("mobius"), more, list(settings)], sort_keys=True, allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()[:16]
