"""Shapes drawn on a map in metres, and what they mean to the robot."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.types import Mode

Mask = NDArray[np.bool_]
Array = NDArray[np.float64]
Point = tuple[float, float]


@dataclass(frozen=True)
class Circle:
    """A disc, frame M."""

    center: Point
    """[m]."""
    radius: float
    """[m]."""

    def contains(self, xy_M: ArrayLike) -> Mask:
        """Which points (..., 2) [m] lie strictly inside (...)."""
        d = np.asarray(xy_M, dtype=float) - self.center
        return np.asarray((d * d).sum(axis=-1) < self.radius**2)


@dataclass(frozen=True)
class Polygon:
    """The inside of a closed line of points, frame M; even-odd where it crosses itself."""

    points: tuple[Point, ...]
    """Corners [m]; the last joins the first."""

    def contains(self, xy_M: ArrayLike) -> Mask:
        """Which points (..., 2) [m] lie inside (...)."""
        xy = np.asarray(xy_M, dtype=float)
        x, y = xy[..., 0], xy[..., 1]
        inside = np.zeros(x.shape, dtype=bool)
        for (x0, y0), (x1, y1) in zip(self.points, self.points[1:] + self.points[:1], strict=True):
            if y0 != y1:
                crosses = (y0 > y) != (y1 > y)
                inside ^= crosses & (x < x0 + (y - y0) * (x1 - x0) / (y1 - y0))
        return inside

    @property
    def area(self) -> float:
        """Signed area [m^2], positive when the corners run counter-clockwise."""
        x, y = np.array(self.points).T
        return float(0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1)))


@dataclass(frozen=True)
class Rectangle:
    """A turned rectangle, frame M."""

    center: Point
    """[m]."""
    size: Point
    """Full edges along its own x and y [m]."""
    yaw: float = 0.0
    """Of its x axis in M [rad]."""

    def to_local(self, xy_M: ArrayLike) -> Array:
        """Points (..., 2) [m] in the rectangle's axes, from its centre."""
        c, s = np.cos(self.yaw), np.sin(self.yaw)
        return (np.asarray(xy_M, dtype=float) - self.center) @ np.array([[c, -s], [s, c]])

    def to_map(self, xy_local: ArrayLike) -> Array:
        """Points (..., 2) [m] of the rectangle's axes in M."""
        c, s = np.cos(self.yaw), np.sin(self.yaw)
        return self.center + np.asarray(xy_local, dtype=float) @ np.array([[c, s], [-s, c]])

    def contains(self, xy_M: ArrayLike, *, grown: float = 0.0) -> Mask:
        """Which points (..., 2) [m] lie inside when every edge moves out by ``grown`` [m]."""
        half = np.array(self.size) / 2 + grown
        return np.asarray((np.abs(self.to_local(xy_M)) < half).all(axis=-1))


Geometry = Circle | Polygon | Rectangle


@dataclass(frozen=True)
class Region:
    """A part of the floor that admits only some modes (the paper's circles, Sec. V-F)."""

    geometry: Geometry
    modes: tuple[Mode, ...]
    place: str
    """Where it was written, for messages."""

    @property
    def bits(self) -> int:
        """Bit set of :attr:`Mode.bit`."""
        return sum(mode.bit for mode in self.modes)


@dataclass(frozen=True)
class Stamp:
    """A shape that overwrites the occupancy, as Nav2's vector objects do."""

    geometry: Geometry
    value: int
    """-1 unknown, 0 free .. 100 occupied."""
    place: str
    """Where it was written, for messages."""


@dataclass(frozen=True)
class RoughPatch:
    """A rectangle of smooth random bumps that sink to the floor at its edge."""

    area: Rectangle
    amplitude: float = 0.03
    """Height of the highest bump [m]."""
    wavelength: float = 0.3
    """Typical distance from bump to bump [m]."""
    seed: int = 0


@dataclass(frozen=True)
class RaisedObject:
    """A board at a height: a table or shelf on four legs, or a block when it starts at 0."""

    area: Rectangle
    bottom: float
    """Height of its underside [m]; 0 makes it a block on the floor."""
    top: float
    """Height of its upper side [m]."""
    leg: float = 0.04
    """Edge of each square leg [m]; 0 for none (hung from a wall)."""

    @property
    def legs(self) -> tuple[Rectangle, ...]:
        """Footprints of the four legs, flush with the corners; none for a block."""
        if self.bottom <= 0 or self.leg <= 0:
            return ()
        x, y = (np.array(self.area.size) - self.leg) / 2
        corners = self.area.to_map([[-x, -y], [x, -y], [x, y], [-x, y]])
        return tuple(
            Rectangle((float(cx), float(cy)), (self.leg, self.leg), self.area.yaw)
            for cx, cy in corners
        )
