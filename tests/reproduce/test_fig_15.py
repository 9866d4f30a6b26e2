"""Fig. 15: what is claimed of the ellipsoid, and the law's response."""

import numpy as np
import pytest

from mobius import paper
from mobius.model.robot import joint_limits
from mobius.reproduce.fig_15 import PULLED, draw, ellipsoid_at, hang, push_response, rows


@pytest.fixture(scope="module")
def response():
    return push_response()


@pytest.mark.parametrize("place", [(0.42, 0.10), PULLED])
def test_the_poses_are_within_the_joints_ranges(place):
    q, (low, high) = hang(place), joint_limits()
    assert ((q > low[:6]) & (q < high[:6])).all()


def test_hanging_the_arm_is_strongest_along_the_pull():
    e = ellipsoid_at(hang())
    assert e.reach[0] > 5 * e.reach[1]
    assert e.reach[0] > 10 * e.reach[2]  # N against N m, as the paper draws them


def test_the_push_moves_the_arm_down_and_it_comes_back(response):
    r = response
    y = r.x[:, 1]
    assert y.min() == pytest.approx(-0.038, abs=0.003)
    back = y[np.searchsorted(r.t, 6.0)]  # 3 s later, with D / K = 1 s
    assert back == pytest.approx(y.min() * np.exp(-3.0), rel=0.02)
    np.testing.assert_allclose(r.x[-1, :2], paper.PULL_UP.reference[:2], atol=1e-3)


def test_the_offset_in_z_is_the_compromise_of_stiffness_and_spring(response):
    """K (x - x_ref) = -k x: x = -0.12 * 250 / 310 = -0.0968 m."""
    assert response.x[-1, 2] == pytest.approx(-0.12 * 250 / 310, abs=2e-4)


def test_it_draws_and_tells(tmp_path, response):
    table = rows(response)
    assert all(set(row) == {"what", "ours", "paper"} for row in table)
    draw(tmp_path / "fig.png", response)
    assert (tmp_path / "fig.png").stat().st_size > 20_000
