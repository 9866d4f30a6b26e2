"""What is known of the floor: a fine raster of free, occupied and unknown pixels."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.errors import InvalidInput
from mobius.types import frozen_array

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

UNKNOWN = -1
"""Occupancy of a pixel nobody has seen."""
OCCUPIED_FROM = 50
"""A pixel is an obstacle from this occupancy [%] on: at least as likely full as empty."""


@dataclass(frozen=True, eq=False)
class OccupancyMap:
    """A raster of the floor in its own axes, placed in the map frame M.

    Pixel ``(row, col)`` covers ``[col, col+1) x [row, row+1)`` pixels along the raster's
    x and y axes; row 0 is the *bottom* row (the last one of the image file).
    """

    name: str
    """Where the map came from, for messages."""
    occupancy: NDArray[np.int8]
    """(h, w) chance of being occupied, 0..100 [%], or -1 unknown."""
    resolution: float
    """Edge of a pixel [m]."""
    origin_M: Array
    """(3,) x [m], y [m], yaw [rad] of the lower-left corner, frame M."""
    path: Path | None = None
    """The yaml or .map file, if there is one."""

    def __post_init__(self) -> None:
        if not (np.isfinite(self.resolution) and self.resolution > 0):
            raise InvalidInput(
                f"OccupancyMap.resolution: expected metres > 0, got {self.resolution}"
            )
        values = np.asarray(self.occupancy)
        if values.size == 0 or values.min() < UNKNOWN or values.max() > 100:
            raise InvalidInput(
                "OccupancyMap.occupancy: expected at least one pixel, each -1 or 0..100,"
                f" got shape {values.shape}"
            )
        frozen_array(self, "occupancy", values, (None, None), np.int8)
        frozen_array(self, "origin_M", self.origin_M, (3,))

    @property
    def shape(self) -> tuple[int, int]:
        """(h, w) pixels."""
        return self.occupancy.shape[0], self.occupancy.shape[1]

    @property
    def size(self) -> tuple[float, float]:
        """Extent along the raster's x and y axes [m]."""
        return self.shape[1] * self.resolution, self.shape[0] * self.resolution

    @property
    def occupied(self) -> Mask:
        """(h, w) True where something stands (unknown is not something)."""
        return self.occupancy >= OCCUPIED_FROM

    @property
    def unknown(self) -> Mask:
        """(h, w) True where nobody has looked."""
        return self.occupancy == UNKNOWN

    def to_local(self, xy_M: ArrayLike) -> Array:
        """Points (..., 2) [m] of M in the raster's axes, from its lower-left corner."""
        c, s = np.cos(self.origin_M[2]), np.sin(self.origin_M[2])
        return (np.asarray(xy_M, dtype=float) - self.origin_M[:2]) @ np.array([[c, -s], [s, c]])

    def to_map(self, xy_local: ArrayLike) -> Array:
        """Points (..., 2) [m] of the raster's axes in M."""
        c, s = np.cos(self.origin_M[2]), np.sin(self.origin_M[2])
        return self.origin_M[:2] + np.asarray(xy_local, dtype=float) @ np.array([[c, s], [-s, c]])

    def pixel_of(self, xy_M: ArrayLike) -> NDArray[np.int64]:
        """Pixels (..., 2) ``(row, col)`` that hold points of M [m]; may lie off the map."""
        local = self.to_local(xy_M)
        return np.floor(local[..., ::-1] / self.resolution).astype(np.int64)

    def holds(self, pixel: ArrayLike) -> bool:
        """Whether one pixel ``(row, col)`` lies on the map."""
        row, col = (int(v) for v in np.asarray(pixel))
        return 0 <= row < self.shape[0] and 0 <= col < self.shape[1]

    def pixel_centers(self) -> Array:
        """(h, w, 2) centres of all pixels [m], frame M."""
        h, w = self.shape
        x, y = (np.arange(w) + 0.5) * self.resolution, (np.arange(h) + 0.5) * self.resolution
        return self.to_map(np.stack(np.meshgrid(x, y), axis=-1))

    def describe_pixel(self, pixel: ArrayLike) -> str:
        """A pixel as an image editor shows it: column from the left, row from the top."""
        row, col = (int(v) for v in np.asarray(pixel))
        return f"pixel column {col}, row {self.shape[0] - 1 - row} from the top"
