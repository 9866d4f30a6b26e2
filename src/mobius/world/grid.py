"""The planner's grid: cells where the robot's centre may be, and straight moves between them.

The robot is a disc of ``radius`` whose centre follows the lines between the centres of
neighbouring cells, off them by at most ``margin``. With ``need = radius + margin``:

1. A cell is free when its centre is at least ``need`` away from every obstacle.
2. That alone does not make moves safe: a corner may poke between two centres that are
   both clear of it (centres 0.5 m apart, need 0.36 m: a point 0.27 m beside the middle of
   the line is 0.368 m from both). Wherever the line between two free neighbours comes
   closer than ``need``, one of the two cells is blocked, the one with more such lines,
   then with less clearance, then with the larger index; repeated until no such line is
   left. Blocking a cell never spoils another line, so this ends.

Hence the promise that the planner, which knows only blocked cells, relies on: *every
straight move through free cells sweeps the disc through free space*, and turning on the
spot is free everywhere. Distances are exact, see ``clearance.py``.

A robot that walks straight needs less than one that turns. With ``lane`` (half its width
plus what it strays) below ``need``, lines must keep only ``lane`` clear, and

3. a cell between ``lane`` and ``need`` stays free if it can only be passed straight: its
   free neighbours are exactly the two left and right of it, or the two before and behind.
   Cells that fail are blocked, least clearance first, until none is left.

So every turn of a path happens at ``need``; a doorway narrower than the turning robot is
still a way through.

Where the grid lies is ours to choose. A gap of width g admits a lane of centres
``g - 2 need`` wide; a fixed grid misses it whenever no row of centres falls in. So the
lower-left corner is tried at every offset below one cell, in steps of about a tenth
(lattice points), and the best one wins, in this order:

1. start and goal (those given) lie in free cells, with a clear straight line to the
   centre, and are connected;
2. the farther of the two is nearest to its cell's centre (in whole steps);
3. the most cells connected to the start (without one: the largest connected part);
4. the smallest offset in y, then in x.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage

from mobius.errors import InvalidInput
from mobius.types import ALL_MODES_BITS, GridMap
from mobius.world.clearance import Clearance
from mobius.world.lanes import cut, keep_lanes
from mobius.world.occupancy import OccupancyMap

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Offset = tuple[float, float]
Cell = tuple[int, int]

_TRIES = 10
"""Offsets tried per axis."""
_MAX_CELLS = 4_000_000
_EPS = 1e-9


@dataclass(frozen=True)
class Disc:
    """The robot as the grid sees it."""

    radius: float
    """Of the disc that holds the robot in every heading [m]."""
    margin: float = 0.1
    """How far its centre may stray from the line it follows [m]."""
    lane: float | None = None
    """Least distance to obstacles where it can only walk straight [m]; None: ``need``."""

    def __post_init__(self) -> None:
        for name in ("radius", "margin", "lane"):
            value = getattr(self, name)
            if value is not None and not (np.isfinite(value) and value >= 0):
                raise InvalidInput(f"Disc.{name}: expected metres >= 0, got {value}")
        if self.lane is not None and self.lane > self.need:
            raise InvalidInput(
                f"Disc.lane: expected at most radius + margin = {self.need:.3f} m, got {self.lane}"
            )

    @property
    def need(self) -> float:
        """Least distance of a cell's centre to an obstacle [m] where it may turn."""
        return self.radius + self.margin

    @property
    def straight(self) -> float:
        """Least distance of a line between cells to an obstacle [m]."""
        return self.need if self.lane is None else self.lane


def build_grid(
    raster: OccupancyMap,
    clearance: Clearance,
    *,
    disc: Disc,
    cell: float = 0.5,
    start: ArrayLike | None = None,
    goal: ArrayLike | None = None,
    anchor: Offset | None = None,
) -> tuple[GridMap, Array]:
    """Lay a grid over a map.

    Args:
        raster: The map; the grid is aligned with its axes.
        clearance: Distance to what blocks the robot, on the same raster.
        disc: The robot.
        cell: Edge of a cell [m].
        start: (2,) [m], frame M.
        goal: (2,) [m], frame M.
        anchor: Lower-left corner of a cell in the raster's axes [m], for a grid over the
            whole map. None searches, and leaves out what lies more than a cell beyond the
            last point where the robot fits (a SLAM map is mostly unknown).

    Returns:
        The grid, every mode allowed, and the clearance (nx, ny) [m] of its cells' centres.
    """
    if not (np.isfinite(cell) and cell > 0):
        raise InvalidInput(f"build_grid: expected a cell of more than 0 m, got {cell}")
    width, height = raster.size
    if (width / cell + 2) * (height / cell + 2) > _MAX_CELLS:
        raise InvalidInput(
            f"build_grid: cells of {cell:g} m on a map of {width:.1f} x {height:.1f} m are more"
            f" than {_MAX_CELLS}; use larger cells"
        )
    ahead = clearance.ahead(cell, axis=0), clearance.ahead(cell, axis=1)
    bounds = np.array([(0.0, 0.0), (width, height)])
    if anchor is None:
        bounds = _worth_covering(clearance, disc, cell, bounds)
    fit = _Fit(clearance, disc, cell, bounds, ahead)
    ends = [None if p is None else raster.to_local(p) for p in (start, goal)]
    offsets = [anchor] if anchor is not None else _offsets(cell, clearance.step)
    best = max(offsets, key=lambda offset: fit.score(offset, *ends))
    blocked, centre_clearance = fit.cells(best)
    low = fit.corner(best)
    grid = GridMap(
        name=raster.name,
        cell=cell,
        origin_M=np.array([*raster.to_map(low), raster.origin_M[2]]),
        blocked=blocked,
        allowed=np.full(blocked.shape, ALL_MODES_BITS, np.uint8),
        start=None if start is None else np.asarray(start, dtype=float),
        goal=None if goal is None else np.asarray(goal, dtype=float),
    )
    return grid, centre_clearance


def refit(
    grid: GridMap, raster: OccupancyMap, clearance: Clearance, *, disc: Disc
) -> tuple[GridMap, Array]:
    """The same cells over a map that has changed: only what is blocked is worked out anew.

    Args:
        grid: Keeps its place, modes, start and goal.
        raster: The changed map, in the axes of the old one.
        clearance: Distance to what blocks the robot now.
        disc: The robot.

    Returns:
        The grid and the clearance (nx, ny) [m] of its cells' centres.
    """
    low = raster.to_local(grid.origin_M[:2])
    x, y = (low[k] + (np.arange(grid.shape[k]) + 0.5) * grid.cell for k in (0, 1))
    ahead = clearance.ahead(grid.cell, axis=0), clearance.ahead(grid.cell, axis=1)
    fit = _Fit(clearance, disc, grid.cell, np.array([(0.0, 0.0), raster.size]), ahead)
    blocked, room = fit.judge(x, y)
    return replace(grid, blocked=blocked), room


def components(blocked: Mask) -> NDArray[np.int64]:
    """(nx, ny) number of the connected part each free cell belongs to, 0 where blocked."""
    return np.asarray(ndimage.label(~blocked)[0], dtype=np.int64)


def _worth_covering(clearance: Clearance, disc: Disc, cell: float, whole: Array) -> Array:
    """(2, 2) the part of the map [m] where the robot fits, one cell wider."""
    fits = clearance.values >= max(disc.need, _EPS)
    if not fits.any():
        return whole
    spans = [np.flatnonzero(fits.any(axis=axis))[[0, -1]] * clearance.step for axis in (0, 1)]
    low_high = np.array(spans).T + np.array([[-cell], [cell]])
    return np.clip(low_high, whole[0], whole[1])


def _offsets(cell: float, step: float) -> list[Offset]:
    """Offsets below one cell, on the lattice, y slowest."""
    stride = step * max(1, round(cell / _TRIES / step))
    line = [k * stride for k in range(max(1, int(np.ceil(cell / stride - _EPS))))]
    return [(x, y) for y in line for x in line]


@dataclass(frozen=True)
class _Fit:
    """One map, robot and cell size, tried at many offsets."""

    clearance: Clearance
    disc: Disc
    cell: float
    bounds: Array
    """(2, 2) lower and upper corner of what the cells must cover [m]."""
    ahead: tuple[Array, Array]
    """Least clearance on the line of one cell's length along +x and +y, per lattice point."""

    def corner(self, offset: Offset) -> Array:
        """(2,) lower-left corner of cell (0, 0) [m]: the offset plus whole cells."""
        cells = np.floor((self.bounds[0] - offset) / self.cell + _EPS)
        return np.asarray(offset + cells * self.cell)

    def centers(self, offset: Offset) -> tuple[Array, Array]:
        """Coordinates (nx,) and (ny,) of the cells' centres [m]; the cells cover the bounds."""
        low = self.corner(offset)
        counts = np.ceil((self.bounds[1] - low) / self.cell - _EPS).astype(int)
        x, y = (low[k] + (np.arange(counts[k]) + 0.5) * self.cell for k in (0, 1))
        return x, y

    def cells(self, offset: Offset) -> tuple[Mask, Array]:
        """Blocked (nx, ny) and clearance of centres (nx, ny) [m]."""
        return self.judge(*self.centers(offset))

    def judge(self, x: Array, y: Array) -> tuple[Mask, Array]:
        """The same for cells with centres at x (nx,) and y (ny,) [m]."""
        value = self.clearance.sample_grid(self.clearance.values, x, y)
        blocked = ~_enough(value, self.disc.straight)
        along_x, along_y = (self.clearance.sample_grid(t, x, y) for t in self.ahead)
        bad_x = ~_enough(along_x[:-1], self.disc.straight)
        bad_y = ~_enough(along_y[:, :-1], self.disc.straight)
        cut(blocked, bad_x, bad_y, value)
        keep_lanes(blocked, ~_enough(value, self.disc.need), value)
        return blocked, value

    def score(self, offset: Offset, start: Array | None, goal: Array | None) -> tuple[int, ...]:
        """What is best, best first; see the module's docstring."""
        blocked, _ = self.cells(offset)
        part = components(blocked)
        homes, stray = [], 0.0
        for point in (start, goal):
            if point is not None:
                home, distance = self._home(point, offset, part)
                homes.append(home)
                stray = max(stray, distance)
        connected = all(home > 0 and home == homes[0] for home in homes)
        sizes = np.bincount(part.ravel(), minlength=2)
        sizes[0] = 0
        size = sizes[homes[0]] if start is not None else sizes.max()
        return (
            int(connected),
            sum(home > 0 for home in homes),
            -round(stray / (self.cell / _TRIES)),
            int(size),
        )

    def _home(self, point: Array, offset: Offset, part: NDArray[np.int64]) -> tuple[int, float]:
        """Connected part a point's cell belongs to (0: none), and how far its centre is [m]."""
        i, j = np.floor((point - self.corner(offset)) / self.cell).astype(int)
        if not (0 <= i < part.shape[0] and 0 <= j < part.shape[1]):
            return 0, self.cell
        centre = self.corner(offset) + (np.array([i, j]) + 0.5) * self.cell
        distance = float(np.linalg.norm(point - centre))
        # sampled lines are pessimistic by up to about one lattice step
        clear = self.clearance.along(point, centre) >= self.disc.radius - self.clearance.step
        return (int(part[i, j]) if clear else 0), distance


def _enough(value: Array, need: float) -> Mask:
    return (value >= need - _EPS) & (value > 0)
