"""Rotations of one robot in plain floats: a tenth of the time of the batched ones.

:mod:`mobius.geometry` holds the definitions; a test holds both equal.
"""

from __future__ import annotations

from math import atan2, cos, sin, sqrt

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def exp_so3(x: float, y: float, z: float) -> Array:
    """Rotation matrix (3, 3) of one rotation vector [rad], in floats."""
    angle2 = x * x + y * y + z * z
    if angle2 < 1e-4:  # series to the order of double precision at 0.01 rad
        a, b = 1 - angle2 * (1 / 6 - angle2 / 120), 0.5 - angle2 * (1 / 24 - angle2 / 720)
    else:
        angle = sqrt(angle2)
        a, b = sin(angle) / angle, (1 - cos(angle)) / angle2
    xy, xz, yz = b * x * y, b * x * z, b * y * z
    return np.array(
        [
            [1 - b * (y * y + z * z), xy - a * z, xz + a * y],
            [xy + a * z, 1 - b * (x * x + z * z), yz - a * x],
            [xz - a * y, yz + a * x, 1 - b * (x * x + y * y)],
        ]
    )


def left_jacobian(x: float, y: float, z: float) -> Array:
    """Left Jacobian (3, 3) of SO(3) at one rotation vector [rad]: J = int_0^1 exp(s phi) ds."""
    angle2 = x * x + y * y + z * z
    if angle2 < 1e-4:
        b, c = 0.5 - angle2 * (1 / 24 - angle2 / 720), 1 / 6 - angle2 * (1 / 120 - angle2 / 5040)
    else:
        angle = sqrt(angle2)
        b, c = (1 - cos(angle)) / angle2, (1 - sin(angle) / angle) / angle2
    xy, xz, yz = c * x * y, c * x * z, c * y * z
    return np.array(
        [
            [1 - c * (y * y + z * z), xy - b * z, xz + b * y],
            [xy + b * z, 1 - c * (x * x + z * z), yz - b * x],
            [xz - b * y, yz + b * x, 1 - c * (x * x + y * y)],
        ]
    )


def small_log(R: Array) -> Array:
    """Rotation vector (3,) of a rotation well below a quarter turn: series of the arc sine."""
    (_, b, c), (d, _, f), (g, h, _) = R.tolist()
    x, y, z = 0.5 * (h - f), 0.5 * (c - g), 0.5 * (d - b)
    s2 = x * x + y * y + z * z
    return (1 + s2 / 6 + 0.075 * s2 * s2) * np.array([x, y, z])


def yaw_of(R: Array) -> float:
    """Heading [rad] of the turn about z nearest to a rotation matrix (3, 3)."""
    return atan2(R.item(1, 0) - R.item(0, 1), R.item(0, 0) + R.item(1, 1))
