"""On the map everything stands where it stands in the world."""

import base64
import io
import re
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from mobius.errors import InvalidInput
from mobius.types import GridMap, Mode, Plan
from mobius.view.floor_map import floor_map
from mobius.view.palette import MODE_COLOURS


@pytest.fixture
def grid():
    blocked = np.zeros((4, 2), dtype=bool)
    blocked[1:3, 1] = True
    return GridMap("room", 0.5, np.zeros(3), blocked, np.full((4, 2), 7, dtype=np.uint8))


@pytest.fixture
def plan(grid):
    cells = np.array([[0, 0], [1, 0], [2, 0]])
    modes = (Mode.CRAWL, Mode.BIPED)
    return Plan(cells, modes, grid.center_of(cells), "optimal", 1.0, 1.0, 0.01)


PATH = np.array([[0.25, 0.25], [1.25, 0.25]])
GOAL = np.array([1.25, 0.25])


def draw(grid, plan, **options):
    return floor_map(grid, plan, PATH, PATH, goal=GOAL, **options)


def pixels(svg, xy):
    """Where a point of M stands, from what the page's own script is told."""
    x0, y0, scale, margin, height = (
        float(v) for v in re.search(r'data-map="([^"]*)"', svg).group(1).split()
    )
    return margin + (xy[0] - x0) * scale, height - margin - (xy[1] - y0) * scale


def apply(matrix, xy):
    a, b, c, d, e, f = (float(v) for v in matrix.split())
    return a * xy[0] + c * xy[1] + e, b * xy[0] + d * xy[1] + f


def test_y_points_up(grid, plan):
    svg = draw(grid, plan)
    assert pixels(svg, (0.0, 1.0))[1] < pixels(svg, (0.0, 0.0))[1]


def test_blocked_cells_in_a_row_are_one_rectangle(grid, plan):
    # cells (1, 1) and (2, 1): from x = 1 to 3, y = 1 to 2, in cells
    assert 'd="M1 1H3V2H1z" class="blocked"' in draw(grid, plan)


@pytest.mark.parametrize("origin", [(0.0, 0.0, 0.0), (-3.0, 2.0, 0.0), (1.0, -2.0, 0.7)])
def test_cells_stand_where_the_grid_says_even_when_it_is_turned(grid, plan, origin):
    grid = replace(grid, origin_M=np.array(origin))
    svg = draw(grid, plan)
    matrix = re.search(r'<g transform="matrix\(([^)]*)\)"><path[^>]*class="blocked"', svg)
    matrix = matrix or re.search(r'transform="matrix\(([^)]*)\)"', svg)
    # the centre of cell (3, 1) is (3.5, 1.5) in cells
    np.testing.assert_allclose(
        apply(matrix.group(1), (3.5, 1.5)), pixels(svg, grid.center_of([3, 1])), atol=0.05
    )


def test_every_step_of_the_plan_has_the_colour_of_its_mode(grid, plan):
    steps = re.findall(r'class="plan" stroke="(#\w+)"', draw(grid, plan))
    assert steps == [MODE_COLOURS[Mode.CRAWL], MODE_COLOURS[Mode.BIPED]]


def test_the_true_path_ends_where_the_robot_ended(grid, plan):
    svg = draw(grid, plan)
    drawn = re.search(r'points="([^"]*)" class="line true map"', svg).group(1).split()
    last = [float(v) for v in drawn[-1].split(",")]
    np.testing.assert_allclose(last, pixels(svg, PATH[-1]), atol=0.06)


def test_cells_that_force_a_mode_are_tinted(grid, plan):
    allowed = grid.allowed.copy()
    allowed[3, 0] = Mode.BIPED.bit
    svg = draw(replace(grid, allowed=allowed), plan)
    assert f'd="M3 0H4V1H3z" fill="{MODE_COLOURS[Mode.BIPED]}"' in svg


def test_walls_are_drawn_with_their_first_row_at_the_bottom(grid, plan, make_occupancy):
    occupied = np.array([[True, False, False], [False, False, False]])
    svg = draw(grid, plan, occupancy=make_occupancy(occupied))
    data = re.search(r'href="data:image/png;base64,([^"]*)"', svg).group(1)
    alpha = np.array(Image.open(io.BytesIO(base64.b64decode(data))))[..., 3]
    assert alpha.tolist() == [[0, 0, 0], [255, 0, 0]]
    assert "walls and obstacles" in svg


@pytest.mark.parametrize("origin", [(0.0, 0.0, 0.0), (-1.0, 0.5, 0.3)])
def test_a_pixel_of_the_walls_stands_where_the_world_says(grid, plan, make_occupancy, origin):
    svg = draw(grid, plan, occupancy=make_occupancy(np.ones((2, 3), dtype=bool), 0.1, origin))
    outer, inner = re.search(
        r'<g transform="matrix\(([^)]*)\)"><image [^>]*transform="matrix\(([^)]*)\)"', svg
    ).groups()
    # the centre of the picture's top left pixel is column 0, row 1: (0.05, 0.15) m from the corner
    c, s = np.cos(origin[2]), np.sin(origin[2])
    world = np.add(origin[:2], [c * 0.05 - s * 0.15, s * 0.05 + c * 0.15])
    np.testing.assert_allclose(
        apply(outer, apply(inner, (0.5, 0.5))), pixels(svg, world), atol=0.05
    )


def test_the_map_grows_to_hold_walls_beyond_the_cells(grid, plan, make_occupancy):
    walls = make_occupancy(np.zeros((10, 100), dtype=bool), 0.1, (-5.0, 0.0, 0.0))
    svg = draw(grid, plan, occupancy=walls)
    width = float(re.search(r'viewBox="0 0 (\d+)', svg).group(1))
    assert 0 <= pixels(svg, (-5.0, 0.0))[0] < pixels(svg, (5.0, 0.0))[0] <= width


def test_a_raster_without_a_scale_is_refused(grid, plan, make_occupancy):
    with pytest.raises(InvalidInput, match="resolution > 0 m"):
        draw(grid, plan, occupancy=make_occupancy(np.zeros((2, 2), dtype=bool), 0.0))


def test_a_plan_of_no_steps_is_drawn_as_none(grid):
    empty = Plan(np.zeros((1, 2)), (), np.array([[0.25, 0.25]]), "optimal", 0.0, 0.0, 0.0)
    assert 'class="plan"' not in draw(grid, empty)
