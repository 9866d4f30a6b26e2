"""Curves, contacts and torques are where the numbers say."""

import base64
import io
import re

import numpy as np
from PIL import Image

from mobius.view.charts import Line, bars_chart, heat_chart, line_chart, spans

T = np.linspace(0.0, 10.0, 11)


def polyline(svg):
    pairs = re.search(r'<polyline points="([^"]*)"', svg).group(1)
    return np.array([[float(v) for v in p.split(",")] for p in pairs.split()])


def box(svg):
    return [float(v) for v in re.search(r'data-box="([^"]*)"', svg).group(1).split()]


def test_a_rising_line_runs_from_lower_left_to_upper_right_of_its_box():
    svg = line_chart("Speed", "m/s", T, [Line("true", T, "true")], zero=True)
    left, right, top, bottom = box(svg)
    drawn = polyline(svg)
    np.testing.assert_allclose(drawn[0], [left, bottom], atol=0.05)
    assert drawn[-1, 0] == right
    # the axis ends 6 % of the span above the highest value
    np.testing.assert_allclose(drawn[-1, 1], bottom - (bottom - top) / 1.06, atol=0.05)


def test_every_axis_says_its_unit():
    svg = line_chart("Speed", "m/s", T, [Line("true", T, "true")])
    assert ">m/s</text>" in svg
    assert ">time [s]</text>" in svg
    assert 'aria-label="Speed [m/s] over time"' in svg


def test_every_curve_is_in_the_legend_under_its_style():
    svg = line_chart("v", "m/s", T, [Line("true", T, "true"), Line("a < b", -T, "belief")])
    assert re.findall(r'<i class="(\w+)"></i>([^<]*) <b>', svg) == [
        ("true", "true"),
        ("belief", "a &lt; b"),
    ]


def test_a_curve_with_no_finite_value_leaves_an_empty_figure():
    svg = line_chart("v", "m/s", T, [Line("true", np.full(11, np.nan), "true")])
    assert 'points=""' in svg


def test_spans_are_runs_of_true():
    flags = np.array([True, True, False, True, False, False, True])
    assert spans(flags) == [(0, 2), (3, 4), (6, 7)]
    assert spans(np.zeros(3, dtype=bool)) == []


def test_a_contact_is_drawn_for_as_long_as_it_lasts():
    # lane from x = 84 to x = 980 - 150 = 830 for 10 s: 74.6 px a second; on from 2 s to 5 s
    on = (T >= 2) & (T < 5)
    svg = bars_chart("Contacts", T, [("left arm", on, None, "30 %")])
    assert re.search(r'd="M233\.2 [\d.]+H457\.0V[\d.]+H233\.2z" class="on"', svg)
    assert "30 %" in svg and "left arm" in svg


def test_modes_are_a_band_of_their_colours():
    strip = ["crawl"] * 6 + ["biped"] * 5
    colours = {"crawl": "#000001", "biped": "#000002"}
    svg = bars_chart("Contacts", T, [], strip=strip, colours=colours)
    assert re.findall(r'<rect fill="(#\d+)"', svg) == ["#000001", "#000002"]
    assert ">crawl</text>" in svg and ">biped</text>" in svg


def test_torque_shows_as_opacity_the_largest_opaque():
    t = np.arange(4.0)
    # spans of two samples: sqrt((3^2 + 4^2)/2) = 3.536, sqrt((0 + 0)/2) = 0; and all 1
    values = np.array([[3.0, 1.0], [4.0, 1.0], [0.0, 1.0], [0.0, 1.0]])
    svg = heat_chart("Torque", "N m", t, values, ["a", "b"], remarks=["", ""], heads="", columns=2)
    data = re.search(r'href="data:image/png;base64,([^"]*)"', svg).group(1)
    alpha = np.array(Image.open(io.BytesIO(base64.b64decode(data))))[..., 3]
    # 255 * 1 / 3.536 = 72.1
    assert alpha.tolist() == [[255, 0], [72, 72]]
    assert "opaque: 3.54 N m" in svg
