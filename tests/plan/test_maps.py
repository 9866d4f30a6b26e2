"""The reconstructed map holds what its description says."""

from __future__ import annotations

import numpy as np
import pytest

from mobius.errors import InvalidInput
from mobius.plan import reconstructed_map
from mobius.types import Mode


def test_two_rectangles_and_two_circles():
    grid = reconstructed_map()
    assert grid.shape == (20, 20)
    assert grid.blocked.sum() == 2 * 16
    assert grid.blocked[4:8, 12:16].all()
    assert grid.blocked[11:15, 3:7].all()
    # cells with dx^2 + dy^2 <= 9: 29; <= 6.25: 21
    assert (grid.allowed == Mode.CRAWL.bit).sum() == 29
    assert (grid.allowed == Mode.BIPED.bit).sum() == 21


def test_start_and_goal_are_opposite_corners_at_every_size():
    for n in (2, 10, 20):
        grid = reconstructed_map(n)
        assert grid.cell_of(grid.start).tolist() == [0, 0]
        assert grid.cell_of(grid.goal).tolist() == [n - 1, n - 1]
        assert not np.asarray(grid.blocked)[[0, -1], [0, -1]].any()


def test_a_map_of_one_cell_is_refused():
    with pytest.raises(InvalidInput, match="n >= 2"):
        reconstructed_map(1)
