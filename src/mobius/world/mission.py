"""Whether a robot can stand at a start and at a goal, and get from one to the other."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.barrier import thinnest, wall_between
from mobius.errors import MapError
from mobius.types import GridMap
from mobius.world.clearance import Clearance
from mobius.world.grid import Disc, components
from mobius.world.occupancy import OccupancyMap

Array = NDArray[np.float64]


def check_mission(raster: OccupancyMap, grid: GridMap, clearance: Clearance, *, disc: Disc) -> None:
    """Raise unless the grid's start and goal (those it has) are fit to start and end at.

    Raises:
        MapError: The robot does not fit at one of them, or cannot get from one to the other.
    """
    for what, point in (("start", grid.start), ("goal", grid.goal)):
        if point is not None:
            check_place(what, point, raster, grid, clearance, disc=disc)
    if grid.start is not None and grid.goal is not None:
        check_route(grid.start, grid.goal, grid, disc=disc)


def check_place(
    what: str,
    xy_M: ArrayLike,
    raster: OccupancyMap,
    grid: GridMap,
    clearance: Clearance,
    *,
    disc: Disc,
) -> None:
    """Raise unless the robot fits at a point (2,) [m] of M and its cell is free.

    Raises:
        MapError: Names the map, the point, what is there and the nearest free cell.
    """
    xy = np.asarray(xy_M, dtype=float)
    place = f"{raster.name}: {what} {_metres(xy)}"
    near = nearest_free(grid, xy)
    fix = (
        f"the nearest free cell is at {_metres(near)}"
        if near is not None
        else f"no cell of this map is free for a robot of radius {disc.radius:g} m"
    )
    pixel = raster.pixel_of(xy)
    if not raster.holds(pixel):
        w, h = raster.size
        x, y, yaw = raster.origin_M
        raise MapError(
            f"{place} lies off the map, whose lower-left corner is ({x:.2f}, {y:.2f}) m and whose"
            f" size is {w:.2f} x {h:.2f} m{'' if yaw == 0 else f', turned by {yaw:.2f} rad'}; {fix}"
        )
    where = raster.describe_pixel(pixel)
    for mask, thing in ((raster.occupied, "an obstacle"), (raster.unknown, "unknown space")):
        if mask[tuple(pixel)] and clearance.at(raster.to_local(xy)) == 0:
            raise MapError(f"{place} lies in {thing} ({where}); {fix}")
    room = float(clearance.at(raster.to_local(xy)))
    if room == 0:
        raise MapError(f"{place} lies in or under an obstacle ({where}); {fix}")
    if room < disc.radius:
        raise MapError(
            f"{place} is {room:.2f} m from an obstacle, the robot needs {disc.radius:.2f} m"
            f" ({where}); {fix}"
        )
    cell = grid.cell_of(xy)
    if not grid.holds(cell) or grid.blocked[tuple(cell)]:
        raise MapError(
            f"{place} lies in a blocked cell: no centre within reach is {disc.need:.2f} m from"
            f" every obstacle; {fix}, or use a smaller cell than {grid.cell:g} m"
        )


def check_route(start_M: ArrayLike, goal_M: ArrayLike, grid: GridMap, *, disc: Disc) -> None:
    """Raise unless free cells join the cells of start and goal (2,) [m]; both must be free.

    Raises:
        MapError: Names the map, both points, the wall between them and the reachable cell
            nearest to the goal.
    """
    start, goal = (tuple(grid.cell_of(p)) for p in (start_M, goal_M))
    part = components(grid.blocked)
    if part[start] == part[goal] != 0:
        return
    wall = wall_between(grid, thinnest(part == part[start], part == part[goal]))
    reachable = grid.center_of(np.argwhere(part == part[start]))
    goal_xy = np.asarray(goal_M, dtype=float)
    near = reachable[np.linalg.norm(reachable - goal_xy, axis=-1).argmin()]
    raise MapError(
        f"{grid.name}: goal {_metres(goal_xy)} cannot be reached from start"
        f" {_metres(np.asarray(start_M, dtype=float))} by a robot of radius {disc.radius:.2f} m"
        f" (+{disc.margin:.2f} m to spare{_lane(disc)}) on {grid.cell:.2f} m cells; {wall}, grown"
        f" by that radius; the nearest cell it can reach is at {_metres(near)}, or try a smaller"
        " cell"
    )


def nearest_free(grid: GridMap, xy_M: ArrayLike) -> Array | None:
    """(2,) centre [m] of the free cell nearest to a point (2,) of M, or None."""
    free = np.argwhere(~grid.blocked)
    if not len(free):
        return None
    centers = grid.center_of(free)
    return np.asarray(
        centers[np.linalg.norm(centers - np.asarray(xy_M, dtype=float), axis=-1).argmin()]
    )


def _lane(disc: Disc) -> str:
    return "" if disc.lane is None else f", {disc.lane:.2f} m in straight lanes"


def _metres(xy: ArrayLike) -> str:
    x, y = np.asarray(xy, dtype=float)
    return f"({x:.2f}, {y:.2f}) m"
