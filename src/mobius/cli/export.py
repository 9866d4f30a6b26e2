"""``mobius export``: a recorded run in another form."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tyro.conf import Positional


@dataclass
class Export:
    """Write a recorded run as one table, or make a cut-off log whole.

    Foxglove, Rerun and ros2 bag open the log as it is (docs/logs.md).
    """

    run: Positional[Path]
    """Folder of a run, or a .mcap log."""
    to: str = "csv"
    """csv or parquet: a row a sample, the unit in each column's name; mcap: the log with a new
    index, for readers that do not open one that was cut off."""
    out: Path | None = None
    """File to write, new; beside the run and named after it if left out."""

    def __call__(self) -> int:
        """Write and say where."""
        from mobius.bridge.export import export

        print(export(self.run, self.to, self.out))
        return 0
