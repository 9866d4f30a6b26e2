"""Leg kinematics in ``base_link``: hip yaw, five-bar, ankle pitch. Closed form, batched.

Joint order of a leg: hip_yaw, hip_motor_a (q11), hip_motor_b (q21), ankle_pitch.
The five-bar part (yaw and two cranks to the wrist or ankle) is shared with the arm.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.model.dimensions import LimbGeometry

Array = NDArray[np.float64]


def limb_axes(g: LimbGeometry, yaw: ArrayLike) -> tuple[Array, Array]:
    """Unit vectors (..., 3) in B of a limb: outward, and the link frame's y (plane normal).

    At zero yaw outward is +-y_B (left +) and the normal is -+x_B; yaw turns about +z_B.
    """
    c, s = g.side * np.cos(yaw), g.side * np.sin(yaw)
    out, normal = np.zeros((*np.shape(c), 3)), np.zeros((*np.shape(c), 3))
    out[..., 0], out[..., 1] = -s, c
    normal[..., 0], normal[..., 1] = -c, -s
    return out, normal


def _offset(g: LimbGeometry) -> float:
    """Wrist centre along the plane normal y [m] (forward for both sides)."""
    return -g.side * g.lateral


def ankle_position(g: LimbGeometry, q: ArrayLike) -> Array:
    """Wrist centre or ankle axis (..., 3) [m] in B for yaw and cranks q (..., >=3) [rad]."""
    q = np.asarray(q, dtype=float)
    T = g.fivebar.fk(q[..., 1], q[..., 2])
    out, normal = limb_axes(g, q[..., 0])
    p = g.hip_B + (g.x_off + T[..., 1:]) * out + _offset(g) * normal
    p[..., 2] += g.z_top - T[..., 0]
    return p


def ankle_jacobian(g: LimbGeometry, q: ArrayLike) -> Array:
    """d(ankle_position)/d(yaw, q11, q21) (..., 3, 3) [m/rad]."""
    q = np.asarray(q, dtype=float)
    T = g.fivebar.fk(q[..., 1], q[..., 2])
    J2 = g.fivebar.jacobian(q[..., 1], q[..., 2])
    out, normal = limb_axes(g, q[..., 0])
    J = np.zeros((*q.shape[:-1], 3, 3))
    # d out / d yaw = -side-independent quarter turn: out x z = -normal, so out' = normal * -1
    J[..., :, 0] = -(g.x_off + T[..., 1:]) * -normal + _offset(g) * -out
    J[..., :, 1:] = J2[..., None, 1, :] * out[..., :, None]
    J[..., 2, 1:] -= J2[..., 0, :]
    return J


def ankle_ik(g: LimbGeometry, p_B: ArrayLike) -> Array:
    """Yaw and cranks (..., 3) [rad] that bring wrist centre or ankle to p_B (..., 3) [m].

    NaN where out of reach. Joint limits are the caller's.
    """
    d = np.asarray(p_B, dtype=float) - np.asarray(g.hip_B)
    offset = _offset(g)
    x, y = g.side * d[..., 1], -g.side * d[..., 0]  # out and normal at zero yaw
    with np.errstate(invalid="ignore"):
        r = np.sqrt(x * x + y * y - offset * offset)
    yaw = np.arctan2(y, x) - np.arctan2(offset, r)
    q11, q21 = g.fivebar.ik(g.z_top - d[..., 2], r - g.x_off)
    out = np.empty((*r.shape, 3))
    out[..., 0] = (yaw + np.pi) % (2 * np.pi) - np.pi
    out[..., 1], out[..., 2] = q11, q21
    return out


def foot_pitch(g: LimbGeometry, q: ArrayLike) -> Array:
    """Angle (...) [rad] of the sole's outward normal from "down" towards "out"."""
    q = np.asarray(q, dtype=float)
    return g.fivebar.distal_angle(q[..., 1], q[..., 2]) + q[..., 3]


def sole_position(g: LimbGeometry, q: ArrayLike) -> Array:
    """Point of the sole below the ankle (..., 3) [m] in B for q (..., 4) [rad]."""
    q = np.asarray(q, dtype=float)
    angle = foot_pitch(g, q)
    out, _ = limb_axes(g, q[..., 0])
    p = ankle_position(g, q) + g.tip * np.sin(angle)[..., None] * out
    p[..., 2] -= g.tip * np.cos(angle)
    return p


def sole_ik(g: LimbGeometry, p_B: ArrayLike, pitch: ArrayLike = 0.0) -> Array:
    """Leg angles (..., 4) [rad] for a sole point p_B (..., 3) [m] and sole pitch [rad].

    ``pitch`` is that of :func:`foot_pitch`; 0 is a sole facing -z_B. NaN out of reach.
    """
    p = np.asarray(p_B, dtype=float)
    pitch = np.broadcast_to(np.asarray(pitch, dtype=float), p.shape[:-1])
    d = p - np.asarray(g.hip_B)
    heading = np.stack([d[..., 0], d[..., 1], np.zeros_like(pitch)], axis=-1)
    heading /= np.linalg.norm(heading, axis=-1, keepdims=True)
    ankle = p - g.tip * np.sin(pitch)[..., None] * heading
    ankle[..., 2] += g.tip * np.cos(pitch)
    q = ankle_ik(g, ankle)
    distal = g.fivebar.distal_angle(q[..., 1], q[..., 2])
    return np.concatenate([q, (pitch - distal)[..., None]], axis=-1)


def sole_jacobian(g: LimbGeometry, q: ArrayLike) -> Array:
    """d(sole_position)/dq (..., 3, 4) [m/rad]."""
    q = np.asarray(q, dtype=float)
    angle = foot_pitch(g, q)
    out, normal = limb_axes(g, q[..., 0])
    rate = g.fivebar.distal_rate(q[..., 1], q[..., 2])
    swing = g.tip * np.cos(angle)[..., None] * out
    swing[..., 2] += g.tip * np.sin(angle)
    J = np.zeros((*q.shape[:-1], 3, 4))
    J[..., :, :3] = ankle_jacobian(g, q)
    J[..., :, 0] += g.tip * np.sin(angle)[..., None] * normal
    J[..., :, 1:3] += swing[..., :, None] * rate[..., None, :]
    J[..., :, 3] = swing
    return J
