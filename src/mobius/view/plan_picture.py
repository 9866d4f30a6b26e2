"""A plan over its map as in Fig. 12: waypoints with the number of their mode, in its colour.

Number and colour of a waypoint are those of the step that leaves it, m(t) of Table IV; small
figures beside every fifth waypoint are t. Drawn along the grid's own axes, in metres.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke

from mobius import paper
from mobius.plan import Problem, cells_seen
from mobius.types import GridMap, Plan
from mobius.view.map_canvas import (
    COVERED,
    INK,
    OBSTACLE,
    PICTURE_DPI,
    PLANNED_MODES,
    canvas,
    cell_points,
    covered,
    forced,
    ground,
    legend_beside,
    metres,
    picture_size,
)
from mobius.view.palette import MODE_COLOURS
from mobius.view.png import save_png

__all__ = ["draw_plan", "picture_size"]

_HALO = withStroke(linewidth=2.0, foreground="white")
"""Round figures that may stand on an obstacle."""


def draw_plan(path: str | Path, problem: Problem, plan: Plan, *, title: str = "") -> None:
    """Write a picture of the plan.

    Args:
        path: A ``.png``; written whole or not at all.
        problem: Says which cells count as covered, and where the goal is.
        plan: A plan of that problem; may be empty.
        title: The map's name if empty.
    """
    grid = problem.grid
    figure, axes = canvas(grid)
    ground(axes, grid)
    if len(plan.cells):
        covered(axes, grid, cells_seen(problem, plan.cells, plan.modes))
        _way(axes, grid, plan)
    _ends(axes, grid, problem)
    _labels(axes, grid, title or grid.name, plan)
    _legend(axes, grid, plan)
    save_png(path, figure, dpi=PICTURE_DPI, what="a plan")


def _way(axes: Axes, grid: GridMap, plan: Plan) -> None:
    """Steps and waypoints in the colours of the modes."""
    at = plan.cells + 0.5
    point = cell_points(grid)
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
            look = {"color": INK, "fontsize": 0.5 * marker, "path_effects": [_HALO]}
            axes.text(x, y, str(t), ha="center", va="center", zorder=6, **look)


def _ends(axes: Axes, grid: GridMap, problem: Problem) -> None:
    """Start and goal: a ring and a star."""
    point = cell_points(grid)
    size = float(np.clip(0.9 * point, 8.0, 26.0))
    start, goal = np.array(problem.start) + 0.5, np.array(problem.goal) + 0.5
    axes.plot(*start, "o", ms=size, mfc="none", mec=INK, mew=1.6, zorder=6)
    axes.plot(*goal, "*", ms=size, color=INK, mec="white", mew=0.8, zorder=6)


def _labels(axes: Axes, grid: GridMap, title: str, plan: Plan) -> None:
    """Metres on the axes, and what is known of the plan in the title."""
    metres(axes, grid)
    switches = sum(a != b for a, b in zip(plan.modes[:-1], plan.modes[1:], strict=True))
    changes = f"{switches} change{'s' if switches != 1 else ''} of mode"
    figures = f"{plan.status}, {len(plan.modes)} steps, {changes}"
    axes.set_title(f"{title}: {figures}" if len(plan.cells) else f"{title}: no plan", fontsize=11)


def _legend(axes: Axes, grid: GridMap, plan: Plan) -> None:
    keys: list[Patch | Line2D] = []
    for mode in PLANNED_MODES:
        if mode in plan.modes:
            label = f"({paper.MODE_NUMBER[mode]}) {mode.value}"
            line: dict[str, Any] = {"color": MODE_COLOURS[mode], "mec": "white", "lw": 2}
            keys.append(Line2D([], [], marker="o", ms=10, label=label, **line))
    for mode in PLANNED_MODES:
        if forced(grid, mode).any():
            tint = 0.72 + 0.28 * np.array(to_rgba(MODE_COLOURS[mode]))
            keys.append(Patch(fc=tuple(tint), ec=MODE_COLOURS[mode], label=f"{mode.value} only"))
    keys.append(Patch(color=OBSTACLE, label="obstacle"))
    if len(plan.cells):
        keys.append(Patch(color=COVERED, label="covered"))
    mark: dict[str, Any] = {"ls": "none", "ms": 10}
    keys.append(Line2D([], [], marker="o", mfc="none", mec=INK, mew=1.6, label="start", **mark))
    keys.append(Line2D([], [], marker="*", color=INK, label="goal", **mark))
    legend_beside(axes, keys)
