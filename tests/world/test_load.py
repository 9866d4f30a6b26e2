"""A map file or a name becomes a world, or one line that says why not."""

import numpy as np
import pytest

from mobius.errors import MapError, UnknownName
from mobius.types import Mode
from mobius.world import load_world, map_names, map_path, write_nav2
from mobius.world.occupancy import OccupancyMap

ROBOT = {"radius": 0.3, "margin": 0.05}


def put(tmp_path, occupancy, *, origin=(0.0, 0.0, 0.0), **mobius):
    path = tmp_path / "map.yaml"
    raster = OccupancyMap("map", occupancy, 0.1, np.array(origin))
    write_nav2(path, raster, mobius=mobius or None)
    return path


def room():
    """6 x 4 m, walls of 0.1 m, a wall across at x = 3 m with a door 1.2 m wide."""
    occupancy = np.full((40, 60), 100)
    occupancy[1:-1, 1:-1] = 0
    occupancy[:, 30] = 100
    occupancy[14:26, 30] = 0
    return occupancy


def message(*args, **kwargs):
    with pytest.raises(MapError) as caught:
        load_world(*args, **ROBOT, **kwargs)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_the_shipped_maps_can_be_walked_from_start_to_goal():
    assert map_names() == ["arena", "demo", "multimodal"]
    for name in map_names():
        world = load_world(name, radius=0.37, margin=0.08)
        assert world.name == name
        assert world.clearance.shape == world.grid.shape
        assert (world.clearance[~world.grid.blocked] >= 0.45 - 1e-9).all()


def test_a_name_nobody_knows_gets_the_nearest():
    with pytest.raises(UnknownName, match="Did you mean 'demo'"):
        load_world("dmeo", radius=0.3)
    with pytest.raises(UnknownName, match="arena, demo, multimodal"):
        map_path("nowhere")


@pytest.mark.parametrize("source", ["nowhere/map.yaml", "map.yml"])
def test_a_file_that_is_not_there_is_told(source):
    assert f"{source}: there is no such file" in message(source)


def test_an_image_is_no_map():
    assert "name the map's .yaml, not its image" in message(map_path("demo").with_suffix(".pgm"))


def test_start_and_goal_of_the_call_win_over_those_of_the_map(tmp_path):
    path = put(tmp_path, room(), start=[1.0, 2.0], goal=[5.0, 2.0])
    assert load_world(path, **ROBOT).grid.start.tolist() == [1.0, 2.0]
    world = load_world(path, **ROBOT, start=(1.0, 1.0), cell=0.4)
    assert world.grid.start.tolist() == [1.0, 1.0]
    assert world.grid.goal.tolist() == [5.0, 2.0]
    assert world.grid.cell == 0.4


def test_a_map_without_start_and_goal_is_a_world_too(tmp_path):
    world = load_world(put(tmp_path, room()), **ROBOT)
    assert world.grid.start is None
    assert (~world.grid.blocked).sum() > 20


@pytest.mark.parametrize("what", ["start", "goal"])
@pytest.mark.parametrize(
    ("point", "says"),
    [
        ((9.0, 2.0), "(9.00, 2.00) m lies off the map, whose lower-left corner is (0.00, 0.00) m"),
        ((3.05, 0.55), "lies in an obstacle (pixel column 30, row 34 from the top)"),
        ((0.35, 2.0), "is 0.25 m from an obstacle, the robot needs 0.30 m"),
    ],
)
def test_a_place_where_the_robot_does_not_fit_is_told_with_the_nearest_that_does(
    tmp_path, what, point, says
):
    path = put(tmp_path, room())
    text = message(path, **{what: point})
    assert f"{path}: {what}" in text
    assert says in text
    x, y = (float(v) for v in text.split("nearest free cell is at (")[1].split(")")[0].split(","))
    load_world(path, **ROBOT, **{what: (x, y)})


def test_unknown_space_is_no_place_to_stand(tmp_path):
    occupancy = room()
    occupancy[10:20, 40:50] = -1
    path = put(tmp_path, occupancy)
    assert "lies in unknown space" in message(path, start=(4.5, 1.5))
    assert load_world(path, **ROBOT, start=(4.5, 1.5), unknown_blocks=False).grid.start is not None


def test_a_goal_behind_a_wall_is_told_with_the_nearest_cell_in_reach(tmp_path):
    occupancy = room()
    occupancy[:, 30] = 100
    path = put(tmp_path, occupancy)
    text = message(path, start=(1.0, 2.0), goal=(5.0, 2.0))
    assert f"{path}: goal (5.00, 2.00) m cannot be reached from start (1.00, 2.00) m" in text
    x = float(text.split("it can reach is at (")[1].split(",")[0])
    assert 2.0 < x < 2.7


def test_a_door_narrower_than_the_robot_is_no_way(tmp_path):
    path = put(tmp_path, room())
    ends = {"start": (1.0, 2.0), "goal": (5.0, 2.0)}
    load_world(path, radius=0.55, margin=0.05, **ends)
    with pytest.raises(MapError, match="cannot be reached"):
        load_world(path, radius=0.55, margin=0.06, **ends)
    load_world(path, radius=0.55, margin=0.06, lane=0.6, **ends)


def test_modes_come_from_shapes_and_from_the_region_image(tmp_path):
    shapes = [{"type": "circle", "center": [1.5, 2.0], "radius": 0.6, "mode": "crawl"}]
    world = load_world(put(tmp_path, room(), shapes=shapes), **ROBOT)
    centers = world.grid.center_of(np.moveaxis(np.indices(world.grid.shape), 0, -1))
    inside = np.linalg.norm(centers - [1.5, 2.0], axis=-1) < 0.6
    assert inside.any()
    assert (world.grid.allowed[inside] == Mode.CRAWL.bit).all()
    assert (world.grid.allowed[~inside] == 7).all()


def test_the_floor_under_a_low_board_is_blocked_and_under_a_high_one_only_its_legs(tmp_path):
    table = {"center": [1.5, 2.0], "size": [1.2, 1.2]}
    under = (1.5, 2.0)
    low = put(tmp_path, room(), raised=[table | {"height": [0.4, 0.45]}])
    assert "lies in or under an obstacle" in message(low, start=under)
    high = put(tmp_path, room(), raised=[table | {"height": [0.7, 0.75]}])
    world = load_world(high, **ROBOT, start=under)
    assert world.raised[0].bottom == 0.7
    # legs of 0.04 m at 0.58 m from the middle along both axes, seen from a pixel's diagonal
    leg = np.hypot(0.56, 0.56)
    assert leg - 0.25 < world.clearance[tuple(world.grid.cell_of(under))] <= leg


def test_a_turned_map_holds_its_start_in_the_frame_of_the_map(tmp_path):
    # the room turned by 90 deg about (2, 1): its x axis points along +y of the map frame
    path = put(tmp_path, room(), origin=(2.0, 1.0, np.pi / 2))
    world = load_world(path, **ROBOT, start=(0.0, 2.0), goal=(0.0, 6.0))
    assert not world.grid.blocked[tuple(world.grid.cell_of((0.0, 2.0)))]
    assert np.allclose(world.occupancy.to_local((0.0, 2.0)), [1.0, 2.0])


def test_a_world_is_read_only():
    with pytest.raises(ValueError, match="read-only"):
        load_world("arena", **ROBOT).clearance[0, 0] = 1.0
