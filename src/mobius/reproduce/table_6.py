"""Table VI: the best planner settings, ours beside the paper's.

``python -m mobius.reproduce.table_6 [--costs FILE] [--out FILE.csv]`` plans 4 x 324 + 2
settings on the reconstructed map and prints the table; ``mobius sweep table-6`` does it on
every processor. Measured costs add what our plans take at our own prices.

Energies are those of the planner's price list, which *is* the lower half of the table (J
per visited cell of each mode): with one mode alone ours must equal the paper's wherever a
plan exists. What is ours is where plans exist, how they mix the modes, and the time.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from mobius import paper
from mobius.errors import MapError, PlanError
from mobius.plan import Travel, plan_cost
from mobius.reproduce.common import Cells, reaches_goal, run_table
from mobius.sweep import Row
from mobius.sweep.paper_grids import paper_work, setting_of
from mobius.sweep.planner import ALL_MODES, solved

__all__ = ["NOTES", "best", "failures", "rows"]

NOTES = (
    "ours: reconstructed map (Fig. 12's is not published), mode penalties 2, 1, 4 points (none"
    " are), goal weight a penalty (row 44).",
    "away: larger of both axes between last cell and goal [cells]; a setting whose plan does not"
    " end at the goal fails (roll alone: within one cell).",
    "energy_ours (with --costs): our plan's way at our measured J per metre, cells of 0.5 m, over"
    " the cells it sees after the start; a roll sees one in three.",
    "energy: J per visited cell at Table VI's own price of each mode, so single modes agree by"
    " construction. The 34.91 of all modes lies above the dearest mode's 26.89: no plan that sees"
    " a new cell in every step costs that at these prices.",
)


def rows(swept: Sequence[Row], travel: Travel | None = None) -> Cells:
    """The table: paper, ours at the paper's setting, ours at our best.

    Args:
        swept: Rows of the settings of :mod:`mobius.sweep.paper_grids`, all or some.
        travel: Measured costs; with them a column of our plans' energies at these prices.
    """
    table: Cells = []
    several = [row for row in swept if row["modes"] == ALL_MODES]
    for printed in paper.TABLE_VI_MULTI:
        table.append(_printed("all", printed))
        table += _at_printed("all", printed, several)
    fixed = [row for row in several if row["horizon"] == paper.MAP_HORIZON and _in_grid(row)]
    for place, row in zip(("best", "second"), best(fixed, 2), strict=False):
        table.append(_ours("all", f"ours, {place} at T = {paper.MAP_HORIZON}", row, fixed))
    for mode, printed in paper.TABLE_VI_SINGLE.items():
        alone = [row for row in swept if row["modes"] == mode]
        table.append(_printed(mode, printed))
        table += _at_printed(mode, printed, alone)
        table += [_ours(mode, "ours, best", row, alone) for row in best(alone, 1)]
    own = [line.pop("row", None) for line in table]
    if travel is not None:
        for line, row in zip(table, own, strict=True):
            line["energy_ours"] = None if row is None else measured_energy(row, travel)
    return table


def measured_energy(row: Row, travel: Travel) -> float | None:
    """J per visited cell of a row's plan at measured J per metre; None where a mode lacks one."""
    grid = paper_work().maps[row["map"]]
    try:
        problem, plan = solved(row, grid)
    except (PlanError, MapError):
        return None
    if not set(plan.modes) <= set(travel.J_per_m):
        return None
    metres = grid.cell * np.abs(np.diff(plan.cells, axis=0)).sum(axis=1)
    joules = sum(travel.joules(m, float(d)) for m, d in zip(plan.modes, metres, strict=True))
    seen = plan_cost(problem, plan).cells_seen - 1  # without the start
    return joules / seen if seen else None


def best(swept: Sequence[Row], count: int) -> list[Row]:
    """Rows of least energy per visited cell among those that end at the goal.

    Equal energy: more cells seen, then the shorter horizon, then the order of the settings.
    Settings that differ in epsilon or M only are one (the first).
    """
    good = [row for row in swept if reaches_goal(row)]
    good.sort(key=lambda r: (round(r["energy_per_cell_J"], 6), -r["cells_seen"], r["horizon"]))
    distinct: dict[tuple[Any, ...], Row] = {}
    for row in good:
        distinct.setdefault((row["horizon"], row["W_exp"], row["W_goal"]), row)
    return list(distinct.values())[:count]


def failures(swept: Sequence[Row]) -> int:
    """Settings without a plan that ends at the goal."""
    return sum(not reaches_goal(row) for row in swept)


def _in_grid(row: Row) -> bool:
    """Whether the setting is one of Table VII, not one of the two printed ones."""
    return row["W_exp"] in paper.TABLE_VII.W_exp


def _printed(modes: str, row: paper.PlanRow) -> dict[str, Any]:
    failed = None if row.failures is None else f"{row.failures}/{paper.PLAN_COMBINATIONS}"
    return _line(modes, "paper", setting_of(row), row.seconds, row.switch_rate, row.energy, failed)


def _at_printed(modes: str, printed: paper.PlanRow, swept: Sequence[Row]) -> Cells:
    """Ours at a printed setting, if it was swept."""
    want = setting_of(printed)
    found = [row for row in swept if all(row[name] == value for name, value in want.items())]
    return [_ours(modes, "ours, same setting", row, None) for row in found[:1]]


def _ours(modes: str, who: str, row: Row, swept: Sequence[Row] | None) -> dict[str, Any]:
    failed = None if swept is None else f"{failures(swept)}/{len(swept)}"
    setting = {name: row[name] for name in ("horizon", "W_exp", "W_goal", "epsilon", "M")}
    figures = (row["solve_s"], row["mode_switch_rate"], row["energy_per_cell_J"])
    line = _line(modes, who, setting, *figures, failed)
    return {**line, "away": row["goal_cells_away"], "row": row}


def _line(
    modes: str,
    who: str,
    setting: dict[str, Any],
    seconds: float | None,
    switches: float | None,
    energy: float | None,
    failed: str | None,
) -> dict[str, Any]:
    return {
        "mode": modes,
        "whose": who,
        "W_exp": setting["W_exp"],
        "W_goal": setting["W_goal"],
        "epsilon": setting["epsilon"],
        "M": setting["M"],
        "T": setting["horizon"],
        "seconds": seconds,
        "switch_rate": switches,
        "energy": energy,
        "failed": failed,
        "away": None,
    }


if __name__ == "__main__":
    run_table("table_6", "Table VI, ours beside the paper's.", rows, NOTES, rows)
