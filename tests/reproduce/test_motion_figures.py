"""Figures 4 and 13 and the rails: geometry that can be checked by hand."""

import json

import numpy as np
import pytest

from mobius.errors import InvalidInput
from mobius.geometry import rpy_to_quat
from mobius.model import dimensions as dim
from mobius.reproduce import fig_4, fig_13, rails

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


def test_a_point_is_outside_its_support_by_its_distance_to_the_nearest_edge():
    assert fig_13.outside(np.array([0.5, 1.2]), SQUARE) == pytest.approx(0.2)
    assert fig_13.outside(np.array([0.4, 0.5]), SQUARE) == pytest.approx(-0.4)


def test_two_points_or_points_in_a_line_are_no_support():
    for points in (SQUARE[:2], np.array([[0.0, 0.0], [0.5, 0.0], [1.0, 0.0]]), SQUARE[:0]):
        assert np.isnan(fig_13.outside(np.array([0.5, 0.5]), points))


def test_the_course_is_told_along_the_heading(monkeypatch):
    from types import SimpleNamespace

    # facing along +y of M and nose up, as on two legs; it goes 1 m along y
    q = rpy_to_quat(0.0, -np.pi / 2, np.pi / 2)
    com = np.array([[5.0, 5.0, 0.4], [5.0, 6.0, 0.2]])
    footage = SimpleNamespace(
        t=np.array([2.0, 2.1]),
        qpos=np.array([[0, 0, 0, *q]] * 2),
        com=com,
        support=[com[:1, :2], com[1:, :2]],
    )
    course = fig_13.course_of(footage, (0, 1))
    np.testing.assert_allclose(course.com, [[0, 0], [1, 0]], atol=1e-9)
    np.testing.assert_allclose(course.support[1], [[1, 0]], atol=1e-9)
    np.testing.assert_allclose(course.t, [0, 0.1])


def test_a_rocker_rests_at_the_middle_and_climbs_over_its_end():
    # bob straight below the circle's centre, by 0.13 m
    z = dim.RAIL_TOP - dim.RAIL_RADIUS + 0.13
    r = rails.rocker((0.0, 0.0, z))
    assert r.below == pytest.approx(0.13)
    assert r.rest == pytest.approx(dim.RAIL_RADIUS + rails.TUBE - 0.13)
    a = np.arcsin(dim.RAIL_HALF_LENGTH / dim.RAIL_RADIUS)
    assert r.at_end == pytest.approx(dim.RAIL_RADIUS + rails.TUBE - 0.13 * np.cos(a))
    # law of cosines: centre to bob 0.13, centre to end 0.30
    reach = np.sqrt(0.13**2 + 0.3**2 - 2 * 0.13 * 0.3 * np.cos(a))
    assert r.top == pytest.approx(reach + rails.TUBE)
    assert r.rest < r.at_end < r.top and r.climb > r.climb_over_end > 0


def test_the_real_robot_rests_on_its_back_and_has_little_to_climb():
    r = rails.rocker(rails.com_of("supine"))
    assert r.below > 0.1 and 0.0 < r.climb < 0.03


def test_a_taller_trunk_reaches_higher_by_as_much():
    low, high = (fig_4.highest_tip(np.eye(3), np.array([0, 0, z]), count=5) for z in (0.2, 0.5))
    assert high - low == pytest.approx(0.3)


def test_on_two_legs_everything_is_higher_than_on_four():
    crawl, biped = fig_4.heights("crawl"), fig_4.heights("biped")
    for name in ("trunk", "top_trunk", "tip"):
        assert getattr(biped, name) > getattr(crawl, name)
    for h in (crawl, biped):
        assert h.tip > h.top_trunk > h.trunk


def test_the_speed_of_a_mode_is_its_fastest_straight_command(tmp_path):
    means = {"forward": [0.6, 0.0, 0], "backward": [-0.7, 0, 0], "left": [0, 0.1, 0]}
    commands = {k: {"mean": v} for k, v in {**means, "right": [0, -0.1, 9.0]}.items()}
    (tmp_path / "crawl.json").write_text(json.dumps({"tracking": {"commands": commands}}))
    assert fig_4.fastest(tmp_path, "crawl") == pytest.approx(0.7)
    with pytest.raises(InvalidInput, match="--results"):
        fig_4.fastest(tmp_path, "biped")
    (tmp_path / "biped.json").write_text("{}")
    with pytest.raises(InvalidInput, match="expected the results"):
        fig_4.fastest(tmp_path, "biped")


def test_a_rolls_speed_is_that_of_its_trials(tmp_path):
    with pytest.raises(InvalidInput, match=r"benchmarks/motions\.py roll"):
        fig_4.roll_speed(tmp_path)
    (tmp_path / "motions.json").write_text('{"motions": {"roll": {"speed_mps": 0.7}}}')
    assert fig_4.roll_speed(tmp_path) == pytest.approx(0.7)
    (tmp_path / "motions.json").write_text('{"motions": {}}')
    with pytest.raises(InvalidInput, match="expected rolls"):
        fig_4.roll_speed(tmp_path)
