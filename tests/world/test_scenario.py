"""What changes during a run: read, checked, and carried out in time."""

import numpy as np
import pytest

from mobius.errors import MapError
from mobius.world import Scenery, check_scenario, load_world, read_scenario
from mobius.world.shapes import Rectangle

GOOD = """
obstacles:
  - {name: crate, center: [0.9, 0.0], size: [0.6, 0.4], yaw: 0.3}
  - {name: pallet, size: [0.5, 0.5], height: 0.2}
events:
  - {t: 5.0, move: crate, to: [1.0, 1.0]}
  - {reach: [1.2, -0.7], add: pallet, to: [-1.0, 1.0], yaw: 0.1}
  - {t: 9.0, remove: crate}
"""


NOWHERE = "obstacles: [{name: a, size: [1, 1]}]\nevents:\n"


@pytest.fixture
def read(tmp_path):
    def read(text):
        file = tmp_path / "scenario.yaml"
        file.write_text(text)
        return read_scenario(file)

    return read


@pytest.fixture(scope="module")
def grid():
    return load_world("arena", radius=0.41, margin=0.04).grid


def test_it_reads_obstacles_and_events(read):
    scenario = read(GOOD)
    crate, pallet = scenario.obstacles
    assert crate.area == Rectangle((0.9, 0.0), (0.6, 0.4), 0.3) and crate.height == 0.5
    assert pallet.area is None and pallet.height == 0.2
    move, add, remove = scenario.events
    assert (move.what, move.t, move.reach) == ("move", 5.0, None)
    assert move.area == Rectangle((1.0, 1.0), (0.6, 0.4), 0.3)  # it keeps its heading
    assert (add.what, add.t, add.reach) == ("add", None, (1.2, -0.7))
    assert remove.area is None


def test_events_come_at_their_time_and_where_the_robot_is(read, grid):
    scenery, far = Scenery(read(GOOD)), (-1.25, -0.75)
    assert scenery.due(4.9, far, grid) == []
    (event,) = scenery.due(5.0, far, grid)
    assert event.what == "move" and scenery.here["crate"].center == (1.0, 1.0)
    cell = grid.center_of(grid.cell_of((1.2, -0.7)))
    assert [e.what for e in scenery.due(6.0, cell, grid)] == ["add"]
    assert len(scenery.areas) == 2
    assert [e.what for e in scenery.due(20.0, far, grid)] == ["remove"]
    assert scenery.pending == [] and len(scenery.areas) == 1


def test_nothing_comes_to_stand_on_the_robot(read, grid):
    scenery = Scenery(read(GOOD))
    assert scenery.due(6.0, (1.0, 0.5), grid, room=0.45) == []
    assert len(scenery.due(6.1, (-1.0, 0.5), grid, room=0.45)) == 1


def test_what_was_held_for_room_comes_in_the_order_in_which_it_was_due(read, grid):
    text = NOWHERE + "  - {t: 40, remove: a}\n  - {t: 12, add: a, to: [-1.0, -0.7]}"
    scenery, near, far = Scenery(read(text)), (-1.0, -0.7), (1.2, 0.7)
    assert scenery.due(12.0, near, grid, room=0.6) == []
    assert scenery.due(40.0, near, grid, room=0.6) == []  # it waits for what it undoes
    assert [e.what for e in scenery.due(41.0, far, grid, room=0.6)] == ["add", "remove"]
    assert scenery.areas == () and scenery.pending == []


def test_a_place_that_was_reached_stays_reached(read, grid):
    text = NOWHERE + "  - {reach: [-1.2, -0.7], add: a, to: [-1.2, -0.7]}"
    scenery, (x, y) = Scenery(read(text)), grid.center_of(grid.cell_of((-1.2, -0.7)))
    assert scenery.due(1.0, (x, y), grid, room=0.6) == []
    assert scenery.pending and not scenery.comes_by_itself
    assert [e.what for e in scenery.due(9.0, (x + 2.0, y), grid, room=0.6)] == ["add"]


def test_only_what_has_a_time_comes_by_itself(read, grid):
    scenery = Scenery(read(GOOD))
    assert scenery.comes_by_itself
    scenery.due(10.0, (-1.25, -0.75), grid)
    assert scenery.pending and not scenery.comes_by_itself


def test_what_is_moved_keeps_the_heading_that_it_has(read, grid):
    text = """
obstacles: [{name: a, center: [1, 0], size: [0.4, 0.4], yaw: 0.3}]
events:
  - {t: 1, move: a, to: [1, 1], yaw: 1.0}
  - {t: 2, move: a, to: [1, -1]}
"""
    scenery = Scenery(read(text))
    scenery.due(1.0, (-1.25, -0.75), grid)
    (event,) = scenery.due(2.0, (-1.25, -0.75), grid)
    assert event.area == scenery.here["a"] == Rectangle((1.0, -1.0), (0.4, 0.4), 1.0)


def test_a_place_the_robot_can_never_reach_is_refused(read):
    raster = load_world("arena", radius=0.41, margin=0.04).occupancy
    wall = raster.pixel_centers()[raster.occupied][0]
    for (x, y), where in (((500.0, 0.0), "off the map"), (wall, "in an obstacle")):
        text = NOWHERE + f"  - {{reach: [{x:.4f}, {y:.4f}], add: a, to: [1, 0]}}"
        with pytest.raises(MapError, match=f"'reach' .* lies {where}"):
            check_scenario(read(text), raster, "s.yaml")


def test_a_missing_file_is_asked_for_by_what_it_is(tmp_path):
    with pytest.raises(MapError, match=r"expected a scenario$"):
        read_scenario(tmp_path / "none.yaml")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("events: []", "names no obstacle"),
        ("obstacles: [{name: a, size: [1, 0]}]", "two lengths >= 0.02"),
        ("obstacles: [{name: a, size: [1, 1]}, {name: a, size: [1, 1]}]", "there twice"),
        ("obstacles: [{name: a b, size: [1, 1]}]", "letters, digits"),
        ("obstacles: [{name: a, size: [1, 1]}]\nevent: []", "Did you mean 'events'"),
        (GOOD + "  - {t: 3, move: crat, to: [0, 0]}", "Did you mean 'crate'"),
        (GOOD + "  - {move: crate, to: [0, 0]}", "either 't: 12.0'"),
        (GOOD + "  - {t: 1, reach: [0, 0], remove: crate}", "either 't: 12.0'"),
        (GOOD + "  - {t: 1, move: crate, remove: crate}", "one of 'move: NAME'"),
        (GOOD + "  - {t: 1}", "one of 'move: NAME'"),
        (GOOD + "  - {t: 1, move: crate}", "missing"),
        (GOOD + "  - {t: -1, remove: crate}", "expected 0"),
        (GOOD + "  - {t: 1, remove: crate, to: [0, 0]}", "not with 'remove'"),
        ("obstacles: [{name: a, size: [1.0e-16, 1]}]", "two lengths >= 0.02"),
        ("obstacles: [{name: a, size: [1, 1], height: 1.0e-9}]", "expected 0.02"),
        (GOOD + "  - {t: 1, add: crate, to: [0, 0]}", "stands there already"),
        (GOOD + "  - {t: 9.5, move: crate, to: [0, 0]}", "stands nowhere then"),
        (NOWHERE + "  - {reach: [0, 0], move: a, to: [0, 0]}", "stands nowhere then"),
    ],
)
def test_a_mistake_is_one_line_that_names_the_file(read, text, says):
    with pytest.raises(MapError, match=says) as error:
        read(text)
    assert "scenario.yaml" in str(error.value) and "\n" not in str(error.value)


def test_an_obstacle_off_the_map_is_refused(read):
    raster = load_world("arena", radius=0.41, margin=0.04).occupancy
    check_scenario(read(GOOD), raster, "s.yaml")
    with pytest.raises(MapError, match=r"\(50, 0\) m lies off the map"):
        check_scenario(read(GOOD + "  - {t: 1, add: pallet, to: [50, 0]}"), raster, "s.yaml")


def test_a_scenery_without_a_scenario_has_nothing_to_come():
    from mobius.world import Scenario

    scenery = Scenery(Scenario())
    assert scenery.areas == () and np.size(scenery.pending) == 0
