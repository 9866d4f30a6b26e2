"""The settings of Tables VI and VII on the reconstructed map.

Four groups of 324: all modes on the whole map, and each mode alone on the map without its
forced regions (obstacles stay), as Sec. V-F says. The two printed settings of Table VI's
top half lie outside the grid of Table VII (row 47) and come after it.

epsilon and M are kept as columns, though they do nothing to the repaired problem: cells are
whole numbers, so whether a cell lies in a circle or a rectangle is known beforehand and no
inequality has to be switched (row 41). :func:`switch_settings_matter` checks that claim.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mobius import paper
from mobius.plan import RECONSTRUCTED_WEIGHTS, reconstructed_map
from mobius.plan.maps import CIRCLES
from mobius.sweep.planner import ALL_MODES, PlannerWork
from mobius.sweep.settings import Setting, product_of
from mobius.types import ALL_MODES_BITS, GridMap

__all__ = ["GROUPS", "MAP", "OPEN_MAP", "paper_settings", "paper_work", "switch_settings_matter"]

MAP, OPEN_MAP = "reconstructed map", "reconstructed map, obstacles only"
GROUPS = {ALL_MODES: MAP, "biped": OPEN_MAP, "crawl": OPEN_MAP, "roll": OPEN_MAP}
"""Modes of a group and the map it plans on."""


def paper_work(*, n: int = 20) -> PlannerWork:
    """Both maps of the tables.

    Args:
        n: Cells per side.
    """
    grid = reconstructed_map(n)
    everywhere = np.full(grid.shape, ALL_MODES_BITS, dtype=np.uint8)
    return PlannerWork({MAP: grid, OPEN_MAP: replace(grid, name=OPEN_MAP, allowed=everywhere)})


def paper_settings(
    grid: paper.PlanSweep = paper.TABLE_VII, *, printed: bool = True
) -> list[Setting]:
    """Every setting of the four groups.

    Args:
        grid: Values of the swept parameters; goal weights negative, as printed.
        printed: Add the two settings of Table VI, top.
    """
    swept = {
        "horizon": grid.T,
        "W_exp": grid.W_exp,
        "W_goal": tuple(abs(w) for w in grid.W_goal),
        "epsilon": grid.epsilon,
        "M": grid.M,
    }
    settings = [{**_common(modes), **setting} for modes in GROUPS for setting in product_of(swept)]
    for row in paper.TABLE_VI_MULTI if printed else ():
        settings.append({**_common(ALL_MODES), **setting_of(row)})
    return settings


def setting_of(row: paper.PlanRow) -> Setting:
    """The swept parameters of a printed row; its goal weight as a penalty (row 44)."""
    return {
        "horizon": row.T,
        "W_exp": row.W_exp,
        "W_goal": abs(row.W_goal),
        "epsilon": row.epsilon,
        "M": row.M,
    }


def _common(modes: str) -> Setting:
    P = {f"P_{mode}": value for mode, value in RECONSTRUCTED_WEIGHTS.P.items()}
    return {
        "map": GROUPS[modes],
        "modes": modes,
        "connectivity": "axis",
        "count": "sweep",
        **P,
    }


def switch_settings_matter(grid: GridMap, epsilon: float, M: float) -> bool:
    """Whether (13) (14) with this epsilon and M say anything but "inside or outside".

    For every cell and circle the binary b must be free to be 1 inside and 0 outside, and
    nothing else: d <= r^2 + M (1 - b) and d >= r^2 + epsilon - M b.
    """
    i, j = np.indices(grid.shape)
    for cx, cy, r, _ in CIRCLES:
        d = (i - cx) ** 2 + (j - cy) ** 2
        inside = d <= r**2
        one = (d <= r**2) & (d >= r**2 + epsilon - M)
        zero = (d <= r**2 + M) & (d >= r**2 + epsilon)
        if (one != inside).any() or (zero == inside).any():
            return True
    return False
