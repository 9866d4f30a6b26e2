"""A world in which something stands that its map does not show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mobius.world.clearance import Clearance
from mobius.world.grid import refit
from mobius.world.load import World, blocked_pixels
from mobius.world.mission import check_mission
from mobius.world.occupancy import OccupancyMap
from mobius.world.shapes import Rectangle


def with_obstacles(world: World, areas: Sequence[Rectangle], *, check: bool = False) -> World:
    """The world with obstacles on these areas: raster, blocked cells and clearances follow.

    The grid keeps its place, so cells of a plan stay what they were.

    Args:
        world: As its map shows it.
        areas: Frame M; a pixel that one may touch is occupied.
        check: Whether start and goal must still be fit to start and end at, and joined.

    Raises:
        MapError: They are not, and ``check`` asks for it.
    """
    raster = world.occupancy
    if not areas:
        return world
    occupancy, centers = raster.occupancy.copy(), raster.pixel_centers()
    for area in areas:
        occupancy[area.contains(centers, grown=raster.resolution * np.sqrt(0.5))] = 100
    changed = OccupancyMap(
        raster.name, occupancy, raster.resolution, raster.origin_M, path=raster.path
    )
    clearance = Clearance(blocked_pixels(changed, world.raised), raster.resolution)
    grid, room = refit(world.grid, changed, clearance, disc=world.disc)
    if check:
        check_mission(changed, grid, clearance, disc=world.disc)
    return replace(world, occupancy=changed, grid=grid, clearance=room)
