"""Height maps: heights, edges, errors, and that MuJoCo feels what the map says."""

import mujoco
import numpy as np
import pytest

from mobius.errors import InvalidInput
from mobius.model import robot
from mobius.world.ground import KINDS, SPACING, Ground, add_ground, build_ground, slope


def test_heights_between_samples_are_bilinear_and_zero_outside():
    g = Ground(np.array([[0.0, 1.0], [2.0, 3.0]]), (10.0, 20.0), spacing=2.0)
    np.testing.assert_allclose(g.at([[10, 20], [12, 20], [10, 22], [11, 21]]), [0, 1, 2, 1.5])
    np.testing.assert_allclose(g.at([[9.9, 20], [12.1, 21], [11, 22.1]]), 0)
    assert g.size == (2.0, 2.0)


@pytest.mark.parametrize("kind", KINDS)
def test_grounds_have_the_asked_amplitude_and_the_seed_decides(kind):
    amplitude = 0.2 if kind == "slope" else 0.05
    g = build_ground(kind, 8.0, 3, amplitude=amplitude)
    assert g.height.min() >= 0
    if kind == "slope":
        steep = np.abs(np.diff(g.height, axis=1)).max() / SPACING
        assert np.isclose(np.arctan(steep), amplitude)
    else:
        assert 0.045 < np.ptp(g.height) <= 0.05
        again = build_ground(kind, 8.0, 3, amplitude=amplitude)
        np.testing.assert_array_equal(g.height, again.height)
        assert (build_ground(kind, 8.0, 4, amplitude=amplitude).height != g.height).any()


def test_a_slope_has_a_flat_top():
    h = slope((121, 121), 0.2, top=1.0)
    assert np.isclose(h.max(), np.tan(0.2) * 2.5)
    top = h[50:71, 50:71]
    assert np.ptp(top) < 1e-12


def test_mistakes_are_told():
    with pytest.raises(InvalidInput, match="unknown kind 'hills'"):
        build_ground("hills", 8.0, 0)
    with pytest.raises(InvalidInput, match="size"):
        build_ground("bumps", 0.5, 0)
    with pytest.raises(InvalidInput, match="finite"):
        Ground(np.array([[0.0, np.nan], [0, 0]]), (0, 0))
    with pytest.raises(InvalidInput, match="2 x 2"):
        Ground(np.zeros((1, 5)), (0, 0))


def test_mujoco_feels_the_height_that_the_map_says():
    ground = build_ground("slope", 6.0, 0, amplitude=0.2)
    spec = robot.load_spec("feet")
    add_ground(spec, ground)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    geom = np.array([-1], dtype=np.int32)
    for x, y in ((-2.0, 0.1), (0.0, 0.0), (1.5, -1.1), (2.9, 2.0)):
        down = mujoco.mj_ray(
            model, data, np.array([x, y, 5.0]), np.array([0, 0, -1.0]), None, 1, -1, geom
        )
        if model.geom(int(geom[0])).name == "floor":
            assert 5.0 - down == pytest.approx(float(ground.at([x, y])), abs=2e-3)
