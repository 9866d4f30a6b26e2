"""The walls of a world as few boxes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from mobius.world.cover import Mask, cover, worth_building
from mobius.world.grid import components
from mobius.world.load import World
from mobius.world.shapes import Rectangle


@dataclass(frozen=True)
class SceneOptions:
    """How a world is built. All of it collides with what the two bit masks let it."""

    wall_height: float = 0.5
    """[m]."""
    probe: float = 0.15
    """Walls are exact wherever a disc of this radius can roll from the robot's cells [m]."""
    near: float = 0.15
    """Obstacles farther than this behind a reachable surface are left out [m]."""
    fill: float = 0.2
    """Outside cavities, boxes may run through hidden pixels this far from an obstacle [m]."""
    contype: int = 1
    conaffinity: int = 1


def wall_boxes(world: World, *, options: SceneOptions | None = None) -> list[tuple[Rectangle, str]]:
    """Footprints of the walls in M and the material of each: room walls, or what stands free."""
    options = options or SceneOptions()
    raster, grid = world.occupancy, world.grid
    inside = np.zeros(raster.shape, dtype=bool)
    rows, cols = raster.pixel_of(grid.center_of(_home_cells(world))).T
    inside[rows, cols] = True
    px = raster.resolution
    must, may = worth_building(
        raster.occupied,
        inside,
        probe=options.probe / px,
        near=options.near / px,
        fill=options.fill / px,
    )
    boxes = cover(must, may)
    outer = _bounds_the_floor(raster.occupied, inside)
    return [
        (_rectangle(world, box), "world_wall" if _any(outer, box) else "world_block")
        for box in boxes.tolist()
    ]


def _home_cells(world: World) -> NDArray[np.int64]:
    """(n, 2) free cells connected to the start; without one, the largest connected part."""
    grid = world.grid
    part = components(grid.blocked)
    if grid.start is not None:
        home = part[tuple(grid.cell_of(grid.start))]
    else:
        home = np.argmax(np.bincount(part.ravel(), minlength=2)[1:]) + 1
    return np.argwhere((part == home) & (part > 0))


def _bounds_the_floor(occupied: Mask, inside: Mask) -> Mask:
    """(h, w) obstacles, one connected part at a time, that reach beyond the free cells."""
    if not inside.any():
        return occupied
    rows, cols = np.nonzero(inside)
    among = np.zeros_like(occupied)
    among[rows.min() : rows.max() + 1, cols.min() : cols.max() + 1] = True
    parts, _ = ndimage.label(occupied, np.ones((3, 3)))
    return occupied & np.isin(parts, np.unique(parts[~among]))


def _any(mask: Mask, box: list[int]) -> bool:
    row0, col0, row1, col1 = box
    return bool(mask[row0:row1, col0:col1].any())


def _rectangle(world: World, box: list[int]) -> Rectangle:
    row0, col0, row1, col1 = box
    px = world.occupancy.resolution
    x, y = world.occupancy.to_map([(col0 + col1) / 2 * px, (row0 + row1) / 2 * px])
    size = ((col1 - col0) * px, (row1 - row0) * px)
    return Rectangle((float(x), float(y)), size, float(world.occupancy.origin_M[2]))
