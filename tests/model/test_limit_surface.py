"""The ellipsoid a grasp holds, and its draws."""

import numpy as np
import pytest

from mobius import paper
from mobius.errors import InvalidInput
from mobius.model.limit_surface import LimitSurface


def test_load_by_hand():
    """60/100 across, 16/20 along: 0.36 + 0.64 = 1, on the surface; 30/100 and 0.4: half way."""
    surface = LimitSurface(100.0, 20.0, 4.0)
    assert surface.load(60.0, 16.0) == pytest.approx(1.0)
    assert surface.load(-30.0, 8.0) == pytest.approx(0.5)
    assert surface.load(0.0, 0.0, 4.0) == pytest.approx(1.0)
    assert surface.holds(60.0, 15.9) and not surface.holds(60.0, 16.1)


def test_half_the_weight_is_held_across_the_groove_and_not_along_it():
    mean = LimitSurface()
    assert mean.holds(50.5) and not mean.holds(0.0, 50.5)


def test_draws_have_the_moments_of_table_ix_and_stay_positive():
    rng = np.random.default_rng(1)
    draws = [LimitSurface.draw(rng) for _ in range(20_000)]
    for axis, values in (("z", [d.F_across for d in draws]), ("x", [d.F_along for d in draws])):
        printed = paper.TABLE_IX[axis]
        assert np.mean(values) == pytest.approx(printed.mean, rel=0.01)
        assert np.std(values) == pytest.approx(printed.std, rel=0.02)
        assert min(values) > 0


def test_the_torsion_limit_holds_the_moment_of_fig_15b_under_half_the_weight():
    assert LimitSurface().holds(0.5 * paper.MASS * 9.81, 0.0, paper.PULL_UP.normal_moment[1])


def test_nonsense_is_refused():
    for bad in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(InvalidInput, match="three positive numbers"):
            LimitSurface(bad, 20.0, 4.0)
