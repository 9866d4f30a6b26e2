"""The planar five-bar of every limb: closed-form forward and inverse kinematics, Jacobian.

Plane coordinates (x, y) = (down, out) in metres from the top servo axis A = (0, 0); the
bottom servo axis is F = (w, 0). ``q11`` and ``q21`` are measured from "down" towards "out".

    A --crank--> B --coupler--> C         (top servo, q11)
    F --crank--> E --distal---> C, T      (bottom servo, q21; E, C, T are one rigid link)

T is the wrist (arm) or ankle (leg). Geometry: public SCALER/MOBIUS limb constants.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def _circles(c1: Array, r1: float, c2: Array, r2: float, branch: float) -> Array:
    """Intersection (..., 2) of two circles; NaN where they do not meet.

    ``branch`` +1 takes the point to the left of the line from ``c1`` to ``c2``.
    """
    dx, dy = c2[..., 0] - c1[..., 0], c2[..., 1] - c1[..., 1]
    d2 = dx * dx + dy * dy
    with np.errstate(invalid="ignore", divide="ignore"):
        a = 0.5 * (d2 + (r1 * r1 - r2 * r2)) / d2
        h = branch * np.sqrt(r1 * r1 / d2 - a * a)
        return np.stack([c1[..., 0] + a * dx - h * dy, c1[..., 1] + a * dy + h * dx], axis=-1)


def _rotate(v: Array, angle: float) -> Array:
    """Planar vectors (..., 2) turned by ``angle`` [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * v[..., 0] - s * v[..., 1], s * v[..., 0] + c * v[..., 1]], axis=-1)


@dataclass(frozen=True)
class FiveBar:
    """Link lengths of one five-bar [m] and its kinematics."""

    L1: float
    """Both cranks A-B and F-E."""
    w: float
    """Servo separation A-F."""
    coupler: float = 0.142035
    """B-C."""
    distal_joint: float = 0.13635
    """E-C."""
    distal: float = 0.21753
    """E-T."""
    offset: float = float(np.radians(15.0))
    """Angle [rad] from E-C to E-T."""

    @property
    def F(self) -> Array:
        """(2,) bottom servo axis."""
        return np.array([self.w, 0.0])

    def points(self, q11: ArrayLike, q21: ArrayLike) -> tuple[Array, Array, Array, Array]:
        """Points B, E, C, T (..., 2) [m]; NaN where the loop cannot be closed."""
        q11, q21 = np.asarray(q11, dtype=float), np.asarray(q21, dtype=float)
        B = self.L1 * np.stack([np.cos(q11), np.sin(q11)], axis=-1)
        E = self.F + self.L1 * np.stack([np.cos(q21), np.sin(q21)], axis=-1)
        C = _circles(E, self.distal_joint, B, self.coupler, +1.0)
        T = E + self.distal / self.distal_joint * _rotate(C - E, self.offset)
        return B, E, C, T

    def fk(self, q11: ArrayLike, q21: ArrayLike) -> Array:
        """Wrist or ankle T (..., 2) = (down, out) [m]; NaN where the loop cannot be closed."""
        return self.points(q11, q21)[3]

    def distal_angle(self, q11: ArrayLike, q21: ArrayLike) -> Array:
        """Direction (...) [rad] of E-T from "down" towards "out"."""
        _, E, _, T = self.points(q11, q21)
        d = T - E
        return np.arctan2(d[..., 1], d[..., 0])

    def ik(self, down: ArrayLike, out: ArrayLike) -> tuple[Array, Array]:
        """Crank angles q11, q21 (...) [rad] that bring T to (down, out) [m].

        NaN where the point is out of reach. Outside [-pi, pi) nothing is returned; limits
        are the caller's.
        """
        x, y = np.asarray(down, dtype=float), np.asarray(out, dtype=float)
        L1, w, k = self.L1, self.w, self.distal_joint / self.distal
        c, s = k * np.cos(self.offset), -k * np.sin(self.offset)
        with np.errstate(invalid="ignore", divide="ignore"):
            dx = x - w
            inv = 1.0 / (dx * dx + y * y)
            a = 0.5 + 0.5 * (L1 * L1 - self.distal * self.distal) * inv
            h = np.sqrt(L1 * L1 * inv - a * a)
            ex, ey = a * dx - h * y, a * y + h * dx
            tx, ty = dx - ex, y - ey
            cx, cy = w + ex + c * tx - s * ty, ey + s * tx + c * ty
            inv = 1.0 / (cx * cx + cy * cy)
            a = 0.5 + 0.5 * (L1 * L1 - self.coupler * self.coupler) * inv
            h = np.sqrt(L1 * L1 * inv - a * a)
            bx, by = a * cx + h * cy, a * cy - h * cx
        return np.arctan2(by, bx), np.arctan2(ey, ex)

    def jacobian(self, q11: ArrayLike, q21: ArrayLike) -> Array:
        """d(down, out)/d(q11, q21) (..., 2, 2) [m/rad]; column 0 is the top crank.

        From the velocity loop: C moves with both couplers, T with the distal link.
        """
        B, E, C, T = self.points(q11, q21)
        F = self.F
        vB, vE = _perp(B), _perp(E - F)  # per unit rate of q11, q21
        u, d = C - B, C - E  # coupler and distal joint directions
        # rate of the distal link: (vE + wd * perp(d) - vB q11') . u = 0
        den = np.sum(_perp(d) * u, axis=-1)
        with np.errstate(invalid="ignore", divide="ignore"):
            wd = np.stack([np.sum(vB * u, axis=-1), -np.sum(vE * u, axis=-1)], axis=-1)
            wd = wd / den[..., None]
        arm = _perp(T - E)
        J = arm[..., :, None] * wd[..., None, :]
        J[..., :, 1] += vE
        return J

    def distal_rate(self, q11: ArrayLike, q21: ArrayLike) -> Array:
        """d(distal angle)/d(q11, q21) (..., 2), dimensionless."""
        B, E, C, _ = self.points(q11, q21)
        u, d = C - B, C - E
        den = np.sum(_perp(d) * u, axis=-1)
        num = [np.sum(_perp(B) * u, axis=-1), -np.sum(_perp(E - self.F) * u, axis=-1)]
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.stack(num, axis=-1) / den[..., None]


def _perp(v: Array) -> Array:
    """(..., 2) turned by +90 degrees."""
    return np.stack([-v[..., 1], v[..., 0]], axis=-1)


ARM_FIVEBAR = FiveBar(L1=0.113, w=0.0285)
"""Limbs 0 and 3 of the paper: XM430 width apart."""

LEG_FIVEBAR = FiveBar(L1=0.130, w=0.0335)
"""Limbs 1 and 2 of the paper: XM540 width apart."""
