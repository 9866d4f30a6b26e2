"""Where a wall is thinnest, and how far it goes on."""

from __future__ import annotations

import numpy as np

from mobius.barrier import thinnest, wall_between, wall_of
from mobius.types import GridMap


def areas(picture: str):
    """Masks of 'S', 'G' and '#' in a picture, top row the largest y."""
    rows = [line.strip() for line in picture.strip().splitlines()][::-1]
    letters = np.array([list(row) for row in rows]).T
    return letters == "S", letters == "G", letters == "#"


def test_the_line_is_the_shortest_and_begins_and_ends_in_the_areas():
    near, far, _ = areas("SS###G\nSS#GGG\nSS##GG")
    line = thinnest(near, far)
    assert (line.near, line.between, line.far) == ((1, 1), ((2, 1),), (3, 1))


def test_areas_that_touch_have_nothing_in_between():
    near, far, _ = areas("SSGG")
    line = thinnest(near, far)
    assert (line.near, line.between, line.far) == ((1, 0), (), (2, 0))


def test_the_line_crosses_a_long_wall_in_its_middle():
    near, far, blocked = areas("\n".join(["SS##GG"] * 9))
    line = thinnest(near, far)
    assert line.between == ((2, 4), (3, 4))
    assert wall_of(blocked & line.thin, (2, 4)) == ((2, 0), (3, 8))


def test_a_wall_ends_where_no_side_and_no_corner_goes_on():
    _, _, blocked = areas("#..#\n.#..\n..#.")
    assert wall_of(blocked, (1, 1)) == ((0, 0), (2, 2))


def test_the_wall_is_told_in_metres_of_the_map():
    near, far, blocked = areas("SS##GG\nSS##GG")
    grid = GridMap("g", 0.5, (10.0, -1.0, 0.0), blocked, np.full(blocked.shape, 7))
    assert wall_between(grid, thinnest(near, far)) == (
        "the wall in between (x 11 to 12, y -1 to 0 m) is 2 cells thick at (11.75, -0.75) m"
    )


def test_only_the_part_that_separates_is_told():
    """The wall between the rooms, not the frame round the whole map that it is part of."""
    near, far, blocked = areas("#######\n#SS#GG#\n#SS#GG#\n#######")
    grid = GridMap("g", 1.0, np.zeros(3), blocked, np.full(blocked.shape, 7))
    text = wall_between(grid, thinnest(near, far))
    assert text == "the wall in between (x 3 to 4, y 1 to 3 m) is 1 cell thick at (3.5, 1.5) m"


def test_where_no_cell_is_blocked_there_is_no_wall():
    near, far, blocked = areas("S.G")
    grid = GridMap("g", 1.0, np.zeros(3), blocked, np.full(blocked.shape, 7))
    assert wall_between(grid, thinnest(near, far)) is None
