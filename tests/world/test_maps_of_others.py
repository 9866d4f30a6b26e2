"""Real floor plans that nobody here drew, where they are at hand."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

from mobius.errors import MapError
from mobius.world import load_world, read_nav2
from mobius.world.scene import build_scene, wall_boxes

MAPS = Path(__file__).parents[3] / "shared" / "maps"
CRAWL = {"radius": 0.37, "margin": 0.08}

pytestmark = pytest.mark.skipif(not MAPS.is_dir(), reason="the folder shared/maps is not here")


def test_the_depot_is_read_as_nav2_reads_it():
    raster, _ = read_nav2(MAPS / "depot.yaml")
    assert raster.shape == (307, 604)
    assert raster.occupied.sum() == 5947
    # free_thresh 0.25: the grey 205 (p = 0.196) that was meant as unknown is free
    assert raster.unknown.sum() == 0


def test_the_sandbox_is_mostly_unknown_and_the_grid_covers_the_rest():
    raster, _ = read_nav2(MAPS / "tb3_sandbox.yaml")
    assert raster.unknown.sum() == 138683
    world = load_world(MAPS / "tb3_sandbox.yaml", **CRAWL)
    assert max(world.grid.shape) <= 12


@pytest.mark.parametrize(
    ("start", "goal"),
    [
        ((3.0, 8.0), (25.0, 7.0)),
        ((13.5, 4.3), (24.8, 4.3)),  # along the aisle between two rows of racks
        ((17.0, 1.5), (22.4, 8.0)),  # across both rows
        ((2.5, 2.0), (28.5, 1.2)),
    ],
)
def test_the_depot_can_be_crossed_between_its_racks(start, goal):
    world = load_world(MAPS / "depot.yaml", **CRAWL, start=start, goal=goal)
    for point in (world.grid.start, world.grid.goal):
        cell = world.grid.cell_of(point)
        assert np.linalg.norm(world.grid.center_of(cell) - point) < 0.21


def test_the_sandbox_is_crossed_straight_between_its_pillars_or_not_at_all():
    ends = {"start": (-2.0, -0.5), "goal": (2.0, 0.5)}
    with pytest.raises(MapError, match="cannot be reached"):
        load_world(MAPS / "tb3_sandbox.yaml", **CRAWL, **ends)
    world = load_world(MAPS / "tb3_sandbox.yaml", **CRAWL, lane=0.34, **ends)
    assert world.clearance[~world.grid.blocked].min() < 0.45


def test_the_depot_becomes_a_few_hundred_boxes():
    ends = {"start": (13.5, 4.3), "goal": (24.8, 4.3)}
    world = load_world(MAPS / "depot.yaml", **CRAWL, **ends)
    boxes = wall_boxes(world)
    assert 100 < len(boxes) < 350
    robot = mujoco.MjSpec.from_string(
        "<mujoco><option jacobian='dense'/><worldbody><body pos='13 4 1'><freejoint/>"
        "<geom size='0.2'/></body></worldbody></mujoco>"
    )
    model = build_scene(world, robot).compile()
    assert model.ngeom == len(boxes) + 2
    assert not mujoco.mj_isSparse(model)
