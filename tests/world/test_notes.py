"""The key ``mobius:``: what it may say, and what it answers to mistakes."""

import numpy as np
import pytest
from PIL import Image

from mobius.errors import MapError
from mobius.types import Mode
from mobius.world.image import write_pgm
from mobius.world.nav2 import read_nav2
from mobius.world.shapes import Circle, Polygon, Rectangle

HEAD = """\
image: map.pgm
resolution: 0.5
origin: [0, 0, 0]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.25
mobius:
"""


def read(tmp_path, *lines):
    write_pgm(tmp_path / "map.pgm", np.full((8, 10), 254, dtype=np.uint8))
    path = tmp_path / "map.yaml"
    path.write_text(HEAD + "".join(f"  {line}\n" for line in lines))
    return read_nav2(path)


def message(tmp_path, *lines):
    with pytest.raises(MapError) as caught:
        read(tmp_path, *lines)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_everything_it_may_say(tmp_path):
    raster, notes = read(
        tmp_path,
        "cell: 0.25",
        "start: [1, 2]",
        "goal: [4, 3]",
        "shapes:",
        "- {type: circle, frame_id: map, center: [1, 1], radius: 0.8, fill: true, mode: crawl}",
        "- {type: polygon, points: [3, 0, 4, 0, 4, 1], closed: true, mode: [crawl, biped]}",
        "- {type: rectangle, center: [4, 3], size: [1, 1], yaw: 0.1, value: 100}",
        "rough:",
        "- {center: [2, 2], size: [1, 1], amplitude: 0.02, wavelength: 0.2, seed: 3}",
        "raised:",
        "- {center: [2, 3], size: [1, 0.5], height: [0.4, 0.44]}",
    )
    assert (notes.cell, notes.start, notes.goal) == (0.25, (1.0, 2.0), (4.0, 3.0))
    circle, polygon = notes.regions
    assert circle.geometry == Circle((1.0, 1.0), 0.8)
    assert circle.modes == (Mode.CRAWL,)
    assert polygon.geometry == Polygon(((3.0, 0.0), (4.0, 0.0), (4.0, 1.0)))
    assert polygon.bits == Mode.CRAWL.bit | Mode.BIPED.bit
    assert notes.rough[0].area == Rectangle((2.0, 2.0), (1.0, 1.0))
    assert (notes.rough[0].amplitude, notes.rough[0].seed) == (0.02, 3)
    assert (notes.raised[0].bottom, notes.raised[0].top) == (0.4, 0.44)
    assert raster.occupancy.max() == 100


def test_a_stamp_writes_its_value_on_the_pixels_whose_centre_it_holds(tmp_path):
    # pixels of 0.5 m: centres at 0.25, 0.75, 1.25, ...; the square 0.5..1.5 holds 2 x 2
    raster, _ = read(
        tmp_path, "shapes: [{type: rectangle, center: [1, 1], size: [1, 1], value: 100}]"
    )
    assert np.argwhere(raster.occupied).tolist() == [[1, 1], [1, 2], [2, 1], [2, 2]]


def test_later_stamps_overwrite_earlier_ones(tmp_path):
    raster, _ = read(
        tmp_path,
        "shapes:",
        "- {type: rectangle, center: [1, 1], size: [1, 1], value: 100}",
        "- {type: circle, center: [0.75, 0.75], radius: 0.1, value: -1}",
    )
    assert raster.occupancy[1, 1] == -1
    assert raster.occupied.sum() == 3


def test_regions_that_agree_may_overlap(tmp_path):
    _, notes = read(
        tmp_path,
        "shapes:",
        "- {type: circle, center: [2, 2], radius: 1, mode: crawl}",
        "- {type: circle, center: [2.5, 2], radius: 1, mode: crawl}",
    )
    assert len(notes.regions) == 2


def test_regions_that_differ_may_not_overlap(tmp_path):
    text = message(
        tmp_path,
        "shapes:",
        "- {type: circle, center: [2, 2], radius: 1, mode: crawl}",
        "- {type: circle, center: [3, 2], radius: 1, mode: biped}",
    )
    assert "line 10, key 'mobius.shapes[1]': admits biped but overlaps" in text
    assert "line 9, key 'mobius.shapes[0]', which admits crawl, at (2.25, 1.75) m" in text


def test_a_region_image_is_read_by_its_legend(tmp_path):
    levels = np.zeros((8, 10), dtype=np.uint8)
    levels[0, 3], levels[7, 0] = 1, 2  # the top row is the map's last
    Image.fromarray(levels).save(tmp_path / "regions.png")
    _, notes = read(tmp_path, "regions: regions.png", "legend: {1: crawl, 2: [biped, roll]}")
    assert notes.region_bits[7, 3] == Mode.CRAWL.bit
    assert notes.region_bits[0, 0] == Mode.BIPED.bit | Mode.ROLL.bit
    assert (notes.region_bits == 7).sum() == 78


def test_a_region_image_and_a_shape_that_differ_may_not_overlap(tmp_path):
    Image.fromarray(np.ones((8, 10), dtype=np.uint8)).save(tmp_path / "regions.png")
    shape = "shapes: [{type: circle, center: [2, 2], radius: 1, mode: biped}]"
    assert "overlaps the image, which admits crawl" in message(
        tmp_path, "regions: regions.png", "legend: {1: crawl}", shape
    )


@pytest.mark.parametrize(
    ("shape", "legend", "says"),
    [
        ((8, 10), "{2: biped}", "pixel column 0, row 0 from the top: grey 1 is not in the legend"),
        ((4, 10), "{1: crawl}", "expected an image of 10 x 8 pixels like the map's, got 10 x 4"),
        ((8, 10), "{1: crall}", "Did you mean 'crawl'?"),
        ((8, 10), "{one: crawl}", "expected a grey value"),
        ((8, 10), "{0: crawl}", "expected a grey value"),
    ],
)
def test_mistakes_in_a_region_image(tmp_path, shape, legend, says):
    Image.fromarray(np.ones(shape, dtype=np.uint8)).save(tmp_path / "regions.png")
    assert says in message(tmp_path, "regions: regions.png", f"legend: {legend}")


def test_a_region_image_of_colours_is_refused(tmp_path):
    Image.new("RGB", (10, 8)).save(tmp_path / "regions.png")
    text = message(tmp_path, "regions: regions.png", "legend: {1: crawl}")
    assert "expected a grey or palette image" in text


@pytest.mark.parametrize(
    ("lines", "says"),
    [
        (["cells: 0.5"], "line 8, key 'mobius.cells': unknown. Did you mean 'cell'?"),
        (["cell: 0"], "expected more than 0"),
        (["start: 1"], "expected a list of numbers such as [1.0, 2.0]"),
        (["goal: [1, 2, 3]"], "expected 2 numbers"),
        (["regions: regions.png"], "has no legend"),
        (["legend: {1: crawl}"], "has no image"),
        (["regions: r.png", "legend: {1: crawl}"], "r.png: the image is missing"),
        (["shapes: {type: circle}"], "expected a list of mappings"),
        (["shapes: [{radius: 1}]"], "key 'mobius.shapes[0].type': missing"),
        (["shapes: [{type: disc, mode: crawl}]"], "unknown value 'disc'"),
        (["shapes: [{type: circle, center: [1, 1], mode: crawl}]"], "radius': missing"),
        (["shapes: [{type: circle, center: [1, 1], radius: 1}]"], "not neither"),
        (
            ["shapes: [{type: circle, center: [1, 1], radius: 1, mode: crawl, value: 100}]"],
            "not both",
        ),
        (
            ["shapes: [{type: circle, center: [1, 1], radius: 1, mode: crwal}]"],
            "key 'mobius.shapes[0].mode': unknown value 'crwal'. Did you mean 'crawl'?",
        ),
        (["shapes: [{type: circle, center: [1, 1], radius: 1, mode: climb}]"], "Known: crawl"),
        (["shapes: [{type: circle, center: [1, 1], radius: 1, mode: []}]"], "got an empty list"),
        (["shapes: [{type: circle, center: [1, 1], radius: 1, value: 101}]"], "expected -1 to 100"),
        (["shapes: [{type: circle, center: [1, 1], radius: 1, value: 2.5}]"], "whole number"),
        (
            ["shapes: [{type: circle, center: [1, 1], radius: 1, points: [0, 0], mode: crawl}]"],
            "a circle has none",
        ),
        (
            ["shapes: [{type: circle, center: [1, 1], radius: 1, fill: false, mode: crawl}]"],
            "outlines are not supported",
        ),
        (
            ["shapes: [{type: circle, frame_id: odom, center: [1, 1], radius: 1, mode: crawl}]"],
            "unknown value 'odom'",
        ),
        (["shapes: [{type: polygon, points: [0, 0, 1], mode: crawl}]"], "pairs of numbers"),
        (["shapes: [{type: polygon, points: [0, 0, 1, 1], mode: crawl}]"], "at least 3 corners"),
        (
            ["shapes: [{type: polygon, points: [0, 0, 1, 1, 2, 2], mode: crawl}]"],
            "at least 3 corners around some area",
        ),
        (
            ["shapes: [{type: circle, center: [99, 1], radius: 1, mode: crawl}]"],
            "covers no pixel of the map",
        ),
        (
            ["shapes: [{type: circle, center: [99, 1], radius: 1, value: 100}]"],
            "covers no pixel of the map",
        ),
        (["rough: [{center: [1, 1], size: [1, -1]}]"], "expected two lengths > 0"),
        (["rough: [{center: [1, 1], size: [1, 1], amplitude: 3}]"], "to 0.2, got 3"),
        (["rough: [{center: [1, 1], size: [1, 1], height: 3}]"], "unknown"),
        (["raised: [{center: [1, 1], size: [1, 1], height: [0.5, 0.4]}]"], "underside < top"),
        (["raised: [{center: [1, 1], size: [1, 1]}]"], "height': missing"),
    ],
)
def test_a_mistake_is_one_line_with_place_and_fix(tmp_path, lines, says):
    assert says in message(tmp_path, *lines)
