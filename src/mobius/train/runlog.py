"""The record of a training run: a JSON line an iteration, and the same for TensorBoard.

``progress.jsonl`` is the truth. TensorBoard's files are made from it, anew whenever a run is
resumed, so neither holds a step twice or lacks one.
"""

from __future__ import annotations

import json
import os
import time
from pathlib import Path
from typing import Any

from torch.utils.tensorboard import SummaryWriter

from mobius.errors import InvalidInput
from mobius.files import write_text_atomic

LINES = "progress.jsonl"


def read_rows(folder: Path) -> list[dict[str, float]]:
    """All whole lines of the run in ``folder``; a kill may have cut off the last."""
    path = folder / LINES
    if not path.is_file():
        return []
    rows: list[dict[str, float]] = []
    for line in path.read_text().splitlines():
        try:
            rows.append(json.loads(line))
        except ValueError:
            break
    return rows


class RunLog:
    """Appends rows of figures; every row has ``steps`` and ``wall_s``."""

    def __init__(self, folder: Path, *, steps: int = 0, batch: int = 1) -> None:
        """Keep the rows up to ``steps`` environment steps, ``batch`` a row; drop the rest.

        Raises:
            InvalidInput: a row up to ``steps`` is missing.
        """
        rows = [row for row in read_rows(folder) if row["steps"] <= steps]
        if [int(row["steps"]) for row in rows] != list(range(batch, steps + 1, batch)):
            raise InvalidInput(
                f"{folder / LINES}: expected a line for every {batch} steps up to {steps}, got"
                f" {len(rows)}; restore the file or begin anew in another --out"
            )
        for old in folder.glob("events.out.tfevents.*"):
            old.unlink()
        write_text_atomic(folder / LINES, "".join(json.dumps(row) + "\n" for row in rows))
        self._lines = (folder / LINES).open("a")
        self._board = SummaryWriter(str(folder))
        self._begun = time.time() - (rows[-1]["wall_s"] if rows else 0.0)
        for row in rows:
            self._show(row)

    def add(self, figures: dict[str, float]) -> None:
        """Append a row."""
        row = {k: v if isinstance(v, int) else float(f"{v:.7g}") for k, v in figures.items()}
        self._lines.write(json.dumps(row) + "\n")
        self._lines.flush()
        self._show(row)

    def sync(self) -> None:
        """Put all rows on the disk; comes before the checkpoint that counts on them."""
        os.fsync(self._lines.fileno())
        self._board.flush()

    def __enter__(self) -> RunLog:
        return self

    def __exit__(self, *_: Any) -> None:
        self._lines.close()
        self._board.close()

    def _show(self, row: dict[str, float]) -> None:
        for key, value in row.items():
            self._board.add_scalar(key, value, int(row["steps"]), self._begun + row["wall_s"])
