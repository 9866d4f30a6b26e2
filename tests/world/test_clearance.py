"""Distances to obstacles are exact on the lattice and never promise too much."""

import numpy as np
import pytest

from mobius.world.clearance import Clearance

RNG = np.random.default_rng(3)


def true_distance(blocked, resolution, xy):
    """Distance from points (n, 2) to the nearest blocked square or to the outside."""
    h, w = blocked.shape
    rows, cols = np.nonzero(blocked)
    low = np.stack([cols, rows], axis=-1) * resolution
    gap = np.maximum(np.maximum(low - xy[:, None], xy[:, None] - (low + resolution)), 0.0)
    inside = np.stack([xy[:, 0], xy[:, 1], w * resolution - xy[:, 0], h * resolution - xy[:, 1]])
    edge = np.maximum(inside.min(axis=0), 0.0)
    return np.minimum(np.hypot(gap[..., 0], gap[..., 1]).min(axis=1, initial=np.inf), edge)


@pytest.fixture(params=[0.02, 0.15, 0.4])
def blocked(request):
    return RNG.random((14, 19)) < request.param


def test_one_pixel_by_hand():
    # 11 x 11 pixels of 0.1 m, the one that covers 0.5..0.6 is blocked
    blocked = np.zeros((11, 11), dtype=bool)
    blocked[5, 5] = True
    field = Clearance(blocked, 0.1)
    # beside it: 0.5 - 0.2; off its corner: a 3-4-5 triangle; near the edge of the map: 0.1
    at = field.at([[0.2, 0.55], [0.2, 0.1], [0.55, 0.55], [0.1, 0.1]])
    assert np.allclose(at, [0.2, 0.1, 0.0, 0.1])
    assert field.at([0.35, 0.3]) == pytest.approx(0.25)


def test_lattice_points_have_their_true_distance(blocked):
    field = Clearance(blocked, 0.1)
    i, j = np.indices(field.values.shape)
    xy = np.stack([j.ravel(), i.ravel()], axis=-1) * field.step
    assert np.allclose(field.values.ravel(), true_distance(blocked, 0.1, xy))
    assert np.allclose(field.at(xy), true_distance(blocked, 0.1, xy))


def test_other_points_are_never_promised_too_much(blocked):
    field = Clearance(blocked, 0.1)
    xy = RNG.uniform(-0.2, 2.1, (400, 2))
    true = true_distance(blocked, 0.1, xy)
    got = field.at(xy)
    assert (got <= true + 1e-12).all()
    assert (got >= true - 2 * np.sqrt(0.5) * field.step - 1e-12).all()


def test_lines_ahead_have_the_least_distance_along_them(blocked):
    field = Clearance(blocked, 0.1)
    samples = np.linspace(0.0, 0.5, 101)
    for axis in (0, 1):
        table = field.ahead(0.5, axis=axis)
        for i, j in RNG.integers(0, np.array(table.shape) - 11, (60, 2)):
            xy = np.tile([j * field.step, i * field.step], (101, 1))
            xy[:, axis] += samples
            assert table[i, j] == pytest.approx(true_distance(blocked, 0.1, xy).min())


def test_lines_that_leave_the_map_have_none():
    field = Clearance(np.zeros((6, 6), dtype=bool), 0.1)
    assert (field.ahead(0.3, axis=0)[:, -6:] == 0).all()
    assert (field.ahead(0.3, axis=1)[-6:] == 0).all()


def test_a_line_anywhere_is_never_promised_too_much(blocked):
    field = Clearance(blocked, 0.1)
    for a, b in RNG.uniform(0.1, 1.3, (40, 2, 2)):
        line = a + np.linspace(0, 1, 400)[:, None] * (b - a)
        assert field.along(a, b) <= true_distance(blocked, 0.1, line).min() + 1e-12
    assert field.along([0.7, 0.7], [0.7, 0.7]) <= float(field.at([0.7, 0.7]))


def test_an_open_floor_is_bounded_by_the_edge_of_the_map():
    field = Clearance(np.zeros((10, 20), dtype=bool), 0.5)
    assert field.values.max() == 2.5
    assert field.at([-1.0, 2.0]) == 0
