"""Grey images: what is read, and what damaged ones say."""

import numpy as np
import pytest
from PIL import Image

from mobius.errors import MapError
from mobius.world.image import read_image, write_pgm

LEVELS = np.array([[0, 100, 255], [1, 2, 3]])


def message(path):
    with pytest.raises(MapError) as caught:
        read_image(path)
    text = str(caught.value)
    assert "\n" not in text
    assert str(path) in text
    return text


def put(tmp_path, data):
    path = tmp_path / "map.pgm"
    path.write_bytes(data)
    return path


def test_what_is_written_is_read_back(tmp_path):
    path = tmp_path / "a.pgm"
    write_pgm(path, LEVELS.astype(np.uint8))
    assert np.array_equal(read_image(path).levels, LEVELS)
    assert [p.name for p in tmp_path.iterdir()] == ["a.pgm"]


@pytest.mark.parametrize(
    "data",
    [
        b"P5\n3 2\n255\n" + bytes([0, 100, 255, 1, 2, 3]),
        b"P5 # drawn by hand\n# two rows\n3 2 255 " + bytes([0, 100, 255, 1, 2, 3]),
        b"P2\n3 2\n255\n0 100 255\n1 2 3\n",
        b"P2 3 2 # size\n255\n0 100 255 1 2 3",
    ],
)
def test_binary_and_text_pgm_with_comments_are_the_same_image(tmp_path, data):
    image = read_image(put(tmp_path, data))
    assert np.array_equal(image.levels, LEVELS)
    assert np.allclose(image.shade, LEVELS / 255)
    assert image.alpha is None


def test_a_deep_pgm_is_scaled_by_its_own_maximum(tmp_path):
    # 0x0064 = 100 and 0x03E8 = 1000 of 1000
    image = read_image(put(tmp_path, b"P5 2 1 1000 " + bytes([0, 100, 3, 232])))
    assert image.shade.tolist() == [[0.1, 1.0]]


def test_png_of_every_kind_gives_the_mean_of_its_colours(tmp_path):
    path = tmp_path / "a.png"
    for mode, pixel, shade in (
        ("L", 51, 0.2),
        ("RGB", (0, 51, 255), 0.4),
        ("RGBA", (255, 255, 255, 51), 1.0),
        ("LA", (51, 255), 0.2),
        ("1", 1, 1.0),
    ):
        Image.new(mode, (2, 1), pixel).save(path)
        image = read_image(path)
        assert np.allclose(image.shade, shade), mode
        assert (image.alpha is not None) == mode.endswith("A"), mode
    Image.new("RGBA", (1, 1), (9, 9, 9, 51)).save(path)
    assert read_image(path).alpha.tolist() == [[0.2]]


def test_a_palette_image_gives_its_indices(tmp_path):
    image = Image.new("P", (2, 1))
    image.putpalette([0, 0, 0, 255, 0, 0, 0, 255, 0])
    image.putdata([2, 1])
    image.save(tmp_path / "a.png")
    assert read_image(tmp_path / "a.png").levels.tolist() == [[2, 1]]


def test_a_deep_png_is_scaled_to_one(tmp_path):
    Image.fromarray(np.array([[0, 65535]], dtype=np.uint16)).save(tmp_path / "a.png")
    assert read_image(tmp_path / "a.png").shade.tolist() == [[0.0, 1.0]]


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"", "an empty file"),
        (b"JFIF whatever", "expected a PGM"),
        (b"P6\n1 1\n255\nabc", "expected a PGM"),
        (b"P5\n3", "height"),
        (b"P5\n3 x 255\n", "height"),
        (b"P5\n3 2\n", "maximum value"),
        (b"P5\n3 0 255\n", "expected 1 to"),
        (b"P5\n99999 99999 255\n", "expected 1 to"),
        (b"P5\n3 2 0\n", "maximum value of 1"),
        (b"P5\n3 2\n255\nabcd", "pixel column 1, row 1 from the top: the file is truncated"),
        (b"P5\n3 2\n255\nabcdefgh", "more data"),
        (b"P2\n3 2\n255\n1 2 3 4", "truncated"),
        (b"P2\n3 2\n255\n1 2 3 4 x 6", "pixel column 1, row 1 from the top"),
        (b"P2\n3 2\n255\n1 2 3 4 5 6 7", "nothing more"),
        (b"P2\n3 2\n9\n1 2 3 4 10 6", "value 10 is above"),
    ],
)
def test_a_damaged_pgm_is_one_line_that_names_the_place(tmp_path, data, says):
    assert says in message(put(tmp_path, data))


def test_a_missing_image_names_the_one_that_was_meant(tmp_path):
    write_pgm(tmp_path / "depot.pgm", LEVELS.astype(np.uint8))
    assert "Did you mean 'depot.pgm'?" in message(tmp_path / "dpeot.pgm")


def test_a_folder_is_no_image(tmp_path):
    assert "cannot be read" in message(tmp_path)


def test_every_cut_and_every_flipped_byte_of_a_png_is_one_error_or_the_same_image(tmp_path):
    path = tmp_path / "a.png"
    Image.fromarray(np.arange(48, dtype=np.uint8).reshape(6, 8)).save(path)
    whole, image = path.read_bytes(), read_image(path).levels
    for cut in range(len(whole) - 12):  # what follows is the empty chunk that ends the file
        path.write_bytes(whole[:cut])
        message(path)
    for at in range(len(whole)):
        path.write_bytes(whole[:at] + bytes([whole[at] ^ 0x55]) + whole[at + 1 :])
        try:
            assert np.array_equal(read_image(path).levels, image)
        except MapError as error:
            assert "\n" not in str(error)
