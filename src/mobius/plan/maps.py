"""The planner's yardstick: a reconstruction of the kind of map the paper plans on.

The paper's own map (Fig. 12) is not published: neither its start and goal nor its circles
and rectangles. This one has the same ingredients, and every result on it must be labelled
"reconstructed map".
"""

from __future__ import annotations

import numpy as np

from mobius.errors import InvalidInput
from mobius.plan.problem import Weights
from mobius.types import ALL_MODES_BITS, GridMap, Mode

__all__ = ["RECONSTRUCTED_WEIGHTS", "reconstructed_map"]

RECONSTRUCTED_WEIGHTS = Weights(
    W_exp=20.0, W_goal=20.0, P={Mode.BIPED: 2.0, Mode.CRAWL: 1.0, Mode.ROLL: 4.0}
)
"""Weights of the reconstructed instances [points]."""

CIRCLES = ((6, 7, 3.0, Mode.CRAWL), (13, 12, 2.5, Mode.BIPED))
"""Centre cell, radius [cells], forced mode."""

RECTANGLES = ((4, 7, 12, 15), (11, 14, 3, 6))
"""x_min, x_max, y_min, y_max of obstacles [cells], both ends included."""


def reconstructed_map(n: int = 20, *, cell: float = 0.5) -> GridMap:
    """The reconstructed map: start in the lower left corner, goal in the upper right.

    Args:
        n: Cells per side, >= 2; what lies beyond is cut off.
        cell: Edge of a cell [m].
    """
    if n < 2:
        raise InvalidInput(f"reconstructed_map: expected n >= 2 cells per side, got {n}")
    i, j = np.indices((n, n))
    allowed = np.full((n, n), ALL_MODES_BITS, dtype=np.uint8)
    for cx, cy, r, mode in CIRCLES:
        allowed[(i - cx) ** 2 + (j - cy) ** 2 <= r**2] = mode.bit
    blocked = np.zeros((n, n), dtype=bool)
    for x0, x1, y0, y1 in RECTANGLES:
        blocked |= (i >= x0) & (i <= x1) & (j >= y0) & (j <= y1)
    grid = GridMap("reconstructed map", cell, np.zeros(3), blocked, allowed)
    corners = grid.center_of([[0, 0], [n - 1, n - 1]])
    return GridMap(grid.name, cell, np.zeros(3), blocked, allowed, corners[0], corners[1])
