"""A plan over its map as in Fig. 12: waypoints with the number of their mode, in its colour.

Number and colour of a waypoint are those of the step that leaves it, m(t) of Table IV; small
figures beside every fifth waypoint are t. Drawn along the grid's own axes, in metres.
"""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from mobius import paper
from mobius.errors import InvalidInput
from mobius.files import write_bytes_atomic
from mobius.plan import Problem, cells_seen
from mobius.types import GridMap, Mode, Plan
from mobius.view.palette import MODE_COLOURS

__all__ = ["PLAN_PICTURE_DPI", "draw_plan", "picture_size"]

PLAN_PICTURE_DPI = 100
_MODES = (Mode.BIPED, Mode.CRAWL, Mode.ROLL)
_LONG, _SHORT = 7.2, 2.4
"""Longest and least edge of the map in the picture [inch]."""
_LEFT, _RIGHT, _BOTTOM, _TOP = 0.7, 1.7, 0.6, 0.45
"""Room around the map [inch]; the legend stands on the right."""
_OBSTACLE, _COVERED, _GRID, _INK = "#4a4f57", "#f4d35e", "#dcdfe3", "#1d2126"


def picture_size(grid: GridMap) -> tuple[int, int]:
    """Width and height [pixels] of the picture of a plan on this map."""
    w, h = _map_size(grid)
    width, height = _LEFT + w + _RIGHT, max(_BOTTOM + h + _TOP, 4.0)
    return round(width * PLAN_PICTURE_DPI), round(height * PLAN_PICTURE_DPI)


def draw_plan(path: str | Path, problem: Problem, plan: Plan, *, title: str = "") -> None:
    """Write a picture of the plan.

    Args:
        path: A ``.png``; written whole or not at all.
        problem: Says which cells count as covered, and where the goal is.
        plan: A plan of that problem; may be empty.
        title: The map's name if empty.
    """
    if Path(path).suffix.lower() != ".png":
        raise InvalidInput(f"{path}: a plan is drawn as .png; give a name that ends in .png")
    grid = problem.grid
    figure, axes = _canvas(grid)
    _ground(axes, grid)
    if len(plan.cells):
        _covered(axes, grid, cells_seen(problem, plan.cells, plan.modes))
        _way(axes, grid, plan)
    _ends(axes, grid, problem)
    _labels(axes, grid, title or grid.name, plan)
    _legend(axes, grid, plan)
    sink = io.BytesIO()
    figure.savefig(sink, format="png", dpi=PLAN_PICTURE_DPI)
    try:
        write_bytes_atomic(path, sink.getbuffer())
    except OSError as error:
        raise InvalidInput(
            f"{path} cannot be written ({error.strerror}); choose another file"
        ) from None


def _map_size(grid: GridMap) -> tuple[float, float]:
    """Width and height [inch] of the map itself."""
    nx, ny = grid.shape
    unit = _LONG / max(nx, ny)
    return max(nx * unit, _SHORT), max(ny * unit, _SHORT)


def _canvas(grid: GridMap) -> tuple[Figure, Axes]:
    """A figure whose pixels are :func:`picture_size`, and axes in cells, equal both ways."""
    pixels = picture_size(grid)
    width, height = (p / PLAN_PICTURE_DPI for p in pixels)
    w, h = _map_size(grid)
    figure = Figure(figsize=(width, height))
    low = height - _TOP - h
    axes = figure.add_axes((_LEFT / width, low / height, w / width, h / height))
    nx, ny = grid.shape
    axes.set(xlim=(0, nx), ylim=(0, ny), aspect="equal", anchor="NW")
    return figure, axes


def _cell_points(grid: GridMap) -> float:
    """Edge of a cell in the picture [points of 1/72 inch]."""
    return 72.0 * _LONG / max(grid.shape)


def _ground(axes: Axes, grid: GridMap) -> None:
    """Obstacles, regions that force a mode, and the lines between cells."""
    picture = np.ones((*grid.shape, 4))
    for mode in _MODES:
        forced = _forced(grid, mode)
        tint = np.array(to_rgba(MODE_COLOURS[mode]))
        picture[forced] = 0.72 + 0.28 * tint
    picture[(grid.allowed == 0) & ~grid.blocked] = to_rgba("#b9bec6")
    picture[grid.blocked] = to_rgba(_OBSTACLE)
    nx, ny = grid.shape
    axes.imshow(
        picture.transpose(1, 0, 2),
        origin="lower",
        extent=(0, nx, 0, ny),
        interpolation="nearest",
        aspect="equal",
        zorder=0,
    )
    if _cell_points(grid) >= 6.0:
        axes.vlines(np.arange(1, nx), 0, ny, color=_GRID, lw=0.6, zorder=1)
        axes.hlines(np.arange(1, ny), 0, nx, color=_GRID, lw=0.6, zorder=1)


def _forced(grid: GridMap, mode: Mode) -> NDArray[np.bool_]:
    return (grid.allowed == mode.bit) & ~grid.blocked


def _covered(axes: Axes, grid: GridMap, seen: set[tuple[int, int]]) -> None:
    """Cells that count as seen, as squares a little smaller than a cell."""
    where = np.array(sorted(seen), dtype=float).reshape(-1, 2) + 0.5
    size = (0.8 * _cell_points(grid)) ** 2
    axes.scatter(
        where[:, 0], where[:, 1], s=size, marker="s", color=_COVERED, alpha=0.75, lw=0, zorder=2
    )


def _way(axes: Axes, grid: GridMap, plan: Plan) -> None:
    """Steps and waypoints in the colours of the modes."""
    at = plan.cells + 0.5
    point = _cell_points(grid)
    for t, mode in enumerate(plan.modes):
        axes.plot(*at[t : t + 2].T, color=MODE_COLOURS[mode], lw=max(1.2, 0.1 * point), zorder=3)
    marker = min(0.62 * point, 17.0)
    latest = {tuple(cell): t for t, cell in enumerate(plan.cells[:-1].tolist())}
    for t in latest.values():  # where the way crosses itself, the number of the last visit
        mode = plan.modes[t]
        axes.plot(*at[t], "o", ms=marker, color=MODE_COLOURS[mode], mec="white", mew=0.7, zorder=4)
        if marker >= 7.0:
            number = str(paper.MODE_NUMBER[mode])
            look: dict[str, Any] = {
                "color": "white",
                "fontsize": 0.62 * marker,
                "fontweight": "bold",
            }
            x, y = at[t]
            axes.text(x, y, number, ha="center", va="center_baseline", zorder=5, **look)
    if plan.modes:  # no step leaves the last one
        colour = MODE_COLOURS[plan.modes[-1]]
        axes.plot(*at[-1], "o", ms=0.45 * marker, color=colour, zorder=4)
    if marker >= 7.0:
        for t in range(0, len(plan.modes) + 1, 5):
            x, y = at[t] + np.where(at[t] < np.array(grid.shape) / 2, 0.62, -0.62)  # inwards
            axes.text(
                x, y, str(t), ha="center", va="center", zorder=6, color=_INK, fontsize=0.5 * marker
            )


def _ends(axes: Axes, grid: GridMap, problem: Problem) -> None:
    """Start and goal: a ring and a star."""
    point = _cell_points(grid)
    size = float(np.clip(0.9 * point, 8.0, 26.0))
    start, goal = np.array(problem.start) + 0.5, np.array(problem.goal) + 0.5
    axes.plot(*start, "o", ms=size, mfc="none", mec=_INK, mew=1.6, zorder=6)
    axes.plot(*goal, "*", ms=size, color=_INK, mec="white", mew=0.8, zorder=6)


def _labels(axes: Axes, grid: GridMap, title: str, plan: Plan) -> None:
    """Metres on the axes, and what is known of the plan in the title."""
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
    switches = sum(a != b for a, b in zip(plan.modes[:-1], plan.modes[1:], strict=True))
    changes = f"{switches} change{'s' if switches != 1 else ''} of mode"
    figures = f"{plan.status}, {len(plan.modes)} steps, {changes}"
    axes.set_title(f"{title}: {figures}" if len(plan.cells) else f"{title}: no plan", fontsize=11)


def _legend(axes: Axes, grid: GridMap, plan: Plan) -> None:
    keys: list[Patch | Line2D] = []
    for mode in _MODES:
        if mode in plan.modes:
            label = f"({paper.MODE_NUMBER[mode]}) {mode.value}"
            line: dict[str, Any] = {"color": MODE_COLOURS[mode], "mec": "white", "lw": 2}
            keys.append(Line2D([], [], marker="o", ms=10, label=label, **line))
    for mode in _MODES:
        if _forced(grid, mode).any():
            tint = 0.72 + 0.28 * np.array(to_rgba(MODE_COLOURS[mode]))
            keys.append(Patch(fc=tuple(tint), ec=MODE_COLOURS[mode], label=f"{mode.value} only"))
    keys.append(Patch(color=_OBSTACLE, label="obstacle"))
    if len(plan.cells):
        keys.append(Patch(color=_COVERED, label="covered"))
    mark: dict[str, Any] = {"ls": "none", "ms": 10}
    keys.append(Line2D([], [], marker="o", mfc="none", mec=_INK, mew=1.6, label="start", **mark))
    keys.append(Line2D([], [], marker="*", color=_INK, label="goal", **mark))
    axes.legend(
        handles=keys,
        loc="upper left",
        bbox_to_anchor=(1.02, 1.0),
        borderaxespad=0.0,
        frameon=False,
        fontsize=10,
        labelspacing=0.8,
    )
