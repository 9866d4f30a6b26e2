"""Shapes hold the points they should."""

import numpy as np
import pytest

from mobius.world.shapes import Circle, Polygon, RaisedObject, Rectangle

POINTS = np.random.default_rng(0).uniform(-2, 2, (500, 2))


def test_a_circle_holds_what_is_nearer_than_its_radius():
    circle = Circle((1.0, 0.0), 2.0)
    assert circle.contains([[2.9, 0.0], [3.0, 0.0], [1.0, 1.99]]).tolist() == [True, False, True]


def test_a_polygon_does_not_mind_where_it_starts_nor_which_way_it_runs():
    corners = ((0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 0.3), (0.0, 1.5))
    want = Polygon(corners).contains(POINTS)
    for k in range(5):
        turned = corners[k:] + corners[:k]
        assert np.array_equal(Polygon(turned).contains(POINTS), want)
        assert np.array_equal(Polygon(turned[::-1]).contains(POINTS), want)
    assert Polygon(corners).area == -Polygon(corners[::-1]).area


def test_a_notched_polygon_by_hand():
    # a 2 x 2 square with a triangle cut from its top down to (1, 1)
    notched = Polygon(((0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (1.0, 1.0), (0.0, 2.0)))
    inside = notched.contains([[1.0, 0.9], [1.0, 1.1], [0.2, 1.7], [0.5, 1.6], [2.1, 1.0]])
    assert inside.tolist() == [True, False, True, False, False]
    assert notched.area == pytest.approx(3.0)


def test_a_turned_rectangle_is_the_polygon_of_its_corners():
    rectangle = Rectangle((0.3, -0.2), (2.0, 1.0), 0.6)
    corners = rectangle.to_map([[-1, -0.5], [1, -0.5], [1, 0.5], [-1, 0.5]])
    polygon = Polygon(tuple((float(x), float(y)) for x, y in corners))
    assert np.array_equal(rectangle.contains(POINTS), polygon.contains(POINTS))
    assert np.allclose(rectangle.to_local(rectangle.to_map(POINTS)), POINTS)


def test_growing_moves_every_edge_outward():
    square = Rectangle((0.0, 0.0), (1.0, 1.0))
    assert not square.contains([0.55, 0.55])
    assert square.contains([0.55, 0.55], grown=0.1)


def test_legs_stand_inside_the_board_at_its_corners():
    board = Rectangle((1.0, 2.0), (1.2, 0.4), 0.4)
    legs = RaisedObject(board, 0.4, 0.44, leg=0.1).legs
    assert len(legs) == 4
    # leg centres are half a leg from both edges: (0.6 - 0.05, 0.2 - 0.05)
    assert np.allclose(np.abs([board.to_local(leg.center) for leg in legs]), [0.55, 0.15])


def test_a_block_on_the_floor_and_a_board_on_the_wall_have_no_legs():
    board = Rectangle((0.0, 0.0), (1.0, 1.0))
    assert RaisedObject(board, 0.0, 0.4).legs == ()
    assert RaisedObject(board, 0.5, 0.6, leg=0.0).legs == ()
