"""The planner's grid keeps its promise: straight moves through free cells are safe."""

import numpy as np
import pytest

from mobius.errors import InvalidInput
from mobius.world.clearance import Clearance
from mobius.world.grid import Disc, build_grid, components
from mobius.world.occupancy import OccupancyMap


def floor(width, height, *walls, resolution=0.05, origin=(0.0, 0.0, 0.0)):
    """A free floor [m] with occupied boxes x0, y0, x1, y1 [m]."""
    shape = (round(height / resolution), round(width / resolution))
    occupancy = np.zeros(shape, dtype=int)
    for box in walls:
        x0, y0, x1, y1 = (round(v / resolution) for v in box)
        occupancy[y0:y1, x0:x1] = 100
    return OccupancyMap("test", occupancy, resolution, np.array(origin))


def grid_of(raster, disc, **options):
    return build_grid(raster, Clearance(raster.occupied, raster.resolution), disc=disc, **options)


def speckled(seed, *, density=0.01, shape=(90, 120)):
    rng = np.random.default_rng(seed)
    occupancy = 100 * (rng.random(shape) < density)
    return OccupancyMap("test", occupancy, 0.05, np.array([0.3, -0.7, 0.2 * seed]))


def moves(grid):
    """Every straight move between free neighbours: (n, 2, 2) [m], frame M."""
    free = ~grid.blocked
    along_x = np.argwhere(free[:-1] & free[1:])
    along_y = np.argwhere(free[:, :-1] & free[:, 1:])
    pairs = [np.stack([c, c + step], axis=1) for c, step in ((along_x, [1, 0]), (along_y, [0, 1]))]
    return grid.center_of(np.concatenate(pairs))


def distance_to_squares(raster, line_M, samples=41):
    """Least distance [m] from a line (2, 2) to the occupied pixels and the outside."""
    a, b = raster.to_local(line_M)
    xy = a + np.linspace(0, 1, samples)[:, None] * (b - a)
    rows, cols = np.nonzero(raster.occupied)
    low = np.stack([cols, rows], axis=-1) * raster.resolution
    gap = np.maximum(np.maximum(low - xy[:, None], xy[:, None] - low - raster.resolution), 0.0)
    width, height = raster.size
    edge = min(xy.min(), (width - xy[:, 0]).min(), (height - xy[:, 1]).min())
    return min(np.hypot(gap[..., 0], gap[..., 1]).min(initial=np.inf), edge)


@pytest.mark.parametrize("seed", range(4))
def test_a_disc_that_moves_straight_between_free_cells_touches_nothing(seed):
    raster, disc = speckled(seed), Disc(0.2, 0.05)
    grid, _ = grid_of(raster, disc)
    lines = moves(grid)
    assert len(lines) > 20
    assert min(distance_to_squares(raster, line) for line in lines) >= disc.need - 1e-9


def test_the_promise_holds_for_cells_that_do_not_fit_the_pixels():
    # 0.37 m cells on 0.05 m pixels: centres lie off the lattice
    raster, disc = speckled(1), Disc(0.2, 0.05)
    grid, _ = grid_of(raster, disc, cell=0.37)
    lines = moves(grid)
    assert len(lines) > 20
    assert min(distance_to_squares(raster, line) for line in lines) >= disc.need - 1e-9


def test_a_corner_between_two_clear_centres_blocks_one_of_them():
    # centres of cells at x = 1.25 and 1.75, y = 1.25; a post whose nearest corners are
    # (1.45, 0.95) and (1.55, 0.95), 0.30 m below the line and hypot(0.2, 0.3) = 0.361 m
    # from both centres
    raster = floor(3.0, 2.5, (1.45, 0.5, 1.55, 0.95))
    grid, clearance = grid_of(raster, Disc(0.36, 0.0), anchor=(0.0, 0.0))
    assert clearance[2, 2] == pytest.approx(np.hypot(0.2, 0.3))
    assert clearance[3, 2] == pytest.approx(np.hypot(0.2, 0.3))
    assert grid.blocked[2:4, 2].sum() == 1
    # where the line is far enough, both stay
    grid, _ = grid_of(raster, Disc(0.30, 0.0), anchor=(0.0, 0.0))
    assert not grid.blocked[2:4, 2].any()


def test_a_room_by_hand():
    # 3 x 2 m, need 0.4: centres at 0.25 m from a wall go, those at 0.75 m stay
    grid, clearance = grid_of(floor(3.0, 2.0), Disc(0.3, 0.1), anchor=(0.0, 0.0))
    assert grid.shape == (6, 4)
    assert grid.blocked.sum() == 24 - 4 * 2
    assert not grid.blocked[1:5, 1:3].any()
    assert clearance[0, 0] == pytest.approx(0.25)
    assert clearance[2, 1] == pytest.approx(0.75)


def test_a_larger_robot_never_gains_a_cell():
    raster = speckled(5)
    small, _ = grid_of(raster, Disc(0.15, 0.0), anchor=(0.1, 0.2))
    large, _ = grid_of(raster, Disc(0.25, 0.0), anchor=(0.1, 0.2))
    # cells that a bad line cost the small robot may differ; centres may not
    clear = grid_of(raster, Disc(0.0, 0.0), anchor=(0.1, 0.2))[1]
    assert (small.blocked[clear < 0.15]).all()
    assert (large.blocked[clear < 0.25]).all()
    assert (~large.blocked).sum() < (~small.blocked).sum()


@pytest.mark.parametrize("shift", [0.0, 0.1, 0.2, 0.3, 0.4])
def test_a_narrow_corridor_survives_wherever_it_lies(shift):
    # 0.85 m wide, need 0.4: centres have 0.05 m to choose from, rows are 0.5 m apart
    y = 1.0 + shift
    raster = floor(4.0, 3.0, (1.0, 0.0, 3.0, y), (1.0, y + 0.85, 3.0, 3.0))
    grid, _ = grid_of(raster, Disc(0.4, 0.0), start=(0.5, 1.5), goal=(3.5, 1.5))
    part = components(grid.blocked)
    start, goal = (part[tuple(grid.cell_of(p))] for p in (grid.start, grid.goal))
    assert start == goal != 0


def test_start_and_goal_come_to_the_middle_of_their_cells_where_they_can():
    grid, _ = grid_of(floor(6.0, 4.0), Disc(0.3, 0.1), start=(1.15, 1.3), goal=(4.65, 2.8))
    for point in (grid.start, grid.goal):
        centre = grid.center_of(grid.cell_of(point))
        assert np.linalg.norm(centre - point) < 0.04


def test_the_same_map_gives_the_same_grid():
    one, two = (grid_of(speckled(3), Disc(0.2, 0.0))[0] for _ in range(2))
    assert np.array_equal(one.origin_M, two.origin_M)
    assert np.array_equal(one.blocked, two.blocked)


def test_the_grid_turns_with_the_map():
    level = floor(3.0, 2.0, (1.0, 0.0, 1.2, 0.8))
    turned = floor(3.0, 2.0, (1.0, 0.0, 1.2, 0.8), origin=(5.0, 1.0, 0.9))
    a, b = (grid_of(m, Disc(0.2, 0.0))[0] for m in (level, turned))
    assert np.array_equal(a.blocked, b.blocked)
    assert b.origin_M[2] == 0.9
    cells = np.argwhere(~b.blocked)
    assert np.allclose(turned.to_local(b.center_of(cells)), a.center_of(cells))


def test_only_the_part_where_the_robot_fits_is_covered():
    raster = floor(20.0, 20.0, (0, 0, 20, 8), (0, 12, 20, 20), (0, 8, 8, 12), (12, 8, 20, 12))
    grid, _ = grid_of(raster, Disc(0.3, 0.1))
    assert grid.shape[0] <= 10
    assert grid.shape[1] <= 10
    assert grid_of(raster, Disc(0.3, 0.1), anchor=(0.0, 0.0))[0].shape == (40, 40)


def test_a_map_without_room_is_all_blocked():
    grid, _ = grid_of(floor(1.0, 1.0), Disc(0.6, 0.0))
    assert grid.blocked.all()


def doorway(width, *, cross=False):
    """Two rooms of 2 x 3 m and a doorway of a width [m] through 0.5 m of wall at y = 1.5."""
    low, high = 1.5 - width / 2, 1.5 + width / 2
    return floor(4.5, 3.0, (2.0, 0.0, 2.5, low), (2.0, high, 2.5, 3.0))


def test_a_doorway_too_narrow_to_turn_in_is_a_way_through_for_one_that_walks_straight():
    raster = doorway(0.8)
    ends = {"start": (1.0, 1.5), "goal": (3.5, 1.5)}
    joined = []
    for disc in (Disc(0.45, 0.0), Disc(0.45, 0.0, lane=0.4), Disc(0.45, 0.0, lane=0.42)):
        grid, _ = grid_of(raster, disc, **ends)
        part = components(grid.blocked)
        joined.append(
            part[tuple(grid.cell_of(ends["start"]))] == part[tuple(grid.cell_of((3.5, 1.5)))]
        )
    assert joined == [False, True, False]


@pytest.mark.parametrize("seed", range(4))
def test_a_cell_too_narrow_to_turn_in_has_exactly_two_opposite_neighbours(seed):
    raster, disc = speckled(seed), Disc(0.3, 0.0, lane=0.2)
    grid, clearance = grid_of(raster, disc)
    free = np.pad(~grid.blocked, 1)
    narrow = np.argwhere(~grid.blocked & (clearance < disc.need - 1e-9))
    assert len(narrow)
    for i, j in narrow + 1:
        x, y = free[i - 1, j] + 0 + free[i + 1, j], free[i, j - 1] + 0 + free[i, j + 1]
        assert sorted((int(x), int(y))) == [0, 2]
    assert min(distance_to_squares(raster, line) for line in moves(grid)) >= disc.lane - 1e-9


@pytest.mark.parametrize(
    "options", [{"radius": -0.1}, {"radius": np.nan}, {"radius": 0.2, "lane": 0.5}]
)
def test_a_robot_that_is_none_is_refused(options):
    with pytest.raises(InvalidInput, match="Disc"):
        Disc(**options)


@pytest.mark.parametrize("cell", [0.0, -1.0, np.nan, 1e-4])
def test_a_cell_that_is_none_is_refused(cell):
    with pytest.raises(InvalidInput, match="cell"):
        grid_of(floor(3.0, 2.0), Disc(0.1), cell=cell)
