"""MovingAI benchmarks come in one cell per character."""

import numpy as np
import pytest

from mobius.errors import MapError
from mobius.types import Mode
from mobius.world import load_world
from mobius.world.movingai import read_movingai

GOOD = "type octile\nheight 3\nwidth 4\nmap\n.G@O\nTSW.\n....\n"


def put(tmp_path, text=GOOD):
    path = tmp_path / "a.map"
    path.write_text(text)
    return path


def test_the_first_row_of_the_file_is_the_top(tmp_path):
    raster, notes = read_movingai(put(tmp_path), cell=2.0)
    assert raster.occupancy.tolist() == [[0] * 4, [100, 0, 0, 0], [0, 0, 100, 100]]
    assert raster.size == (8.0, 6.0)
    bits = np.full((3, 4), 7)
    bits[1, 1], bits[1, 2] = Mode.CRAWL.bit, Mode.BIPED.bit
    assert np.array_equal(notes.region_bits, bits)


def test_a_character_is_a_cell_of_the_planner(tmp_path):
    world = load_world(put(tmp_path), radius=0.0, margin=0.0, cell=2.0)
    assert world.grid.shape == (4, 3)
    assert world.grid.cell == 2.0
    # transposed: cell (i, j) is column i, row j from the bottom
    assert world.grid.blocked.T.tolist() == (world.occupancy.occupancy == 100).tolist()
    assert world.grid.allowed[1, 1] == Mode.CRAWL.bit
    assert world.grid.allowed[2, 1] == Mode.BIPED.bit


def test_a_robot_with_a_body_keeps_its_distance_here_too(tmp_path):
    rows = "".join("." * 6 + "\n" for _ in range(5))
    path = put(tmp_path, f"type octile\nheight 5\nwidth 6\nmap\n{rows}")
    # centres of the outer ring are 0.25 m from the edge of the map
    assert load_world(path, radius=0.2, margin=0.0).grid.blocked.sum() == 0
    assert load_world(path, radius=0.3, margin=0.0).grid.blocked.sum() == 30 - 4 * 3


def test_line_endings_and_blank_last_lines_do_not_matter(tmp_path):
    want, _ = read_movingai(put(tmp_path))
    got, _ = read_movingai(put(tmp_path, GOOD.replace("\n", "\r\n") + "\r\n"))
    assert np.array_equal(got.occupancy, want.occupancy)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        (GOOD, "", "line 1: expected 'type octile', got an empty file"),
        ("octile", "hex", "line 1: expected 'type octile', got 'type hex'"),
        ("height 3", "hieght 3", "line 2: expected 'height N'"),
        ("width 4", "width four", "line 3: expected 'height N'"),
        ("width 4", "width 0", "line 3: expected 'height N'"),
        ("width 4\n", "", "the width is missing"),
        ("map\n", "", "line 4: expected 'height N', 'width N' or 'map'"),
        ("height 3", "height 99999999", "line 2: expected at most"),
        ("....\n", "", "the file is truncated, expected 3 rows of cells, got 2"),
        ("TSW.", "TSW", "line 6: expected 4 cells, got 3"),
        ("TSW.", "TSX.", "line 6, column 3: unknown cell 'X'"),
        ("....\n", "....\n....\n", "line 8: expected nothing after row 3"),
        ("....", "\xe9...", "byte"),
    ],
)
def test_a_mistake_is_one_line_with_place_and_fix(tmp_path, old, new, says):
    path = put(tmp_path, GOOD.replace(old, new))
    with pytest.raises(MapError) as caught:
        read_movingai(path)
    assert says in str(caught.value)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_missing_file_names_the_one_that_was_meant(tmp_path):
    put(tmp_path)
    with pytest.raises(MapError, match=r"Did you mean 'a\.map'"):
        read_movingai(tmp_path / "b.map")
