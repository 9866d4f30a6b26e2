"""The map under a plan: obstacles, ground that forces a mode, metres on the axes.

Drawn along the grid's own axes, in cells; the axes of the picture say metres.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from numpy.typing import NDArray

from mobius.types import GridMap, Mode
from mobius.view.palette import MODE_COLOURS

__all__ = [
    "COVERED", "INK", "OBSTACLE", "PICTURE_DPI", "PLANNED_MODES", "canvas", "cell_points",
    "covered", "forced", "ground", "legend_beside", "metres", "picture_size",
]  # fmt: skip

PICTURE_DPI = 100
PLANNED_MODES = (Mode.BIPED, Mode.CRAWL, Mode.ROLL)
_LONG, _SHORT = 7.2, 2.4
"""Longest and least edge of the map in the picture [inch]."""
_LEFT, _RIGHT, _BOTTOM, _TOP = 0.7, 1.7, 0.6, 0.45
"""Room around the map [inch]; the legend stands on the right."""
OBSTACLE, COVERED, INK = "#4a4f57", "#f4d35e", "#1d2126"
_GRID = "#dcdfe3"


def picture_size(grid: GridMap) -> tuple[int, int]:
    """Width and height [pixels] of the picture of a plan on this map."""
    w, h = _map_size(grid)
    width, height = _LEFT + w + _RIGHT, max(_BOTTOM + h + _TOP, 4.0)
    return round(width * PICTURE_DPI), round(height * PICTURE_DPI)


def _map_size(grid: GridMap) -> tuple[float, float]:
    """Width and height [inch] of the map itself."""
    nx, ny = grid.shape
    unit = _LONG / max(nx, ny)
    return max(nx * unit, _SHORT), max(ny * unit, _SHORT)


def canvas(grid: GridMap) -> tuple[Figure, Axes]:
    """A figure whose pixels are :func:`picture_size`, and axes in cells, equal both ways."""
    pixels = picture_size(grid)
    width, height = (p / PICTURE_DPI for p in pixels)
    w, h = _map_size(grid)
    figure = Figure(figsize=(width, height))
    low = height - _TOP - h
    axes = figure.add_axes((_LEFT / width, low / height, w / width, h / height))
    nx, ny = grid.shape
    axes.set(xlim=(0, nx), ylim=(0, ny), aspect="equal", anchor="NW")
    return figure, axes


def cell_points(grid: GridMap) -> float:
    """Edge of a cell in the picture [points of 1/72 inch]."""
    return 72.0 * _LONG / max(grid.shape)


def ground(axes: Axes, grid: GridMap) -> None:
    """Obstacles, regions that force a mode, and the lines between cells."""
    picture = np.ones((*grid.shape, 4))
    for mode in PLANNED_MODES:
        only = forced(grid, mode)
        tint = np.array(to_rgba(MODE_COLOURS[mode]))
        picture[only] = 0.72 + 0.28 * tint
    picture[(grid.allowed == 0) & ~grid.blocked] = to_rgba("#b9bec6")
    picture[grid.blocked] = to_rgba(OBSTACLE)
    nx, ny = grid.shape
    axes.imshow(
        picture.transpose(1, 0, 2),
        origin="lower",
        extent=(0, nx, 0, ny),
        interpolation="nearest",
        aspect="equal",
        zorder=0,
    )
    if cell_points(grid) >= 6.0:
        axes.vlines(np.arange(1, nx), 0, ny, color=_GRID, lw=0.6, zorder=1)
        axes.hlines(np.arange(1, ny), 0, nx, color=_GRID, lw=0.6, zorder=1)


def forced(grid: GridMap, mode: Mode) -> NDArray[np.bool_]:
    """(nx, ny) free cells that admit one mode only."""
    return (grid.allowed == mode.bit) & ~grid.blocked


def covered(axes: Axes, grid: GridMap, seen: Iterable[tuple[int, int]]) -> None:
    """Cells that count as seen, as squares a little smaller than a cell."""
    where = np.array(sorted(seen), dtype=float).reshape(-1, 2) + 0.5
    size = (0.8 * cell_points(grid)) ** 2
    axes.scatter(
        where[:, 0], where[:, 1], s=size, marker="s", color=COVERED, alpha=0.75, lw=0, zorder=2
    )


def metres(axes: Axes, grid: GridMap) -> None:
    """Metres on the axes."""
    nx, ny = grid.shape
    turned = bool(abs(grid.origin_M[2]) > 1e-9)
    for axis, n, name, origin in (
        (axes.xaxis, nx, "x", grid.origin_M[0]),
        (axes.yaxis, ny, "y", grid.origin_M[1]),
    ):
        every = max(1, int(np.ceil(n / 10)))
        at = np.arange(0, n + 1, every)
        zero = 0.0 if turned else float(origin)
        axis.set_ticks(at, [f"{zero + k * grid.cell:g}" for k in at], fontsize=9)
        axis.set_label_text(f"{name} of the grid [m]" if turned else f"{name} [m]")


def legend_beside(axes: Axes, keys: Sequence[Artist]) -> None:
    """What the signs mean, to the right of a map."""
    axes.legend(
        handles=list(keys),
        loc="upper left",
        bbox_to_anchor=(1.02, 1.0),
        borderaxespad=0.0,
        frameon=False,
        fontsize=10,
        labelspacing=0.8,
    )
