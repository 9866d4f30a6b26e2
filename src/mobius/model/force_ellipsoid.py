"""What wrenches an arm can give: the force manipulability ellipsoid of Fig. 15(a).

A wrench W at the fingertips asks the joints for torques tau = J^T W. Torques with
|tau| <= 1 (or, scaled by what each servo can give, |tau_i / tau_max,i| in a ball) allow

    { W : W^T J D J^T W <= 1 },   D = diag(1 / tau_max^2), or the identity.

The paper draws three of the six axes: moment about the surface's normal (z), force
perpendicular to it (x) and along the handle (y). Here that is the section of the set with the
other three components zero, as they are in the paper's measurements.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.errors import InvalidInput
from mobius.model.arm import gripper_ik, gripper_jacobian, gripper_pose
from mobius.model.dimensions import limb_geometry
from mobius.model.joints import JOINTS, LIMB_JOINTS
from mobius.model.servo import servo_of

__all__ = [
    "PAPER_AXES",
    "ForceEllipsoid",
    "arm_force_ellipsoid",
    "arm_stall",
    "force_ellipsoid",
    "strength",
]

Array = NDArray[np.float64]

PAPER_AXES = (0, 1, 5)
"""f_x, f_y and tau_z among (f_x, f_y, f_z, tau_x, tau_y, tau_z): the axes of Fig. 15(a)."""


@dataclass(frozen=True, eq=False)
class ForceEllipsoid:
    """Section of the wrench set with a few components; N for forces, N m for moments."""

    matrix: Array
    """(k, k) A in w^T A w <= 1."""
    components: tuple[int, ...]
    """Which of (f_x, f_y, f_z, tau_x, tau_y, tau_z)."""

    @property
    def reach(self) -> Array:
        """(k,) largest value of each component while the others are zero [N, N m]."""
        out: Array = 1.0 / np.sqrt(np.diag(self.matrix))
        return out

    @property
    def extent(self) -> Array:
        """(k,) largest value of each component, the others as they like [N, N m]."""
        out: Array = np.sqrt(np.diag(np.linalg.inv(self.matrix)))
        return out

    @property
    def axes(self) -> tuple[Array, Array]:
        """Semi-axes (k,), longest first, and their directions as columns (k, k)."""
        values, vectors = np.linalg.eigh(self.matrix)
        return 1.0 / np.sqrt(values), vectors

    def surface(self, points: int = 200) -> Array:
        """(points, 2) outline of a two-component section."""
        if len(self.components) != 2:
            raise InvalidInput("ForceEllipsoid.surface: expected two components, take section()")
        lengths, vectors = self.axes
        angle = np.linspace(0.0, 2.0 * np.pi, points)
        circle = np.stack([np.cos(angle), np.sin(angle)])
        outline: Array = (vectors @ (lengths[:, None] * circle)).T
        return outline

    def section(self, *components: int) -> ForceEllipsoid:
        """The section with fewer components."""
        at = [self.components.index(c) for c in components]
        return ForceEllipsoid(self.matrix[np.ix_(at, at)], tuple(components))


def force_ellipsoid(
    J: ArrayLike, *, components: tuple[int, ...] = PAPER_AXES, torque: ArrayLike | None = None
) -> ForceEllipsoid:
    """The ellipsoid of a Jacobian.

    Args:
        J: (6, n) rows linear, then angular velocity per joint rate.
        components: Of the wrench, the others are zero.
        torque: (n,) what each joint gives [N m]; 1 each if not given.

    Raises:
        InvalidInput: Not a Jacobian, or singular for these components.
    """
    J = np.asarray(J, dtype=float)
    if J.ndim != 2 or J.shape[0] != 6 or not np.isfinite(J).all():
        raise InvalidInput(f"force_ellipsoid: expected a finite Jacobian (6, n), got {J.shape}")
    limit = np.ones(J.shape[1]) if torque is None else np.asarray(torque, dtype=float)
    if limit.shape != (J.shape[1],) or not (limit > 0).all():
        raise InvalidInput(f"force_ellipsoid: expected {J.shape[1]} torques > 0 [N m]")
    rows = J[list(components)] / limit
    matrix = rows @ rows.T
    if np.linalg.cond(matrix) > 1e12:
        raise InvalidInput("force_ellipsoid: the arm is singular here; the ellipsoid is endless")
    return ForceEllipsoid(matrix, tuple(components))


def arm_stall(limb: str) -> Array:
    """(6,) stall torque of an arm's joints [N m]."""
    return np.array([servo_of(j).stall_torque for j in JOINTS[LIMB_JOINTS[limb]]])


def arm_force_ellipsoid(
    limb: str,
    q: ArrayLike,
    *,
    R_BF: ArrayLike | None = None,
    components: tuple[int, ...] = PAPER_AXES,
    torque: ArrayLike | None = None,
) -> ForceEllipsoid:
    """The ellipsoid of one arm at any pose.

    Args:
        limb: ``left_arm`` or ``right_arm``.
        q: (6,) [rad].
        R_BF: (3, 3) axes of the wrench, as columns in ``base_link``; the gripper's own if not
            given.
        components: Of the wrench in F, the others are zero.
        torque: (6,) what each joint gives [N m], e.g. :func:`arm_stall`; 1 each if not given.
    """
    g = limb_geometry(limb)
    if not g.is_arm:
        raise InvalidInput(f"arm_force_ellipsoid: expected left_arm or right_arm, got {limb}")
    q = np.asarray(q, dtype=float)
    R = gripper_pose(g, q)[1] if R_BF is None else np.asarray(R_BF, dtype=float)
    J = gripper_jacobian(g, q)
    turned = np.concatenate([R.T @ J[:3], R.T @ J[3:]])
    return force_ellipsoid(turned, components=components, torque=torque)


def strength(limb: str, p_B: ArrayLike, R_BG: ArrayLike, direction_B: ArrayLike) -> Array:
    """Force (...) [N] along a direction with 1 N m a joint, for many places at once.

    Args:
        limb: ``left_arm`` or ``right_arm``.
        p_B: (..., 3) fingertips [m].
        R_BG: (3, 3) orientation of the gripper.
        direction_B: (3,) unit vector.

    Returns:
        Half the width of the velocity-dual ellipsoid along the direction; 0 where the arm does
        not reach.
    """
    p = np.asarray(p_B, dtype=float)
    g, R = limb_geometry(limb), np.asarray(R_BG, dtype=float)
    q = gripper_ik(g, p, np.broadcast_to(R, (*p.shape[:-1], 3, 3)))
    reached = np.asarray(np.isfinite(q).all(axis=-1))
    J = gripper_jacobian(g, np.where(reached[..., None], q, 0.5))
    torque = np.einsum("...ij,i->...j", J[..., :3, :], np.asarray(direction_B, dtype=float))
    out: Array = np.where(reached, 1.0 / np.sqrt(np.sum(torque**2, axis=-1)), 0.0)
    return out
