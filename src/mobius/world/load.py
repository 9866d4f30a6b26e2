"""A map file or a shipped map's name becomes a :class:`World`."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.errors import MapError, UnknownName
from mobius.types import ALL_MODES_BITS, GridMap
from mobius.world.clearance import Clearance
from mobius.world.grid import Disc, build_grid
from mobius.world.mission import check_mission
from mobius.world.movingai import read_movingai
from mobius.world.nav2 import read_nav2
from mobius.world.notes import Notes
from mobius.world.occupancy import OccupancyMap
from mobius.world.regions import add_regions
from mobius.world.shapes import RaisedObject, Region, RoughPatch

Array = NDArray[np.float64]

_FOLDER = Path(__file__).parent / "maps"
_DEFAULT_CELL = 0.5


@dataclass(frozen=True, eq=False)
class World:
    """Where the robot lives: what is known of the floor, and the grid laid over it."""

    name: str
    occupancy: OccupancyMap
    grid: GridMap
    """Obstacles inflated for ``disc``, modes admitted, start and goal."""
    clearance: Array
    """(nx, ny) distance from each cell's centre to the nearest obstacle [m]."""
    disc: Disc
    """The robot the grid was made for."""
    regions: tuple[Region, ...] = ()
    rough: tuple[RoughPatch, ...] = ()
    raised: tuple[RaisedObject, ...] = ()

    def __post_init__(self) -> None:
        clearance = np.array(self.clearance, dtype=float)
        clearance.setflags(write=False)
        object.__setattr__(self, "clearance", clearance)


def map_names() -> list[str]:
    """Names of the maps that ship with the package, sorted."""
    return sorted(path.stem for path in _FOLDER.glob("*.yaml"))


def map_path(name: str) -> Path:
    """The yaml of a shipped map. Raises :class:`UnknownName`."""
    if name not in map_names():
        raise UnknownName("map", name, map_names())
    return _FOLDER / f"{name}.yaml"


def load_world(
    source: str | Path,
    *,
    radius: float,
    margin: float = 0.1,
    lane: float | None = None,
    cell: float | None = None,
    start: ArrayLike | None = None,
    goal: ArrayLike | None = None,
    regions: str | Path | None = None,
    unknown_blocks: bool = True,
    headroom: float = 0.6,
) -> World:
    """Read a map and lay the planner's grid over it.

    Args:
        source: A Nav2 ``.yaml``, a MovingAI ``.map``, or the name of a shipped map.
        radius: Of the disc that holds the robot in every heading [m].
        margin: How far the robot's centre may stray from its planned line [m].
        lane: Least distance to obstacles where the robot can only walk straight [m]; None
            asks for ``radius + margin`` everywhere. See ``grid.py``.
        cell: Edge of a cell [m]; None takes the map's own, else 0.5.
        start: (2,) [m] in M; None takes the map's own, if it has one.
        goal: (2,) [m] in M; None takes the map's own, if it has one.
        regions: A file of more regions, see ``regions.py``.
        unknown_blocks: Whether pixels that nobody has seen count as obstacles.
        headroom: Raised objects block the floor beneath unless they start above this [m].

    Raises:
        MapError: A mistake in a file; a start or goal where the robot does not fit; a goal
            out of reach.
        UnknownName: The source is neither a file nor a shipped map.
    """
    raster, notes = _read(source, cell)
    if regions is not None:
        raster, notes = add_regions(raster, notes, regions)
    disc = Disc(radius, margin, lane)
    start = notes.start if start is None else start
    goal = notes.goal if goal is None else goal
    clearance = Clearance(
        blocked_pixels(raster, notes.raised, unknown_blocks=unknown_blocks, headroom=headroom),
        raster.resolution,
    )
    is_grid_already = raster.path is not None and raster.path.suffix == ".map"
    anchor = (0.0, 0.0) if is_grid_already else None
    grid, room = build_grid(
        raster,
        clearance,
        disc=disc,
        cell=cell or notes.cell or _DEFAULT_CELL,
        start=start,
        goal=goal,
        anchor=anchor,
    )
    check_mission(raster, grid, clearance, disc=disc)
    grid = replace(grid, allowed=allowed_modes(grid, raster, notes))
    return World(
        name=Path(source).stem,
        occupancy=raster,
        grid=grid,
        clearance=room,
        disc=disc,
        regions=notes.regions,
        rough=notes.rough,
        raised=notes.raised,
    )


def blocked_pixels(
    raster: OccupancyMap,
    raised: tuple[RaisedObject, ...] = (),
    *,
    unknown_blocks: bool = True,
    headroom: float = 0.6,
) -> NDArray[np.bool_]:
    """(h, w) pixels that the robot may not touch: obstacles, unknown, boards, legs.

    A pixel is under a board or leg when any part of it may be.
    """
    blocked = raster.occupied | raster.unknown if unknown_blocks else raster.occupied.copy()
    if raised:
        centers, half_diagonal = raster.pixel_centers(), raster.resolution * np.sqrt(0.5)
        for thing in raised:
            areas = thing.legs if thing.bottom >= headroom else (thing.area,)
            for area in areas:
                blocked |= area.contains(centers, grown=half_diagonal)
    return blocked


def allowed_modes(grid: GridMap, raster: OccupancyMap, notes: Notes) -> NDArray[np.uint8]:
    """(nx, ny) bit set of modes admitted at each cell's centre, by shapes and region image."""
    centers = grid.center_of(np.moveaxis(np.indices(grid.shape), 0, -1))
    allowed = np.full(grid.shape, ALL_MODES_BITS, np.uint8)
    if notes.region_bits is not None:
        pixels = raster.pixel_of(centers)
        h, w = raster.shape
        on_map = ((pixels >= 0) & (pixels < (h, w))).all(axis=-1)
        rows, cols = pixels[on_map].T
        allowed[on_map] = notes.region_bits[rows, cols]
    for region in notes.regions:
        allowed[region.geometry.contains(centers)] = region.bits
    return allowed


def _read(source: str | Path, cell: float | None) -> tuple[OccupancyMap, Notes]:
    path = Path(source)
    looks_like_a_file = path.suffix != "" or len(path.parts) > 1
    if isinstance(source, str) and not looks_like_a_file and not path.is_file():
        return read_nav2(map_path(source))
    if path.suffix == ".map":
        return read_movingai(path, cell=cell or _DEFAULT_CELL)
    if path.suffix in (".yaml", ".yml"):
        return read_nav2(path)
    raise MapError(
        f"{path}: expected a .yaml (Nav2) or .map (MovingAI) file, or one of the maps"
        f" {', '.join(map_names())}; name the map's .yaml, not its image"
    )
