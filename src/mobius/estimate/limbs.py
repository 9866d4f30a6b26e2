"""Where a limb touches the ground and how fast that point moves, in plain floats for 300 Hz.

The closed form of :mod:`mobius.model.leg` and :mod:`mobius.model.arm` for one robot at a
time, some ten microseconds a limb; a test holds both equal. Points of the five-bar plane
are complex numbers ``down + i out``, horizontal ones ``x + i y``: a quarter turn is a
product with ``i``, and a vector in ``base_link`` is a pair (horizontal, z).

A fingertip touches with the lowest point of its sphere; a foot with the lowest corner of
its sole, its lowest edge, or all of it: corners count by ``exp(-height / EDGE)``, and the
mean of so weighted corners of a rectangle is a tanh along each side.
"""

from __future__ import annotations

from cmath import exp as cexp
from collections.abc import Sequence
from math import cos, sin, sqrt, tanh
from typing import NamedTuple

from mobius.model import LimbGeometry
from mobius.model import dimensions as dim

EDGE = 0.002
"""Corners of a sole within about this height of the lowest share the contact [m]."""

Vector = tuple[complex, float]
"""``x + i y`` and z of a vector in ``base_link``."""


class LimbState(NamedTuple):
    """One limb at one instant."""

    contact: Vector
    """Where it touches, or would touch, the ground, from the trunk's origin [m]."""
    velocity: Vector
    """Velocity of that point of the limb relative to the trunk [m/s]."""
    out: complex
    """Outward direction of the limb's plane."""
    pins: tuple[complex, complex]
    """d(B)/d(q11) and d(E)/d(q21), ``down + i out`` [m/rad]."""
    wrist_drive: tuple[complex, complex]
    """d(wrist or ankle)/d(q11, q21), ``down + i out`` [m/rad]."""
    contact_drive: tuple[complex, complex]
    """d(contact)/d(q11, q21), ``down + i out`` [m/rad]."""
    axes: tuple[Vector, Vector, Vector]
    """x, y and z axis of gripper or foot."""


def cross(a: Vector, b: Vector) -> Vector:
    """The vector product a x b."""
    return 1j * (a[1] * b[0] - b[1] * a[0]), (a[0].conjugate() * b[0]).imag


def dot(a: Vector, b: Vector) -> float:
    """The scalar product of a and b."""
    return (a[0].conjugate() * b[0]).real + a[1] * b[1]


def sole_rectangle(g: LimbGeometry) -> tuple[tuple[float, float, float, float], float]:
    """(centre x, half length, half width, z) of what may touch, and the radius around it [m].

    In the frame of gripper or foot: a foot's sole, or the centres of the two fingertips.
    """
    if g.is_arm:
        r = dim.FINGER_RADIUS
        return (0.0, 0.0, dim.FINGER_PIVOT[0] + dim.FINGER_TIP[0], r - g.tip), r
    toe, heel = dim.FOOT_TOE, dim.FOOT_HEEL
    return (0.5 * (heel - toe), 0.5 * (heel + toe), 0.5 * dim.FOOT_WIDTH, -g.tip), 0.0


class LimbKinematics:
    """Kinematics of one limb."""

    def __init__(self, g: LimbGeometry) -> None:
        fb = g.fivebar
        self._geometry = g
        self._hip = complex(*g.hip_B[:2])
        self._out0 = 1j * g.side
        self._x_off = complex(g.x_off, -g.side * g.lateral)
        self._z_top = g.z_top + g.hip_B[2]
        self._fivebar = (fb.L1, fb.w, fb.distal_joint**2, fb.distal_joint**2 - fb.coupler**2)
        self._to_T = fb.distal / fb.distal_joint * cexp(1j * fb.offset)
        self._sole, self._radius = sole_rectangle(g)

    def __call__(self, q: Sequence[float], dq: Sequence[float], up: Vector) -> LimbState:
        """The limb at its joint angles q (4 or 6) [rad] and rates dq [rad/s].

        ``up`` is the believed vertical in ``base_link``; it decides what is lowest.
        """
        L1, w, joint2, loop = self._fivebar
        B, FE = L1 * cexp(1j * q[1]), L1 * cexp(1j * q[2])
        EB = B - FE - w
        d2 = EB.real**2 + EB.imag**2
        a = 0.5 + 0.5 * loop / d2
        EC = complex(a, sqrt(max(joint2 / d2 - a * a, 0.0))) * EB
        ET = self._to_T * EC
        u = EC - EB
        den = (EC.conjugate() * u).imag or 1e-9  # never 0 but where the loop folds flat
        turn_a, turn_b = (B.conjugate() * u).imag / den, -(FE.conjugate() * u).imag / den
        Ja, Jb = 1j * ET * turn_a, 1j * (ET * turn_b + FE)

        out = self._out0 * cexp(1j * q[0])
        reach = (self._x_off + (FE + ET).imag) * out
        pitch = ET / abs(ET) * cexp(1j * q[3])
        pitch_rate = turn_a * dq[1] + turn_b * dq[2] + dq[3]
        axes, (w_xy, w_z) = self._end(out, pitch, pitch_rate, q, dq)
        spin = (w_xy, w_z + dq[0])

        lever = self._lever(axes, up)
        down = Ja * dq[1] + Jb * dq[2]
        turned = cross(spin, lever)
        contact = (self._hip + reach + lever[0], self._z_top - w - (FE + ET).real + lever[1])
        velocity = (1j * reach * dq[0] + out * down.imag + turned[0], turned[1] - down.real)
        plane = 1j * complex(-lever[1], (lever[0] * out.conjugate()).real)
        return LimbState(
            contact,
            velocity,
            out,
            (1j * B, 1j * FE),
            (Ja, Jb),
            (Ja + plane * turn_a, Jb + plane * turn_b),
            axes,
        )

    def _end(
        self, out: complex, pitch: complex, rate: float, q: Sequence[float], dq: Sequence[float]
    ) -> tuple[tuple[Vector, Vector, Vector], Vector]:
        """Axes of gripper or foot, and its angular velocity without that of the limb's yaw."""
        c, s = pitch.real, pitch.imag
        normal = 1j * out
        x, y, z = (c * out, s), (normal, 0.0), (-s * out, c)
        if not self._geometry.is_arm:
            return (x, y, z), (-rate * normal, 0.0)
        cr, sr, cy, sy = cos(q[4]), sin(q[4]), cos(q[5]), sin(q[5])
        y, z = (cr * y[0] + sr * z[0], sr * z[1]), (cr * z[0] - sr * y[0], cr * z[1])
        w = (
            -rate * normal + dq[4] * x[0] + dq[5] * z[0],
            dq[4] * x[1] + dq[5] * z[1],
        )
        x, y = (
            (cy * x[0] + sy * y[0], cy * x[1] + sy * y[1]),
            (cy * y[0] - sy * x[0], cy * y[1] - sy * x[1]),
        )
        return (x, y, z), w

    def _lever(self, axes: tuple[Vector, Vector, Vector], up: Vector) -> Vector:
        """Ankle or wrist centre to the contact [m]."""
        (ax, ay, az), (mid, half_x, half_y, z), r = axes, self._sole, self._radius
        x = mid - half_x * tanh(half_x * dot(ax, up) / EDGE)
        y = -half_y * tanh(half_y * dot(ay, up) / EDGE)
        return (
            x * ax[0] + y * ay[0] + z * az[0] - r * up[0],
            x * ax[1] + y * ay[1] + z * az[1] - r * up[1],
        )
