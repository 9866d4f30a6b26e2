"""Regions laid over a map at run time."""

import numpy as np
import pytest

from mobius.errors import MapError
from mobius.types import Mode
from mobius.world import load_world

ROBOT = {"radius": 0.41, "margin": 0.04}


@pytest.fixture
def lay(tmp_path):
    """The arena under a file of regions."""

    def lay(text):
        file = tmp_path / "regions.yaml"
        file.write_text(text)
        return load_world("arena", regions=file, **ROBOT)

    return lay


def test_a_region_forces_its_mode_on_the_cells_it_holds(lay):
    world = lay("shapes: [{type: rectangle, center: [1.2, 0], size: [1, 3], mode: biped}]")
    grid = world.grid
    forced = grid.center_of(np.argwhere(grid.allowed == Mode.BIPED.bit))
    assert len(forced) and (np.abs(forced[:, 0] - 1.2) < 0.5).all()
    assert len(world.regions) == 1


def test_rough_ground_and_shelves_come_along(lay):
    world = lay(
        "rough: [{center: [1, -1], size: [1, 1]}]\n"
        "raised: [{center: [0, -1.2], size: [0.4, 0.3], height: [0.3, 0.34]}]\n"
    )
    assert len(world.rough) == len(world.raised) == 1
    bare = load_world("arena", **ROBOT)
    assert world.grid.blocked.sum() > bare.grid.blocked.sum()  # the shelf is in the way


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("shape: []", "Did you mean 'shapes'"),
        ("shapes: []", "holds no region"),
        ("shapes: [{type: circle, center: [9, 9], radius: 1, mode: crawl}]", "no pixel of the map"),
        ("shapes: [{type: circle, center: [0, 0], radius: 1, mode: fly}]", "unknown value 'fly'"),
        ("start: [0, 0]", "unknown"),
    ],
)
def test_a_mistake_is_one_line_that_names_the_file(lay, text, says):
    with pytest.raises(MapError, match=says) as error:
        lay(text)
    assert "regions.yaml" in str(error.value) and "\n" not in str(error.value)


def test_it_may_not_contradict_the_map(tmp_path):
    file = tmp_path / "regions.yaml"
    file.write_text("shapes: [{type: circle, center: [5.8, 2.2], radius: 1, mode: biped}]")
    with pytest.raises(MapError, match="overlaps"):
        load_world("demo", regions=file, **ROBOT)
