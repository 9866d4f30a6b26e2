"""How high the floor of a world is: its rough patches, as they are built in physics."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from mobius.world import World
from mobius.world.shapes import RoughPatch
from mobius.world.terrain import bumps

Array = NDArray[np.float64]
Heights = Callable[[Array], Array]
"""Heights (...) [m] at points (..., 2) [m], frame M."""


def floor_of(world: World) -> Heights | None:
    """Heights of the floor, bilinear between the samples of its patches; None where it is flat."""
    patches = [_heights(patch) for patch in world.rough]
    if not patches:
        return None

    def at(xy: Array) -> Array:
        return np.asarray(np.max([patch(xy) for patch in patches], axis=0))

    return at


def _heights(patch: RoughPatch) -> Heights:
    """Of one patch; 0 beside it."""
    height = bumps(patch)
    ny, nx = height.shape

    def at(xy: Array) -> Array:
        xy = np.asarray(xy, dtype=float)
        share = patch.area.to_local(xy) / patch.area.size + 0.5
        where = [share[..., 1] * (ny - 1), share[..., 0] * (nx - 1)]
        flat = [np.ravel(w) for w in where]
        z = map_coordinates(height, flat, order=1, mode="constant", cval=0.0)
        return np.asarray(z.reshape(xy.shape[:-1]))

    return at
