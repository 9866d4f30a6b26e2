"""Bumps are smooth, as high as they say, and meet the floor."""

import numpy as np
import pytest

from mobius.world.shapes import Rectangle, RoughPatch
from mobius.world.terrain import SPACING, bumps


def patch(size=(1.6, 1.0), **options):
    return RoughPatch(Rectangle((0.0, 0.0), size), **options)


@pytest.mark.parametrize("size", [(1.6, 1.0), (0.05, 0.05), (0.3, 2.0)])
def test_the_edge_is_on_the_floor_and_the_highest_bump_at_the_amplitude(size):
    height = bumps(patch(size, amplitude=0.02))
    rim = np.concatenate([height[0], height[-1], height[:, 0], height[:, -1]])
    assert (rim == 0).all()
    assert height.max() == pytest.approx(0.02)
    assert height[1:-1, 1:-1].min() > 0


def test_rows_run_along_y():
    height = bumps(patch((1.6, 1.0)))
    # 1.6 / 0.04 + 1 and 1.0 / 0.04 + 1 samples
    assert height.shape == (26, 41)


def test_the_same_seed_gives_the_same_bumps_and_another_seed_others():
    assert np.array_equal(bumps(patch(seed=3)), bumps(patch(seed=3)))
    assert not np.allclose(bumps(patch(seed=3)), bumps(patch(seed=4)))


def test_slopes_are_gentle():
    # a bump of amplitude a and wavelength l has a slope of about 2 pi a / l = 0.42
    height = bumps(patch((2.0, 2.0), amplitude=0.02, wavelength=0.3))
    slopes = [np.abs(np.diff(height, axis=axis)).max() / SPACING for axis in (0, 1)]
    assert max(slopes) < 0.42


def test_longer_waves_are_smoother():
    rough, smooth = (bumps(patch((2.0, 2.0), wavelength=w)) for w in (0.15, 0.6))
    assert np.abs(np.diff(smooth, axis=1)).max() < np.abs(np.diff(rough, axis=1)).max()
