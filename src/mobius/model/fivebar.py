"""The planar five-bar of every limb: closed-form forward and inverse kinematics, Jacobian.

Plane coordinates (x, y) = (down, out) in metres from the top servo axis A = (0, 0); the
bottom servo axis is F = (w, 0). ``q11`` and ``q21`` are measured from "down" towards "out".

    A --crank--> B --coupler--> C         (top servo, q11)
    F --crank--> E --distal---> C, T      (bottom servo, q21; E, C, T are one rigid link)

T is the wrist (arm) or ankle (leg). Geometry: public SCALER/MOBIUS limb constants.
"""

from __future__ import annotations

import cmath
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


def _pairs(z: Complex) -> Array:
    """(..., 2) of the complex numbers z (...): down, out."""
    return np.ascontiguousarray(z).reshape(*np.shape(z), 1).view(np.float64)


def _direction(angle: ArrayLike) -> Complex:
    """exp(i angle)."""
    return np.asarray(np.exp(1j * np.asarray(angle, dtype=float)), dtype=np.complex128)


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
        B, E, EC = self.loop(q11, q21)
        return _pairs(B), _pairs(E), _pairs(E + EC), _pairs(E + self.to_T * EC)

    @property
    def to_T(self) -> complex:
        """E-T over E-C."""
        return self.distal / self.distal_joint * cmath.exp(1j * self.offset)

    def loop(self, q11: ArrayLike, q21: ArrayLike) -> tuple[Complex, Complex, Complex]:
        """B, E and E-C (...) as complex numbers ``down + i out`` [m], in a third of the time that
        pairs take; E-C is NaN where the loop cannot be closed.
        """
        B = self.L1 * _direction(q11)
        E = self.w + self.L1 * _direction(q21)
        EB = B - E
        d2 = EB.real * EB.real + EB.imag * EB.imag
        joint2, coupler2 = self.distal_joint * self.distal_joint, self.coupler * self.coupler
        with np.errstate(invalid="ignore", divide="ignore"):
            a = 0.5 * (d2 + (joint2 - coupler2)) / d2
            h = np.sqrt(joint2 / d2 - a * a)  # C is to the left of the line from E to B
            return B, E, (a + 1j * h) * EB

    def fk(self, q11: ArrayLike, q21: ArrayLike) -> Array:
        """Wrist or ankle T (..., 2) = (down, out) [m]; NaN where the loop cannot be closed."""
        _, E, EC = self.loop(q11, q21)
        return _pairs(E + self.to_T * EC)

    def distal_angle(self, q11: ArrayLike, q21: ArrayLike) -> Array:
        """Direction (...) [rad] of E-T from "down" towards "out"."""
        ET = self.to_T * self.loop(q11, q21)[2]
        return np.arctan2(ET.imag, ET.real)

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
