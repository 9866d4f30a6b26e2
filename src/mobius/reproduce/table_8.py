"""Table VIII: energy per metre of each mode, measured in physics beside the paper's estimate.

``mobius eval energy --out costs.json``, then
``python -m mobius.reproduce.table_8 --costs costs.json [--out FILE.csv]``.

The paper's numbers are kinetic plus potential energy of a moving mass by formula; ours are the
work of all joints in simulation. They need not agree; that is what the table shows.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from mobius import paper
from mobius.errors import MobiusError
from mobius.files import write_text_atomic
from mobius.plan import Travel, read_costs
from mobius.reproduce.common import Cells, as_text, write_out
from mobius.sweep.output import as_csv
from mobius.types import Mode

__all__ = ["CELL", "NOTES", "rows"]

CELL = 0.5
"""Edge of the paper's cells [m]."""
WEIGHT = 10.0 * 9.81
"""Weight of the paper's cost of transport [N]."""
NOTES = (
    "paper: kinetic + potential by formula (Table VIII; roll as its third version corrects it);"
    " J/cell as Table VI prints it.",
    "ours: work of all joints, sum of |torque * rate|, flat ground, at the speed plans are"
    " followed at; J/cell on a straight way over cells of 0.5 m.",
    "cost of transport: J/m over the weight of 10 kg, for both.",
)


def rows(travel: Travel) -> Cells:
    """Paper and ours, a row each per mode that was measured, the paper's alone for others."""
    table: Cells = []
    for mode in (Mode.BIPED, Mode.CRAWL, Mode.ROLL):
        printed = paper.TABLE_VIII_ROLL_V3 if mode is Mode.ROLL else paper.TABLE_VIII[mode]
        cell = paper.TABLE_VI_SINGLE[mode].energy
        table.append(_line(mode, "paper", printed.total, paper.MAX_SPEED[mode], cell))
        if mode in travel.J_per_m:
            each = travel.J_per_m[mode]
            table.append(_line(mode, "ours", each, travel.m_per_s.get(mode), each * CELL))
    for (a, b), joules in travel.switch_J.items():
        table.append(
            {**_line(a, "ours", None, None, None), "mode": f"{a} to {b}",
             "J": joules, "s": travel.switch_s.get((a, b))}
        )  # fmt: skip
    return table


def _line(
    mode: Mode, whose: str, per_m: float | None, speed: float | None, per_cell: float | None
) -> dict[str, Any]:
    return {
        "mode": mode.value,
        "whose": whose,
        "m_per_s": speed,
        "J_per_m": per_m,
        "J_per_cell": per_cell,
        "cost_of_transport": None if per_m is None else per_m / WEIGHT,
        "J": None,
        "s": None,
    }


def main() -> None:
    """Print the table, and write it as CSV where asked."""
    parser = argparse.ArgumentParser(
        prog="python -m mobius.reproduce.table_8",
        description="Table VIII, ours beside the paper's.",
    )
    parser.add_argument(
        "--costs", type=Path, required=True, help="file that `mobius eval energy --out` wrote"
    )
    parser.add_argument("--out", type=Path, help="also write the table to this CSV file")
    options = parser.parse_args()
    try:
        table = rows(read_costs(options.costs))
    except MobiusError as error:
        sys.exit(f"table_8: {error}")
    print(as_text(table))
    print("\n".join(NOTES))
    out = options.out
    if out is not None:
        write_out("table_8", lambda: write_text_atomic(out, as_csv(table)), out)


if __name__ == "__main__":
    main()
