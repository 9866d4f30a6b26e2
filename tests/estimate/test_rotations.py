"""The float rotations are those of mobius.geometry."""

import numpy as np
import pytest

from mobius import geometry
from mobius.estimate.rotations import exp_so3, left_jacobian, small_log, yaw_of

SIZES = (0.0, 1e-9, 1e-3, 0.0099, 0.0101, 0.3, 2.5)


def vectors(size: float) -> np.ndarray:
    v = np.random.default_rng(0).normal(size=(5, 3))
    return size * v / np.linalg.norm(v, axis=1, keepdims=True)


@pytest.mark.parametrize("size", SIZES)
def test_exp_is_geometry_s(size):
    for v in vectors(size):
        assert exp_so3(*v.tolist()) == pytest.approx(geometry.exp_so3(v), abs=1e-12)


@pytest.mark.parametrize("size", SIZES)
def test_left_jacobian_is_the_mean_of_the_turns_on_the_way(size):
    # J = int_0^1 exp(s phi) ds, by Gauss-Legendre
    nodes, weights = np.polynomial.legendre.leggauss(12)
    for v in vectors(size):
        turns = [geometry.exp_so3(0.5 * (1 + x) * v) for x in nodes]
        mean = sum(0.5 * w * R for w, R in zip(weights, turns, strict=True))
        assert left_jacobian(*v.tolist()) == pytest.approx(mean, abs=1e-11)


@pytest.mark.parametrize("size", [0.0, 0.01, 0.1, 0.5])
def test_small_log_undoes_exp(size):
    for v in vectors(size):
        assert small_log(geometry.exp_so3(v)) == pytest.approx(v, abs=1e-9 + 0.1 * size**7)


def test_yaw_of_a_turn_about_z_is_its_angle():
    for yaw in (-3.0, -0.5, 0.0, 1.0, 3.1):
        assert yaw_of(geometry.exp_so3([0.0, 0.0, yaw])) == pytest.approx(yaw)
