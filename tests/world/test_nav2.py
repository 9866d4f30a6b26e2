"""Nav2 maps are read as Nav2 reads them, and every mistake is one line."""

import numpy as np
import pytest
from PIL import Image

from mobius.errors import InvalidInput, MapError
from mobius.world.image import GreyImage, write_pgm
from mobius.world.nav2 import interpret, read_nav2, write_nav2
from mobius.world.occupancy import OccupancyMap

GOOD = """\
image: map.pgm
resolution: 0.05
origin: [-1.0, 2.0, 0.0]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.25
"""


def put(tmp_path, text=GOOD, grey=((254, 205), (0, 128), (254, 254))):
    write_pgm(tmp_path / "map.pgm", np.array(grey, dtype=np.uint8))
    path = tmp_path / "map.yaml"
    path.write_text(text)
    return path


def message(path):
    with pytest.raises(MapError) as caught:
        read_nav2(path)
    text = str(caught.value)
    assert "\n" not in text
    assert str(path.parent) in text
    return text


def read_as(grey, **how):
    how = {"mode": "trinary", "negate": False, "occupied_thresh": 0.65, "free_thresh": 0.25} | how
    shade = np.atleast_2d(np.array(grey, dtype=float)) / 255
    return interpret(GreyImage(shade, None, None), **how).tolist()[0]


def test_the_first_row_of_the_image_is_the_top_of_the_map(tmp_path):
    raster, _ = read_nav2(put(tmp_path))
    assert raster.shape == (3, 2)
    # image rows from the top: 254 205 / 0 128 / 254 254; p = 0.004, 0.196, 1, 0.498
    assert raster.occupancy.tolist() == [[0, 0], [100, -1], [0, 0]]
    assert raster.origin_M.tolist() == [-1.0, 2.0, 0.0]
    # the occupied pixel, second row from the bottom: x = -1 + 0.025, y = 2 + 0.075
    assert np.allclose(raster.pixel_centers()[raster.occupied], [[-0.975, 2.075]])


def test_trinary_thresholds_by_hand():
    # p = 1 - v/255:  89 -> 0.65098 > 0.65;  90 -> 0.64706;  191 -> 0.25098;  192 -> 0.24706 < 0.25
    assert read_as([0, 89, 90, 191, 192, 255]) == [100, 100, -1, -1, 0, 0]


def test_both_comparisons_are_strict():
    # p is exactly 1 for black and exactly 0 for white
    assert read_as([0, 255], occupied_thresh=1.0, free_thresh=0.0) == [-1, -1]


def test_the_grey_of_map_savers_is_unknown_to_ros1_and_free_to_nav2():
    # 205: p = 50/255 = 0.19608
    assert read_as([205], free_thresh=0.196) == [-1]
    assert read_as([205], free_thresh=0.25) == [0]


def test_negate_swaps_black_and_white():
    assert read_as([0, 90, 191, 255], negate=True) == [0, -1, 100, 100]


def test_scale_is_linear_between_the_thresholds():
    # p = 0.4 (v = 153), thresholds 0.2 and 0.7: 100 * 0.2 / 0.5 = 40
    # p = 0.6 (v = 102): 80;  p = 0.8 (v = 51): occupied;  p = 0 : free
    how = {"mode": "scale", "occupied_thresh": 0.7, "free_thresh": 0.2}
    assert read_as([153, 102, 51, 255], **how) == [40, 80, 100, 0]


def test_scale_rounds_halves_to_even():
    # p = 1 - 127.5/255 = 0.5 exactly; thresholds 0 and 4/5: 62.5 -> 62
    assert read_as([127.5], mode="scale", occupied_thresh=0.8, free_thresh=0.0) == [62]


def test_raw_takes_the_pixel_as_it_is_and_ignores_negate():
    assert read_as([0, 37, 100, 101, 255], mode="raw", negate=True) == [0, 37, 100, -1, -1]


def test_alpha_is_a_fourth_colour_in_trinary_and_hides_in_scale():
    shade, alpha = np.array([[0.0, 0.0]]), np.array([[1.0, 0.0]])
    grey = GreyImage(shade, alpha, None)
    how = {"negate": False, "occupied_thresh": 0.65, "free_thresh": 0.25}
    # opaque black: shade (0 + 0 + 0 + 1) / 4 = 0.25, p = 0.75; clear black: p = 1
    assert interpret(grey, mode="trinary", **how).tolist() == [[100, 100]]
    assert interpret(grey, mode="trinary", **how | {"occupied_thresh": 0.8}).tolist() == [[-1, 100]]
    assert interpret(grey, mode="scale", **how).tolist() == [[100, -1]]


def test_png_maps_are_read(tmp_path):
    path = put(tmp_path, GOOD.replace("map.pgm", "map.png"))
    Image.fromarray(np.array([[0, 255]], dtype=np.uint8)).save(tmp_path / "map.png")
    assert read_nav2(path)[0].occupancy.tolist() == [[100, 0]]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("0.05", "5e-2"),
        ("0.05", '"0.05"'),
        ("negate: 0", "negate: false"),
        ("[-1.0, 2.0, 0.0]", "\n  - -1\n  - 2\n  - 0"),
        ("free_thresh: 0.25", "free_thresh: 0.25  # a comment\nauthor: somebody\nframe: map"),
        ("image:", "mode: trinary\nimage:"),
    ],
)
def test_other_ways_of_writing_the_same_are_the_same(tmp_path, old, new):
    want, _ = read_nav2(put(tmp_path))
    got, _ = read_nav2(put(tmp_path, GOOD.replace(old, new)))
    assert np.array_equal(got.occupancy, want.occupancy)
    assert np.array_equal(got.origin_M, want.origin_M)
    assert got.resolution == want.resolution


@pytest.mark.parametrize(
    "values",
    [
        np.array([[-1, 0, 100], [100, 0, -1]]),
        np.array([[-1, 0, 37], [100, 99, 1]]),
        np.random.default_rng(1).choice([-1, 0, 100], (40, 30)),
    ],
)
def test_a_map_survives_being_written_and_read(tmp_path, values):
    was = OccupancyMap("m", values, 0.07, np.array([1.5, -2.25, 0.5]))
    write_nav2(tmp_path / "m.yaml", was, mobius={"cell": 0.4, "start": [1.0, 2.0]})
    now, notes = read_nav2(tmp_path / "m.yaml")
    assert np.array_equal(now.occupancy, was.occupancy)
    assert np.array_equal(now.origin_M, was.origin_M)
    assert now.resolution == was.resolution
    assert (notes.cell, notes.start, notes.goal) == (0.4, (1.0, 2.0), None)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["m.pgm", "m.yaml"]


def test_only_yaml_is_written(tmp_path):
    raster = OccupancyMap("m", np.zeros((1, 1)), 0.1, np.zeros(3))
    with pytest.raises(InvalidInput, match=r"\.yaml"):
        write_nav2(tmp_path / "m.pgm", raster)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        (
            "resolution",
            "resolutoin",
            "line 2, key 'resolutoin': unknown. Did you mean 'resolution'?",
        ),
        ("image", "Image", "Did you mean 'image'?"),
        ("negate: 0", "negat: 0", "Did you mean 'negate'?"),
        ("image: map.pgm\n", "", "line 1, key 'image': missing; add 'image: map.pgm'"),
        ("negate: 0\n", "", "key 'negate': missing; add 'negate: 0'"),
        ("image: map.pgm", "image: mpa.pgm", "Did you mean 'map.pgm'?"),
        ("image: map.pgm", "image:", "key 'image': expected a text"),
        ("0.05", "-0.05", "line 2, key 'resolution': expected more than 0, got -0.05"),
        ("0.05", "0", "expected more than 0"),
        ("0.05", "nan", "expected a number, got 'nan'"),
        ("0.05", "5 cm", "expected a number, got '5 cm'"),
        ("0.05", "50", "expected 0.001 to 10"),
        ("0.05", "[0.05]", "expected a number"),
        ("[-1.0, 2.0, 0.0]", "[-1.0, 2.0]", "line 3, key 'origin': expected 3 numbers"),
        ("[-1.0, 2.0, 0.0]", "[-1.0, 2.0, east]", "got 'east'"),
        ("[-1.0, 2.0, 0.0]", "here", "expected a list"),
        ("negate: 0", "negate: maybe", "expected 0, 1, true or false, got 'maybe'"),
        ("free_thresh: 0.25", "free_thresh: 0.7", "expected less than occupied_thresh (0.65)"),
        ("free_thresh: 0.25", "free_thresh: -0.1", "expected 0 to 1"),
        ("occupied_thresh: 0.65", "occupied_thresh: 65", "expected 0 to 1, got 65"),
        ("negate: 0", "mode: trinery\nnegate: 0", "Did you mean 'trinary'?"),
        ("negate: 0", "negate: 0\nnegate: 1", "line 5, key 'negate': written twice"),
        ("[-1.0, 2.0, 0.0]", "[-1.0, 2.0, 0.0", "line 4: not valid yaml"),
        ("negate: 0", "negate: 0\n\tmode: raw", "not valid yaml"),
        ("negate: 0", "mobuis: {cell: 1}\nnegate: 0", "Did you mean 'mobius'?"),
        ("negate: 0", "mobius: 3\nnegate: 0", "key 'mobius': expected 'key: value' lines"),
        (GOOD, "", "an empty file"),
        (GOOD, "- a\n- b\n", "something else"),
        (GOOD, "? [a, b]\n: c\n", "expected a plain key"),
        (GOOD, "[" * 1000, "not valid yaml"),
    ],
)
def test_a_mistake_in_the_yaml_is_one_line_with_place_and_fix(tmp_path, old, new, says):
    assert says in message(put(tmp_path, GOOD.replace(old, new)))


def test_a_missing_yaml_names_the_one_that_was_meant(tmp_path):
    put(tmp_path)
    assert "Did you mean 'map.yaml'?" in message(tmp_path / "mpa.yaml")


def test_an_image_given_as_the_yaml_is_told(tmp_path):
    put(tmp_path)
    assert "expected UTF-8 text" in message(tmp_path / "map.pgm")


def test_a_truncated_image_is_told_with_the_pixel(tmp_path):
    path = put(tmp_path)
    image = tmp_path / "map.pgm"
    image.write_bytes(image.read_bytes()[:-3])
    assert "map.pgm, pixel column 1, row 1 from the top: the file is truncated" in message(path)


def test_whatever_is_cut_or_changed_only_map_errors_come_out(tmp_path):
    shape = "{type: circle, center: [-1, 2], radius: 1, mode: crawl}"
    path = put(tmp_path, f"{GOOD}mobius: {{cell: 0.5, start: [0, 0], shapes: [{shape}]}}\n")
    read_nav2(path)
    rng = np.random.default_rng(0)
    refused = 0
    for file in (path, tmp_path / "map.pgm"):
        whole = file.read_bytes()
        broken = [whole[:k] for k in range(len(whole))]
        for _ in range(250):
            data = bytearray(whole)
            for at in rng.integers(0, len(data), rng.integers(1, 4)):
                data[at] = rng.choice([*b"\x00\xff:[]{}-#&*!'\"\n 9.", rng.integers(256)])
            broken.append(bytes(data))
        for data in broken:
            file.write_bytes(data)
            try:
                read_nav2(path)
            except MapError as error:
                refused += 1
                assert "\n" not in str(error)
        file.write_bytes(whole)
    assert refused > 250
