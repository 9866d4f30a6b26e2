"""Problems of the planner's benchmarks."""

from __future__ import annotations

import numpy as np

from mobius.plan import (
    RECONSTRUCTED_WEIGHTS,
    Problem,
    build_problem,
    literal_problem,
    reconstructed_map,
)
from mobius.types import GridMap


def case(T: int, connectivity: str, count: str) -> Problem:
    """One of the twelve, on the reconstructed map."""
    return build_problem(
        reconstructed_map(),
        horizon=T,
        weights=RECONSTRUCTED_WEIGHTS,
        connectivity=connectivity,  # type: ignore[arg-type]
        count=count,  # type: ignore[arg-type]
    )


def printed(n: int, T: int) -> Problem:
    return literal_problem(reconstructed_map(n), horizon=T, weights=RECONSTRUCTED_WEIGHTS)


def to_the_goal() -> Problem:
    return build_problem(reconstructed_map(), modes=("crawl", "biped"), must_reach=True)


def blocks(n: int = 100, T: int = 100, *, count: int = 60, seed: int = 0) -> Problem:
    """A big map with random blocks of 2 to 6 cells a side."""
    rng = np.random.default_rng(seed)
    blocked = np.zeros((n, n), dtype=bool)
    for _ in range(count):
        (x, y), (w, h) = rng.integers(2, n - 8, 2), rng.integers(2, 7, 2)
        blocked[x : x + w, y : y + h] = True
    grid = GridMap("blocks", 0.5, np.zeros(3), blocked, np.full((n, n), 7))
    return Problem(grid, (0, 0), (n - 1, n - 1), T, weights=RECONSTRUCTED_WEIGHTS)
