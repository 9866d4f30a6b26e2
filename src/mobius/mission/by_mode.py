"""A run taken apart by the mode the robot was really in."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mobius.mission.body import DRIVABLE
from mobius.robot import TICK
from mobius.stack import ACT_EVERY, RunRecord
from mobius.types import Mode, Plan

DT = ACT_EVERY * TICK
"""Time between two rows of a record [s]."""
USED = 0.5
"""A forced mode counts as used from this share of the time in its cells, motions between bodies
left out."""


def by_mode(record: RunRecord) -> dict[str, dict[str, Any]]:
    """Time, way, energy and cells of each mode, in the order in which they came.

    Returns:
        Per mode ``time_s``, ``path_m``, ``energy_J``, ``cells`` (first entered in this mode),
        ``J_per_m`` and ``J_per_cell`` (None where there is no way, no cell). Path and energy
        are those of the rows in the mode.
    """
    modes = np.array(record.modes)
    way = np.linalg.norm(
        np.diff(record.true_p[:, :2], axis=0, prepend=record.true_p[:1, :2]), axis=1
    )
    first = first_visits(record)
    table: dict[str, dict[str, Any]] = {}
    for name in dict.fromkeys(record.modes):
        rows = modes == name
        energy, path = float(record.power[rows].sum() * DT), float(way[rows].sum())
        cells = int(first[rows].sum())
        table[name] = {
            "time_s": float(rows.sum() * DT),
            "path_m": path,
            "energy_J": energy,
            "cells": cells,
            "J_per_m": energy / path if path > 0.1 else None,
            "J_per_cell": energy / cells if cells else None,
        }
    return table


def first_visits(record: RunRecord) -> NDArray[np.bool_]:
    """(n,) rows in which the trunk is in its cell for the first time."""
    cells = record.grid.cell_of(record.true_p[:, :2])
    _, at = np.unique(cells, axis=0, return_index=True)
    first = np.zeros(len(cells), dtype=bool)
    first[at] = True
    return first


def cells_of(plan: Plan) -> NDArray[np.int64]:
    """(k, 2) cells that a plan of straight steps crosses or lands on, from the start on."""
    cells = [plan.cells[:1]]
    for a, b in zip(plan.cells[:-1], plan.cells[1:], strict=True):
        count = int(np.abs(b - a).max())
        shares = np.arange(1, count + 1)[:, None] / max(count, 1)
        cells.append(np.rint(a + shares * (b - a)).astype(np.int64))
    return np.concatenate(cells)


def forced_modes(record: RunRecord) -> dict[str, dict[str, Any]]:
    """What became of the modes that cells of the plan, or cells the robot was in, force.

    Returns:
        Per forced mode ``planned`` (cells that the plan crosses or lands on and that force it),
        ``time_s`` in such cells while crawling, walking or rolling, ``share`` of it in the right
        mode, and ``used``.
    """
    grid, table = record.grid, dict[str, dict[str, Any]]()
    cells = np.clip(grid.cell_of(record.true_p[:, :2]), 0, np.array(grid.shape) - 1)
    here = grid.allowed[cells[:, 0], cells[:, 1]]
    modes = np.array(record.modes)
    moving = np.isin(modes, [m.value for m in DRIVABLE])
    way = cells_of(record.plan)
    planned = grid.allowed[way[:, 0], way[:, 1]]
    for mode in DRIVABLE:
        inside = (here == mode.bit) & moving
        count = int((planned == mode.bit).sum())
        if not count and not inside.any():
            continue
        right = inside & (modes == mode.value)
        share = float(right.sum() / inside.sum()) if inside.any() else 0.0
        # between rolls the robot crawls what a roll falls short: some of the time is enough
        used = share >= USED if mode is not Mode.ROLL else share > 0
        table[mode.value] = {
            "planned": count,
            "time_s": float(inside.sum() * DT),
            "share": share,
            "used": bool(used),
        }
    return table
