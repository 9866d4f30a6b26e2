"""The finished table of a sweep: Parquet where pyarrow is installed, else CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

from mobius.files import write_bytes_atomic
from mobius.sweep.settings import Row

__all__ = ["as_csv", "write_table"]


def write_table(folder: Path, rows: Sequence[Row]) -> Path:
    """Write ``rows.parquet`` or ``rows.csv`` whole, and return which.

    Args:
        folder: Exists.
        rows: At least one, all with the same names.
    """
    if find_spec("pyarrow") is None:
        path = folder / "rows.csv"
        write_bytes_atomic(path, as_csv(rows).encode())
        return path
    import pyarrow
    import pyarrow.parquet

    path = folder / "rows.parquet"
    sink = io.BytesIO()
    pyarrow.parquet.write_table(pyarrow.Table.from_pylist(list(rows)), sink)
    write_bytes_atomic(path, sink.getbuffer())
    return path


def as_csv(rows: Sequence[Row]) -> str:
    """Rows as comma-separated values below their names; None is an empty cell."""
    out = io.StringIO()
    writer = csv.DictWriter(out, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return out.getvalue()
