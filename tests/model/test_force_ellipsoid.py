"""The force manipulability ellipsoid."""

import numpy as np
import pytest

from mobius.errors import InvalidInput
from mobius.geometry import exp_so3
from mobius.model.arm import gripper_jacobian, gripper_pose
from mobius.model.dimensions import limb_geometry
from mobius.model.force_ellipsoid import (
    PAPER_AXES,
    ForceEllipsoid,
    arm_force_ellipsoid,
    arm_stall,
    force_ellipsoid,
    strength,
)

Q = np.array([0.2, -0.3, 2.0, 0.4, 0.1, -0.2])
ALL = (0, 1, 2, 3, 4, 5)


def test_two_joints_by_hand():
    """J = diag(2, 0.5) on f_x, f_y: 1 N m a joint gives 1/2 N and 2 N."""
    J = np.zeros((6, 2))
    J[0, 0], J[1, 1] = 2.0, 0.5
    e = force_ellipsoid(J, components=(0, 1))
    np.testing.assert_allclose(e.reach, [0.5, 2.0])
    np.testing.assert_allclose(e.axes[0], [2.0, 0.5])
    np.testing.assert_allclose(force_ellipsoid(J, components=(0, 1), torque=[4, 1]).reach, [2, 2])


def test_every_wrench_on_the_surface_asks_for_torques_of_norm_one():
    J = gripper_jacobian(limb_geometry("left_arm"), Q)
    e = force_ellipsoid(J, components=ALL)
    lengths, vectors = e.axes
    rng = np.random.default_rng(0)
    for _ in range(20):
        u = rng.normal(size=6)
        W = vectors @ (lengths * u / np.linalg.norm(u))
        assert np.linalg.norm(J.T @ W) == pytest.approx(1.0)


def test_it_is_dual_to_the_velocity_ellipsoid():
    """What is strong is slow: the same directions, reciprocal lengths."""
    J = gripper_jacobian(limb_geometry("left_arm"), Q)
    speed = np.linalg.svd(J, compute_uv=False)
    np.testing.assert_allclose(force_ellipsoid(J, components=ALL).axes[0], 1 / speed[::-1])


def test_turned_axes_turn_it_and_do_not_change_it():
    R = gripper_pose(limb_geometry("left_arm"), Q)[1]
    own = arm_force_ellipsoid("left_arm", Q, components=(0, 1, 2))
    other = arm_force_ellipsoid(
        "left_arm", Q, components=(0, 1, 2), R_BF=R @ exp_so3([0.3, -1.0, 0.2])
    )
    np.testing.assert_allclose(own.axes[0], other.axes[0])


def test_both_arms_are_mirror_images():
    mirrored = Q * [-1, 1, 1, 1, -1, -1]
    a = arm_force_ellipsoid("left_arm", Q, components=PAPER_AXES)
    b = arm_force_ellipsoid("right_arm", mirrored, components=PAPER_AXES)
    np.testing.assert_allclose(a.reach, b.reach)


def test_a_section_is_smaller_than_the_shadow():
    e = arm_force_ellipsoid("left_arm", Q)
    assert (e.reach <= e.extent + 1e-12).all()
    part = e.section(0, 5)
    np.testing.assert_allclose(part.reach, e.reach[[0, 2]])
    outline = part.surface(50)
    np.testing.assert_allclose(np.einsum("ni,ij,nj->n", outline, part.matrix, outline), 1.0)


def test_an_arm_is_stronger_with_its_stall_torques():
    torque = arm_stall("left_arm")
    np.testing.assert_allclose(torque, [8.2, 8.2, 8.2, 4.1, 4.1, 4.1])
    weak, strong = (
        arm_force_ellipsoid("left_arm", Q),
        arm_force_ellipsoid("left_arm", Q, torque=torque),
    )
    assert ((strong.reach > 4.0 * weak.reach) & (strong.reach < 8.3 * weak.reach)).all()


def test_strength_along_an_axis_is_the_ellipsoids_and_zero_out_of_reach():
    p, R = gripper_pose(limb_geometry("left_arm"), Q)
    e = arm_force_ellipsoid("left_arm", Q, components=(0, 1, 2))
    places = np.array([p, p + [0.0, 0.0, 1.0]])
    out = strength("left_arm", places, R, R[:, 2])
    np.testing.assert_allclose(out, [e.reach[2], 0.0])


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: force_ellipsoid(np.zeros((5, 3))), r"Jacobian \(6, n\)"),
        (lambda: force_ellipsoid(np.zeros((6, 6))), "singular"),
        (lambda: force_ellipsoid(np.eye(6), torque=[1.0]), "6 torques"),
        (lambda: arm_force_ellipsoid("left_leg", Q), "left_arm or right_arm"),
        (lambda: ForceEllipsoid(np.eye(3), PAPER_AXES).surface(), "two components"),
    ],
)
def test_mistakes_are_told(call, told):
    with pytest.raises(InvalidInput, match=told):
        call()
