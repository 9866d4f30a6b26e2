"""The way through key poses against scipy's PCHIP, which it must equal."""

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from mobius.modes.motions.way import Way


@pytest.mark.parametrize("seed", range(20))
def test_it_is_pchip(seed: int):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(int(rng.integers(3, 9)), 5)).round(1)
    peer = PchipInterpolator(np.linspace(0.0, 1.0, len(points)), points, axis=0)
    way = Way(points)
    for share in np.linspace(0.0, 1.0, 41):
        np.testing.assert_allclose(way.at(share), peer(share), atol=1e-12)


def test_it_never_leaves_the_band_between_neighbours():
    points = np.array([[0.0], [1.0], [1.0], [0.2], [3.0]])
    values = np.array([Way(points).at(s)[0] for s in np.linspace(0, 1, 401)])
    for i in range(4):
        part = values[100 * i : 100 * i + 101]
        assert part.min() >= points[i : i + 2].min() - 1e-12
        assert part.max() <= points[i : i + 2].max() + 1e-12
