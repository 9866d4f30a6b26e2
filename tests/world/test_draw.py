"""The maps in the package are the ones the script draws."""

import numpy as np
import pytest
from scipy import ndimage

from mobius.world import load_world, map_path
from mobius.world.draw import DRAWINGS, WALL, write_all


def test_what_is_committed_is_what_is_drawn(tmp_path):
    write_all(tmp_path)
    drawn = {p.name: p.read_bytes() for p in tmp_path.iterdir()}
    committed = {p.name: p.read_bytes() for p in map_path("demo").parent.iterdir()}
    assert drawn == committed


@pytest.mark.parametrize("name", sorted(DRAWINGS))
def test_every_free_pixel_has_a_wall_between_it_and_the_unknown(name):
    raster, _ = DRAWINGS[name]()
    reach = 2 * round(WALL / raster.resolution) + 1
    near_free = ndimage.maximum_filter(raster.occupancy == 0, reach, mode="constant")
    assert not (near_free & raster.unknown).any()
    rim = np.concatenate([raster.occupancy[[0, -1]].ravel(), raster.occupancy[:, [0, -1]].ravel()])
    assert (rim == -1).all()


def test_the_demo_is_a_walk_of_less_than_40_seconds_with_a_bit_of_everything():
    world = load_world("demo", radius=0.37, margin=0.08)
    start, goal = world.grid.start, world.grid.goal
    assert 6.0 <= np.linalg.norm(goal - start) <= 9.0
    assert np.abs(goal - start).sum() / 0.3 < 40.0
    assert len(world.rough) == len(world.raised) == 1
    assert world.rough[0].amplitude <= 0.03
    assert set(world.grid.allowed.ravel().tolist()) == {1, 2, 7}
    for point in (start, goal):
        assert np.allclose(world.grid.center_of(world.grid.cell_of(point)), point, atol=0.04)
