"""Table VII: what each swept parameter does.

``python -m mobius.reproduce.table_7 [--out FILE.csv]``. The paper prints the tested values
and no result for them; ours says for every value how many settings fail and what the rest
is like, and in ``changes`` how often another value of the parameter, all else equal, gives
another plan.

epsilon and M change nothing: on whole cells the inequalities they belong to only say inside
or outside, for every tested pair. So 324 settings are 36 problems, and every count of
failures is a multiple of 9; 160 of Table VI is none. In floating point they do act: a
binary that may be off by 1e-5 lets M b be 0.01 to 0.16, epsilon is 1e-4 to 1e-2.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import Any

from mobius.reproduce.common import Cells, reaches_goal, run_table, typical
from mobius.reproduce.table_6 import failures
from mobius.sweep import Row
from mobius.sweep.paper_grids import GROUPS
from mobius.sweep.planner import ALL_MODES

__all__ = ["NOTES", "changes", "rows"]

PARAMETERS = {"W_exp": "W_exp", "W_goal": "W_goal", "epsilon": "epsilon", "M": "M", "horizon": "T"}
"""Column of a sweep and the name in the table."""
RESULTS = ("status", "goal_cells_away", "mode_switches", "cells_seen", "energy_J")
"""What two equal plans have in common; the objective follows from plan and weights."""
NOTES = (
    "reconstructed map; failed: settings whose plan does not end at the goal, of all with this"
    " value.",
    "energy, switch_rate, seconds: medians over the settings of all modes that do not fail.",
    "changes: share of settings (all groups) whose result differs from that with the parameter's"
    " first value; epsilon and M do nothing to whole cells.",
)


def rows(swept: Sequence[Row]) -> Cells:
    """A line per parameter and value.

    Args:
        swept: Rows of the settings of :mod:`mobius.sweep.paper_grids`, all or some; the two
            settings outside Table VII's product must be left out or are left out here.
    """
    swept = _product_only(swept)
    table: Cells = []
    for column, name in PARAMETERS.items():
        for value in dict.fromkeys(row[column] for row in swept):
            here = [row for row in swept if row[column] == value]
            table.append(_line(name, value, here, changes(swept, column, value)))
    return table


def changes(swept: Sequence[Row], column: str, value: Any) -> float:
    """Share of the settings whose result differs from that with the first value of a column."""
    alike: dict[tuple[Any, ...], dict[Any, tuple[Any, ...]]] = defaultdict(dict)
    for row in swept:
        rest = (row["modes"], *(row[other] for other in PARAMETERS if other != column))
        alike[rest][row[column]] = tuple(row[name] for name in RESULTS)
    pairs = [(next(iter(found.values())), found[value]) for found in alike.values()]
    return sum(a != b for a, b in pairs) / len(pairs)


def _line(name: str, value: Any, here: Sequence[Row], changed: float) -> dict[str, Any]:
    line: dict[str, Any] = {"parameter": name, "value": value}
    for modes in GROUPS:
        group = [row for row in here if row["modes"] == modes]
        short = "all" if modes == ALL_MODES else modes
        line[f"{short} failed"] = f"{failures(group)}/{len(group)}"
    good = [row for row in here if row["modes"] == ALL_MODES and reaches_goal(row)]
    line["energy"] = typical(good, "energy_per_cell_J")
    line["switch_rate"] = typical(good, "mode_switch_rate")
    line["seconds"] = typical(good, "solve_s")
    line["changes"] = round(changed, 3)
    return line


def _product_only(swept: Sequence[Row]) -> list[Row]:
    """Without the settings whose weights appear in the group of all modes alone."""
    single = {row["W_exp"] for row in swept if row["modes"] != ALL_MODES}
    return [row for row in swept if row["W_exp"] in single]


if __name__ == "__main__":
    run_table("table_7", "Table VII, what each parameter does.", rows, NOTES)
