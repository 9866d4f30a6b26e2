"""The pieces the figures are made of."""

import base64
import io

import numpy as np
import pytest
from PIL import Image

from mobius.view.svg import Axis, number, png_data, points, tag, text, thin, ticks


def test_attributes_and_text_are_escaped():
    assert tag("a", x='"<') == '<a x="&quot;&lt;"></a>'
    assert "&lt;b&gt;" in text(0, 0, "<b>")


def test_attribute_names_become_those_of_svg_and_none_is_left_out():
    written = tag("line", class_="x", stroke_width=1.5, data_box=None)
    assert written == '<line class="x" stroke-width="1.50"></line>'


@pytest.mark.parametrize(
    ("value", "shown"),
    [(0.12345, "0.123"), (12.345, "12.3"), (1234.5, "1234"), (0.0, "0"), (7, "7"),
     (12345, "12\u202f345"), (True, "yes"), (1.5e-7, "1.50e-07"), (float("nan"), "not finite"),
     ("x", "x")],
)  # fmt: skip
def test_numbers_are_written_for_reading(value, shown):
    assert number(value) == shown


def test_ticks_are_round_and_inside():
    # span 8.2 over 5 intervals is 1.64 each, the next round step is 2
    assert ticks(0.0, 8.2, most=5) == [0.0, 2.0, 4.0, 6.0, 8.0]
    # span 0.04 over 5 is 0.008, the next round step is 0.01
    assert ticks(-0.02, 0.02, most=5) == [-0.02, -0.01, 0.0, 0.01, 0.02]


@pytest.mark.parametrize("span", [1e-6, 0.3, 7.0, 9.99, 123456.0])
def test_there_are_never_too_many_ticks(span):
    found = ticks(-0.37 * span, 0.63 * span, most=6)
    assert 2 <= len(found) <= 7
    assert min(found) >= -0.37 * span * (1 + 1e-9)
    assert max(found) <= 0.63 * span * (1 + 1e-9)


def test_thinning_keeps_every_peak_and_the_order_of_time():
    t = np.arange(10_000) / 60
    y = np.zeros(10_000)
    y[3333], y[7777] = 5.0, -4.0
    at, kept = thin(t, y, bins=200)
    assert len(at) <= 400
    assert (np.diff(at) > 0).all()
    assert kept.max() == 5.0 and kept.min() == -4.0
    assert at[np.argmax(kept)] == t[3333]


def test_short_series_are_not_thinned_and_what_is_not_finite_is_left_out():
    t = np.arange(4.0)
    at, kept = thin(t, np.array([1.0, np.nan, 3.0, np.inf]))
    assert at.tolist() == [0.0, 2.0]
    assert kept.tolist() == [1.0, 3.0]


def test_an_axis_maps_its_ends_onto_its_pixels():
    axis = Axis(2.0, 4.0, 100.0, 50.0)
    np.testing.assert_allclose(axis(np.array([2.0, 3.0, 4.0])), [100.0, 75.0, 50.0])


def test_an_axis_without_a_span_gets_one_around_its_value():
    axis = Axis(2.0, 2.0, 0.0, 100.0)
    assert float(axis(np.float64(2.0))) == 50.0


def test_points_have_one_decimal():
    assert points([1.04, 2.0], [3.06, 4.0]) == "1.0,3.1 2.0,4.0"


def test_a_picture_travels_without_loss():
    pixels = np.random.default_rng(0).integers(0, 255, size=(5, 7, 4), dtype=np.uint8)
    head, data = png_data(pixels).split(",")
    assert head == "data:image/png;base64"
    back = np.array(Image.open(io.BytesIO(base64.b64decode(data))))
    np.testing.assert_array_equal(back, pixels)
