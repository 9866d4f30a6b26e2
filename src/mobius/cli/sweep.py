"""``mobius sweep``: many settings of the planner, and the paper's Tables VI and VII."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from tyro.conf import Positional

from mobius.cli.common import Bar, at_least
from mobius.errors import InvalidInput, UnknownName

if TYPE_CHECKING:
    from mobius.sweep import Row, Swept
    from mobius.sweep.grid_file import GridFile
    from mobius.types import GridMap

TABLES = ("table-6", "table-7")


@dataclass
class Sweep:
    """Plan with every combination of some settings; go on after a kill with --resume."""

    what: Positional[str]
    """table-6 or table-7 (the paper's settings on the reconstructed map), or a FILE.yaml of
    lists: map, horizon, modes, connectivity, count, W_exp, W_goal, P_biped, P_crawl, P_roll."""
    out: Path
    """Folder for rows.jsonl (while it runs) and rows.parquet, or rows.csv without pyarrow;
    new or empty."""
    resume: bool = False
    """Go on where the sweep in --out stopped, or begin it; finished rows are not done again."""
    workers: int = 0
    """Processes, >= 0; 0 takes one a CPU. The rows do not depend on it."""
    ray: str | None = None
    """Plan on Ray: local, auto, or the address of a cluster; needs mobius[sweep]."""

    def __call__(self) -> int:
        """Sweep, write and print."""
        at_least("--workers", self.workers, 0)
        self._check_what()
        grid = self._grid()
        try:
            with Bar() as bar:
                swept = self._sweep(grid, bar)
        except KeyboardInterrupt:
            print(
                "mobius: stopped; finished rows are kept: type the same with --resume to go on",
                file=sys.stderr,
            )
            return 130
        self._print(swept)
        return 0

    def _check_what(self) -> None:
        path = Path(self.what)
        if self.what not in TABLES and path.suffix not in (".yaml", ".yml"):
            if path.exists():
                raise InvalidInput(f"{path}: expected table-6, table-7 or a sweep file .yaml")
            raise UnknownName("sweep", self.what, (*TABLES, "FILE.yaml"))

    def _grid(self) -> GridFile:
        from mobius.sweep.grid_file import GridFile, read_grid_file
        from mobius.sweep.paper_grids import paper_settings, paper_work

        if self.what in TABLES:
            return GridFile(paper_settings(), paper_work())
        return read_grid_file(self.what, _open_map)

    def _sweep(self, grid: GridFile, bar: Bar) -> Swept:
        from mobius.sweep import run_sweep

        return run_sweep(
            grid.work,
            grid.settings,
            self.out,
            stamp=grid.work.stamp,
            resume=self.resume,
            workers=self.workers,
            ray=self.ray,
            progress=lambda share: bar(f"{len(grid.settings)} settings", share),
        )

    def _print(self, swept: Swept) -> None:
        if self.what in TABLES:
            _print_table(self.what, swept.rows)
        without = sum(row["status"] == "infeasible" for row in swept.rows)
        total = len(swept.rows)
        before = f", {swept.resumed} of them from before" if swept.resumed else ""
        print(f"{total} settings{before}; {without} without a plan; written to {swept.table}")


def _print_table(name: str, rows: list[Row]) -> None:
    from mobius.reproduce import table_6, table_7
    from mobius.reproduce.common import as_text

    table = table_6 if name == "table-6" else table_7
    print(as_text(table.rows(rows)))
    print("\n".join(table.NOTES))


def _open_map(source: str, **ends: list[float]) -> GridMap:
    """A map as ``mobius plan`` sees it."""
    from mobius import mission

    return mission.open_world(source, start=ends.get("start"), goal=ends.get("goal")).grid
