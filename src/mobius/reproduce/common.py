"""What the planner's tables share: the sweep itself, which rows count, a table as text."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from statistics import median
from typing import Any

from mobius import paper
from mobius.errors import MobiusError
from mobius.files import write_text_atomic
from mobius.plan import Travel, read_costs
from mobius.sweep import Row
from mobius.sweep.output import as_csv
from mobius.sweep.paper_grids import paper_settings, paper_work

__all__ = ["as_text", "reaches_goal", "run_table", "swept", "typical"]

Cells = list[dict[str, Any]]
"""Rows of a printed table; None is an empty cell."""

GOAL_WITHIN = {"roll": 1}
"""Cells per axis that the last cell may be from the goal, by modes, else 0. A robot that
only rolls moves three cells at a time and reaches one cell in nine; every cell has one of
those beside it."""


def swept(grid: paper.PlanSweep = paper.TABLE_VII) -> list[Row]:
    """Table VII's settings planned here and now, one process."""
    work = paper_work()
    return [{**setting, **work(setting)} for setting in paper_settings(grid)]


def reaches_goal(row: Row) -> bool:
    """Whether a row's plan ends at the goal; what does not is a failure."""
    away = row["goal_cells_away"]
    return away is not None and away <= GOAL_WITHIN.get(row["modes"], 0)


def typical(rows: Sequence[Row], name: str) -> float | None:
    """Median of a column; None where it has no value."""
    values = [row[name] for row in rows if row[name] is not None]
    return median(values) if values else None


def as_text(rows: Cells) -> str:
    """Rows below their names, columns aligned, numbers short."""
    names = list(rows[0])
    table = [names, *([_cell(row[name]) for name in names] for row in rows)]
    widths = [max(len(line[k]) for line in table) for k in range(len(names))]
    text = [k for k, name in enumerate(names) if isinstance(rows[0][name], str)]
    lines = []
    for line in table:
        cells = [c.ljust(w) if k in text else c.rjust(w) for k, (c, w) in _numbered(line, widths)]
        lines.append("  ".join(cells).rstrip())
    return "\n".join(lines)


def run_table(
    name: str,
    describe: str,
    rows_of: Callable[[list[Row]], Cells],
    notes: Sequence[str],
    priced: Callable[[list[Row], Travel], Cells] | None = None,
) -> None:
    """The command line of one table: print it, and write it as CSV where asked.

    Args:
        name: Of the module.
        describe: For ``--help``.
        rows_of: The table from the sweep's rows.
        notes: Printed below it.
        priced: The table from the rows and measured costs; adds the option ``--costs``.
    """
    parser = argparse.ArgumentParser(
        prog=f"python -m mobius.reproduce.{name}", description=describe
    )
    parser.add_argument("--out", type=Path, help="also write the table to this CSV file")
    if priced is not None:
        parser.add_argument(
            "--costs", type=Path, help="measured costs: adds energies at our own prices"
        )
    options = parser.parse_args()
    out = options.out
    try:
        travel = read_costs(options.costs) if priced is not None and options.costs else None
    except MobiusError as error:
        sys.exit(f"{name}: {error}")
    swept_rows = swept()
    rows = rows_of(swept_rows) if priced is None or travel is None else priced(swept_rows, travel)
    print(as_text(rows))
    print("\n".join(notes))
    if out is not None:
        write_out(name, lambda: write_text_atomic(out, as_csv(rows)), out)


def write_out(name: str, write: Callable[[], object], out: Path) -> None:
    """Write, or end with one line that says why not."""
    try:
        write()
    except (OSError, MobiusError) as error:
        sys.exit(f"{name}: {out} cannot be written ({error}); choose another --out")
    print(f"written to {out}")


def _cell(value: Any) -> str:
    if value is None:
        return "-"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _numbered(line: list[str], widths: list[int]) -> list[tuple[int, tuple[str, int]]]:
    return list(enumerate(zip(line, widths, strict=True)))
