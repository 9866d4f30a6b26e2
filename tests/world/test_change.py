"""A world in which something stands that its map does not show."""

import mujoco
import numpy as np
import pytest

from mobius.errors import MapError
from mobius.model.robot import load_spec
from mobius.world import load_world, with_obstacles
from mobius.world.clearance import Clearance
from mobius.world.grid import refit
from mobius.world.load import blocked_pixels
from mobius.world.scenario import Obstacle
from mobius.world.scene import build_scene, movable_pose
from mobius.world.shapes import Rectangle

CRATE = Rectangle((1.2, 0.0), (0.5, 0.5))


@pytest.fixture(scope="module")
def world():
    return load_world("arena", radius=0.41, margin=0.04, lane=0.34)


def test_cells_near_an_obstacle_are_blocked_and_the_grid_stays_where_it_was(world):
    changed = with_obstacles(world, [CRATE])
    assert changed.grid.shape == world.grid.shape
    np.testing.assert_array_equal(changed.grid.origin_M, world.grid.origin_M)
    i, j = world.grid.cell_of(CRATE.center)
    assert changed.grid.blocked[i, j] and not world.grid.blocked[i, j]
    assert (changed.grid.blocked >= world.grid.blocked).all()
    assert (changed.clearance <= world.clearance + 1e-9).all()
    assert changed.occupancy.occupied.sum() > world.occupancy.occupied.sum()


def test_without_obstacles_it_is_the_world_itself(world):
    assert with_obstacles(world, []) is world


def test_the_same_raster_gives_the_same_cells(world):
    raster = world.occupancy
    clearance = Clearance(blocked_pixels(raster, world.raised), raster.resolution)
    grid, room = refit(world.grid, raster, clearance, disc=world.disc)
    np.testing.assert_array_equal(grid.blocked, world.grid.blocked)
    np.testing.assert_allclose(room, world.clearance, atol=1e-9)


def test_a_wall_across_the_only_way_is_told_when_asked(world):
    walls = [Rectangle((0.0, 1.1), (0.2, 1.0)), Rectangle((0.0, -1.1), (0.2, 1.0))]
    with_obstacles(world, walls)
    with pytest.raises(MapError, match="cannot be reached"):
        with_obstacles(world, walls, check=True)


def test_the_obstacle_is_really_there_and_really_moves(world):
    crate = Obstacle("crate", (0.5, 0.5), 0.5, None)
    model = build_scene(world, load_spec("full"), obstacles=[crate]).compile()
    data, geom = mujoco.MjData(model), model.geom("wall_moving_crate").id
    slot = model.body("moving_crate").mocapid[0]
    data.qpos[:3] = (-1.2, -0.7, 0.3)

    def touches():
        mujoco.mj_forward(model, data)
        return bool((data.contact.geom == geom).any())

    assert not touches()
    place = Rectangle((-1.2, -0.7), (0.5, 0.5), 0.3)
    data.mocap_pos[slot], data.mocap_quat[slot] = movable_pose(crate, place)
    assert touches()
    data.mocap_pos[slot], data.mocap_quat[slot] = movable_pose(crate, None)
    assert not touches()
