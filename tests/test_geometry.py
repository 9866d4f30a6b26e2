"""Rotations and frames: identities first, then one figure of the paper."""

import numpy as np
import pytest

from mobius import geometry as geo
from mobius.errors import InvalidInput
from mobius.types import GridMap, Mode, Plan, Pose, StateEstimate

RNG = np.random.default_rng(0)


def quaternions(n: int) -> np.ndarray:
    q = RNG.normal(size=(n, 4))
    return q / np.linalg.norm(q, axis=1, keepdims=True)


def test_rotate_agrees_with_the_matrix_one_by_one_and_in_batches():
    q, v = quaternions(50), RNG.normal(size=(50, 3))
    batch = geo.rotate(q, v)
    np.testing.assert_allclose(batch, np.einsum("nij,nj->ni", geo.quat_to_mat(q), v), atol=1e-12)
    for k in range(50):
        np.testing.assert_allclose(geo.rotate(q[k], v[k]), batch[k], atol=1e-12)
        np.testing.assert_allclose(geo.quat_to_mat(q[k]), geo.quat_to_mat(q)[k], atol=1e-12)


def test_product_of_quaternions_is_product_of_matrices():
    a, b = quaternions(20), quaternions(20)
    product = geo.quat_to_mat(geo.quat_mul(a, b))
    np.testing.assert_allclose(product, geo.quat_to_mat(a) @ geo.quat_to_mat(b), atol=1e-12)


def test_matrix_to_quaternion_and_back():
    for q in [*quaternions(50), [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]:
        R = geo.quat_to_mat(np.array(q, dtype=float))
        np.testing.assert_allclose(geo.quat_to_mat(geo.mat_to_quat(R)), R, atol=1e-12)


def test_exp_and_log_undo_one_another():
    for _ in range(50):
        phi = RNG.normal(size=3)
        phi *= RNG.uniform(0, 3.1) / np.linalg.norm(phi)
        np.testing.assert_allclose(geo.log_so3(geo.exp_so3(phi)), phi, atol=1e-9)
    np.testing.assert_allclose(geo.exp_so3(np.zeros(3)), np.eye(3))


def test_roll_pitch_yaw_round_trip():
    rpy = RNG.uniform(-1.5, 1.5, (30, 3))
    np.testing.assert_allclose(geo.quat_to_rpy(geo.rpy_to_quat(*rpy.T)), rpy, atol=1e-9)


def test_cross_equals_numpy():
    a, b = RNG.normal(size=(2, 7, 3))
    np.testing.assert_allclose(geo.cross(a, b), np.cross(a, b))
    np.testing.assert_allclose(geo.skew(a) @ b[..., None], np.cross(a, b)[..., None])


def test_paper_axes_round_trip_and_are_right_handed():
    v = RNG.normal(size=(5, 3))
    np.testing.assert_allclose(geo.base_to_paper(geo.paper_to_base(v)), v)
    assert np.linalg.det(geo.R_BS) == pytest.approx(1.0)


def test_sideways_target_of_fig_17():
    """ "Sideways, x = -0.1 m/s" in the paper's axes is 0.1 m/s to the left here."""
    np.testing.assert_allclose(geo.paper_to_base([-0.1, 0, 0]), [0, 0.1, 0], atol=1e-15)


def test_heading_of_an_upright_trunk_is_where_the_belly_looks():
    """Pitched by -90 deg the head is up (+x_B up) and -z_B looks forward (+x_O)."""
    upright = geo.rpy_to_quat(0.0, -np.pi / 2, 0.0)
    np.testing.assert_allclose(geo.rotate(upright, np.array([1.0, 0, 0])), [0, 0, 1], atol=1e-12)
    np.testing.assert_allclose(geo.heading_axis("biped", upright), [1, 0, 0], atol=1e-12)
    turned = geo.quat_mul(geo.rpy_to_quat(0.0, 0.0, 0.7), upright)
    assert geo.heading_yaw("biped", turned) == pytest.approx(0.7)
    assert geo.heading_yaw("crawl", geo.rpy_to_quat(0.0, 0.0, 0.7)) == pytest.approx(0.7)


def test_messages_are_frozen_checked_and_read_only():
    pose = Pose([1, 2, 3], [1, 0, 0, 0])
    with pytest.raises(ValueError, match="read-only"):
        pose.p[0] = 5
    with pytest.raises(AttributeError):
        pose.p = np.zeros(3)  # type: ignore[misc]
    with pytest.raises(InvalidInput, match=r"Pose.p: expected shape \(3,\), got \(2,\)"):
        Pose([1, 2], [1, 0, 0, 0])
    with pytest.raises(InvalidInput, match="unit quaternion"):
        Pose([1, 2, 3], [2, 0, 0, 0])
    with pytest.raises(InvalidInput, match="finite"):
        Pose([1, np.nan, 3], [1, 0, 0, 0])
    with pytest.raises(InvalidInput, match=r"StateEstimate.contact: expected shape \(4,\)"):
        StateEstimate(0.0, np.zeros(3), [1, 0, 0, 0], np.zeros(3), np.zeros(3), np.zeros(3))


def test_grid_cells_and_metres():
    """A grid turned by 90 deg at (1, 2): cell (0, 0)'s centre is a quarter left and up."""
    shape = (4, 3)
    grid = GridMap("t", 0.5, [1, 2, np.pi / 2], np.zeros(shape, bool), np.full(shape, 7, np.uint8))
    np.testing.assert_allclose(grid.center_of([0, 0]), [0.75, 2.25])
    np.testing.assert_allclose(grid.center_of([1, 0]), [0.75, 2.75])
    cells = np.moveaxis(np.indices(shape), 0, -1)
    np.testing.assert_array_equal(grid.cell_of(grid.center_of(cells)), cells)
    assert grid.holds([3, 2]) and not grid.holds([4, 0]) and not grid.holds([0, -1])


def test_a_plan_counts_its_modes():
    with pytest.raises(InvalidInput, match="expected 1 modes for 2 cells, got 0"):
        Plan(np.zeros((2, 2), int), (), np.zeros((2, 2)), "optimal", 0, 0, 0.0)
    plan = Plan(np.zeros((2, 2), int), ("crawl",), np.zeros((2, 2)), "feasible", 3.0, 5.0, 0.0)
    assert plan.modes == (Mode.CRAWL,) and plan.gap == 2.0
