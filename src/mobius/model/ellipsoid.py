"""The leg's design claim, Sec. III-C: a larger and rounder velocity ellipsoid than SCALER's.

A limb without its wrist or ankle has three joints, q = (psi, q11, q21): yaw about the
vertical shoulder axis and the two cranks of the five-bar. The foot's Jacobian maps their
rates to its velocity; at psi = 0, in axes (sideways, out, down),

        [ rho   0      0    ]
    J = [ 0     J_plane     ]        rho = x_off + out(q11, q21)

and its singular values a >= b >= c are the semi-axes of the velocity ellipsoid for unit
joint rates. How the paper measures "volume" is not printed. sqrt(a b c), the measure in
the public kinematics of this robot family, gives the printed +19 %; the geometric volume,
proportional to a b c, grows by 42 %. Both are returned.

The claims hold with the servos 28.5 mm apart in both limbs. MOBIUS' wider leg servos put
them 33.5 mm apart, which costs part of the gain: pass ``w=0.0335`` to see it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import sqrt

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.errors import InvalidInput
from mobius.model.dimensions import limb_geometry
from mobius.model.fivebar import ARM_FIVEBAR, FiveBar

__all__ = ["POSE", "DesignClaims", "Ellipsoid", "design_claims", "limb_jacobian", "limb_ellipsoid"]

Array = NDArray[np.float64]

POSE = (0.0, 0.4, 1.23)
"""q = (psi, q11, q21) [rad] at which the two legs are compared."""


def limb_jacobian(fivebar: FiveBar, q: ArrayLike, *, x_off: float) -> Array:
    """Velocity Jacobian of wrist or ankle for unit rates of yaw and both cranks.

    Args:
        fivebar: The limb's five-bar.
        q: (..., 3) psi, q11, q21 [rad].
        x_off: Five-bar plane origin outward of the yaw axis [m].

    Returns:
        (..., 3, 3) [m/rad], rows x, y, z of the frame whose x points outward at psi = 0
        and z up. NaN where the five-bar cannot be closed.
    """
    q = np.asarray(q, dtype=float)
    if q.shape[-1:] != (3,):
        raise InvalidInput(f"limb_jacobian q: expected shape (..., 3), got {q.shape}")
    psi, q11, q21 = (q[..., i] for i in range(3))
    plane = fivebar.jacobian(q11, q21)
    rho = x_off + fivebar.fk(q11, q21)[..., 1]
    e_out = np.stack([np.cos(psi), np.sin(psi)], axis=-1)
    e_side = np.stack([-np.sin(psi), np.cos(psi)], axis=-1)
    J = np.zeros((*q.shape[:-1], 3, 3))
    J[..., :2, 0] = rho[..., None] * e_side
    J[..., :2, 1:] = e_out[..., :, None] * plane[..., None, 1, :]
    J[..., 2, 1:] = -plane[..., 0, :]
    return J


@dataclass(frozen=True)
class Ellipsoid:
    """Velocity ellipsoid of a limb at one pose, for unit joint rates."""

    axes: tuple[float, float, float]
    """Semi-axes a >= b >= c [m/rad]."""

    @property
    def condition(self) -> float:
        """Ratio a / c; 1 is a sphere."""
        return self.axes[0] / self.axes[2]

    @property
    def volume(self) -> float:
        """Measure sqrt(a b c) [(m/rad)^1.5], the measure that reproduces the printed claim."""
        return sqrt(self.product)

    @property
    def product(self) -> float:
        """Product a b c [(m/rad)^3], proportional to the geometric volume."""
        return self.axes[0] * self.axes[1] * self.axes[2]


def limb_ellipsoid(fivebar: FiveBar, q: ArrayLike = POSE, *, x_off: float) -> Ellipsoid:
    """Velocity ellipsoid at one pose q (3,) [rad]; raises where the limb cannot be closed."""
    J = limb_jacobian(fivebar, q, x_off=x_off)
    if not np.isfinite(J).all():
        raise InvalidInput(f"limb_ellipsoid: the five-bar cannot be closed at q = {q!r} rad")
    a, b, c = (float(s) for s in np.linalg.svd(J, compute_uv=False))
    return Ellipsoid((a, b, c))


@dataclass(frozen=True)
class DesignClaims:
    """The MOBIUS leg against the SCALER leg; changes are relative, +0.19 is +19 %."""

    scaler: Ellipsoid
    mobius: Ellipsoid

    @property
    def volume_change(self) -> float:
        """Change of sqrt(a b c); printed +19 %."""
        return self.mobius.volume / self.scaler.volume - 1.0

    @property
    def condition_change(self) -> float:
        """Change of the condition number; printed -24 %."""
        return self.mobius.condition / self.scaler.condition - 1.0

    @property
    def product_change(self) -> float:
        """Change of a b c, the geometric volume; not printed."""
        return self.mobius.product / self.scaler.product - 1.0


def design_claims(q: ArrayLike = POSE, *, w: float = ARM_FIVEBAR.w) -> DesignClaims:
    """Both claims of Sec. III-C at pose q (3,) [rad].

    The SCALER limb is the one that MOBIUS kept as its arm.

    Args:
        q: Yaw and crank angles at which both limbs stand [rad].
        w: Servo separation of the MOBIUS leg [m]; SCALER's stays 28.5 mm.
    """
    scaler, leg = limb_geometry("right_arm"), limb_geometry("right_leg")
    return DesignClaims(
        scaler=limb_ellipsoid(scaler.fivebar, q, x_off=scaler.x_off),
        mobius=limb_ellipsoid(replace(leg.fivebar, w=w), q, x_off=leg.x_off),
    )
