"""Rotations, transforms and frames: the one place where an axis convention is written.

Quaternions are ``wxyz``. ``R_AB`` turns coordinates in B into coordinates in A, and
``q_AB`` is the same rotation. All functions broadcast over leading axes.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

R_BS = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
"""Paper frame S (x right, y forward, z up) to ``base_link`` B (REP-103)."""
R_BS.setflags(write=False)

R_HB_BIPED = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
"""``base_link`` to heading frame for an upright trunk in biped mode: forward is -z_B."""
R_HB_BIPED.setflags(write=False)


_FORWARD = {"crawl": np.array([1.0, 0.0, 0.0]), "biped": np.array([0.0, 0.0, -1.0])}
"""Trunk axis of travel by body."""
_CONJUGATE = np.array([1.0, -1.0, -1.0, -1.0])


def paper_to_base(v_S: ArrayLike) -> Array:
    """A vector (..., 3) of the paper's frame in ``base_link`` axes: (y, -x, z)."""
    return np.asarray(v_S, dtype=float) @ R_BS.T


def base_to_paper(v_B: ArrayLike) -> Array:
    """A vector (..., 3) of ``base_link`` in the paper's axes: (-y, x, z)."""
    return np.asarray(v_B, dtype=float) @ R_BS


def skew(v: ArrayLike) -> Array:
    """Cross-product matrix (..., 3, 3) of v (..., 3)."""
    v = np.asarray(v, dtype=float)
    out = np.zeros((*v.shape, 3))
    out[..., 0, 1], out[..., 0, 2] = -v[..., 2], v[..., 1]
    out[..., 1, 0], out[..., 1, 2] = v[..., 2], -v[..., 0]
    out[..., 2, 0], out[..., 2, 1] = -v[..., 1], v[..., 0]
    return out


def quat_mul(a: ArrayLike, b: ArrayLike) -> Array:
    """Hamilton product (..., 4) of wxyz quaternions."""
    a, b = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    aw, ax, ay, az = (a[..., i] for i in range(4))
    bw, bx, by, bz = (b[..., i] for i in range(4))
    return np.stack(
        [
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        ],
        axis=-1,
    )


def quat_conj(q: ArrayLike) -> Array:
    """Inverse (..., 4) of a unit quaternion."""
    return np.asarray(q, dtype=float) * _CONJUGATE


def quat_to_mat(q: ArrayLike) -> Array:
    """Rotation matrix (..., 3, 3) of a unit quaternion (..., 4)."""
    q = np.asarray(q, dtype=float)
    if q.ndim == 1:
        return _mat_of_one(q)
    w, x, y, z = (q[..., i] for i in range(4))
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def _mat_of_one(q: Array) -> Array:
    """The same for one quaternion."""
    w, x, y, z = q.tolist()
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def mat_to_quat(R: ArrayLike) -> Array:
    """Unit quaternion (4,) with w >= 0 of one rotation matrix (3, 3)."""
    R = np.asarray(R, dtype=float)
    diag = np.array([np.trace(R), R[0, 0], R[1, 1], R[2, 2]])
    k = int(np.argmax(diag))
    if k == 0:
        q = np.array([1 + diag[0], R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    elif k == 1:
        q = np.array(
            [R[2, 1] - R[1, 2], 1 + 2 * R[0, 0] - diag[0], R[0, 1] + R[1, 0], R[0, 2] + R[2, 0]]
        )
    elif k == 2:
        q = np.array(
            [R[0, 2] - R[2, 0], R[0, 1] + R[1, 0], 1 + 2 * R[1, 1] - diag[0], R[1, 2] + R[2, 1]]
        )
    else:
        q = np.array(
            [R[1, 0] - R[0, 1], R[0, 2] + R[2, 0], R[1, 2] + R[2, 1], 1 + 2 * R[2, 2] - diag[0]]
        )
    q = q / np.linalg.norm(q)
    return -q if q[0] < 0 else q


def cross(a: Array, b: Array) -> Array:
    """Cross product (..., 3); several times faster than numpy's on small arrays."""
    out = np.empty(np.broadcast_shapes(a.shape, b.shape))
    out[..., 0] = a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1]
    out[..., 1] = a[..., 2] * b[..., 0] - a[..., 0] * b[..., 2]
    out[..., 2] = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return out


def rotate(q: ArrayLike, v: ArrayLike) -> Array:
    """R(q) v for quaternions (..., 4) and vectors (..., 3)."""
    q, v = np.asarray(q, dtype=float), np.asarray(v, dtype=float)
    if q.size == 4 and v.size == 3:
        shape = v.shape if v.ndim >= q.ndim else (*q.shape[:-1], 3)
        return _rotate_one(q.ravel(), v.ravel()).reshape(shape)
    u = q[..., 1:]
    t = 2.0 * cross(u, v)
    return v + q[..., :1] * t + cross(u, t)


def _rotate_one(q: Array, v: Array) -> Array:
    """The same for one vector: plain numbers are faster than arrays of three."""
    w, x, y, z = q.tolist()
    a, b, c = v.tolist()
    tx, ty, tz = 2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)
    return np.array(
        [
            a + w * tx + y * tz - z * ty,
            b + w * ty + z * tx - x * tz,
            c + w * tz + x * ty - y * tx,
        ]
    )


def exp_so3(phi: ArrayLike) -> Array:
    """Rotation matrix (3, 3) of a rotation vector (3,) [rad]."""
    phi = np.asarray(phi, dtype=float)
    angle = float(np.sqrt(phi @ phi))
    K = skew(phi)
    if angle < 1e-8:
        return np.eye(3) + K + 0.5 * K @ K
    a, b = np.sin(angle) / angle, (1 - np.cos(angle)) / angle**2
    return np.eye(3) + a * K + b * K @ K


def log_so3(R: ArrayLike) -> Array:
    """Rotation vector (3,) [rad] of a rotation matrix (3, 3)."""
    q = mat_to_quat(R)
    s = float(np.linalg.norm(q[1:]))
    return 2.0 * q[1:] if s < 1e-9 else q[1:] * (2.0 * np.arctan2(s, q[0]) / s)


def rpy_to_quat(roll: ArrayLike, pitch: ArrayLike, yaw: ArrayLike) -> Array:
    """Quaternion (..., 4) of R_z(yaw) R_y(pitch) R_x(roll)."""
    r, p, y = (0.5 * np.asarray(a, dtype=float) for a in (roll, pitch, yaw))
    cr, sr, cp, sp, cy, sy = np.cos(r), np.sin(r), np.cos(p), np.sin(p), np.cos(y), np.sin(y)
    return np.stack(
        np.broadcast_arrays(
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        ),
        axis=-1,
    )


def quat_to_rpy(q: ArrayLike) -> Array:
    """(..., 3) roll, pitch, yaw [rad] of R_z(yaw) R_y(pitch) R_x(roll)."""
    q = np.asarray(q, dtype=float)
    w, x, y, z = (q[..., i] for i in range(4))
    roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2 * (w * y - z * x), -1.0, 1.0))
    yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return np.stack([roll, pitch, yaw], axis=-1)


def wrap_angle(a: ArrayLike) -> Array:
    """Angle [rad] in [-pi, pi)."""
    return (np.asarray(a, dtype=float) + np.pi) % (2 * np.pi) - np.pi


def heading_axis(body: Literal["crawl", "biped"], q: ArrayLike) -> Array:
    """World direction (..., 3) of travel: +x_B in crawl, -z_B in biped (not flattened)."""
    axis = _FORWARD[body]
    q = np.asarray(q, dtype=float)
    return rotate(q, axis if q.ndim == 1 else np.broadcast_to(axis, (*q.shape[:-1], 3)))


def heading_yaw(body: Literal["crawl", "biped"], q: ArrayLike) -> Array:
    """Yaw (...) [rad] of the heading frame ``base_footprint`` in the frame of ``q``."""
    x = heading_axis(body, q)
    return np.arctan2(x[..., 1], x[..., 0])


def rot2(yaw: ArrayLike) -> Array:
    """Planar rotation (..., 2, 2) by ``yaw`` [rad]."""
    c, s = np.cos(yaw), np.sin(yaw)
    return np.stack([np.stack([c, -s], axis=-1), np.stack([s, c], axis=-1)], axis=-2)
