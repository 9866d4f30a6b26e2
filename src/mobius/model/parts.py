"""Solid parts: one list gives a body its look and its inertia."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Shape = Literal["box", "cylinder", "capsule", "sphere"]


@dataclass(frozen=True)
class Part:
    """A homogeneous solid in its body's frame.

    ``size``: box half extents; cylinder and capsule (radius, half length) along z;
    sphere (radius,). ``euler`` turns it, x then y then z [rad]. Parts of mass 0 are only seen.
    """

    shape: Shape
    size: tuple[float, ...]
    pos: tuple[float, float, float] = (0.0, 0.0, 0.0)
    euler: tuple[float, float, float] = (0.0, 0.0, 0.0)
    mass: float = 0.0
    material: str = "metal"

    @property
    def rotation(self) -> Array:
        """(3, 3) part to body."""
        (cx, cy, cz), (sx, sy, sz) = np.cos(self.euler), np.sin(self.euler)
        Rx = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
        Ry = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
        Rz = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
        return Rz @ Ry @ Rx

    @property
    def inertia(self) -> Array:
        """(3, 3) about the part's centre, body axes [kg m^2]. Capsules count as cylinders."""
        m, s = self.mass, self.size
        if self.shape == "box":
            d = np.array([s[1] ** 2 + s[2] ** 2, s[0] ** 2 + s[2] ** 2, s[0] ** 2 + s[1] ** 2])
            diag = m / 3 * d
        elif self.shape == "sphere":
            diag = np.full(3, 0.4 * m * s[0] ** 2)
        else:
            side = m * (3 * s[0] ** 2 + 4 * s[1] ** 2) / 12
            diag = np.array([side, side, 0.5 * m * s[0] ** 2])
        R = self.rotation
        return R @ np.diag(diag) @ R.T


def between(
    a: Sequence[float], b: Sequence[float], radius: float, *, mass: float = 0.0, material: str
) -> Part:
    """A capsule from point a to point b (body frame, both in a plane or not) [m]."""
    p, q = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    d = q - p
    length = float(np.linalg.norm(d))
    pitch = float(np.arctan2(np.hypot(d[0], d[1]), d[2]))
    yaw = float(np.arctan2(d[1], d[0]))
    x, y, z = (float(v) for v in 0.5 * (p + q))
    return Part("capsule", (radius, 0.5 * length), (x, y, z), (0.0, pitch, yaw), mass, material)


def composite_inertia(parts: Sequence[Part]) -> tuple[float, Array, Array]:
    """Mass [kg], centre of mass (3,) [m] and inertia (3, 3) about it [kg m^2] of solid parts."""
    mass = sum(p.mass for p in parts)
    com = sum((p.mass * np.asarray(p.pos) for p in parts), np.zeros(3)) / mass
    inertia = np.zeros((3, 3))
    for p in parts:
        r = np.asarray(p.pos) - com
        inertia += p.inertia + p.mass * (r @ r * np.eye(3) - np.outer(r, r))
    return float(mass), com, inertia
