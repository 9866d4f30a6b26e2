"""The map of a run: walls, cells, plan, the way gone and the way believed."""

from __future__ import annotations

import html
from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.errors import InvalidInput
from mobius.types import GridMap, Mode, Plan
from mobius.view.palette import MODE_COLOURS
from mobius.view.svg import png_data, tag, text, ticks

__all__ = ["Occupancy", "floor_map"]

Array = NDArray[np.float64]

_LONGEST = 900.0
_MARGIN = 44.0


class Occupancy(Protocol):
    """What really stands there, finer than the planner's cells.

    :class:`mobius.world.OccupancyMap` is one; rooms do not know one another, so only what
    is used of it is written here.
    """

    @property
    def occupied(self) -> NDArray[np.bool_]:
        """(h, w) True where something stands; row 0 is the bottom row."""

    @property
    def resolution(self) -> float:
        """Edge of a pixel [m]."""

    @property
    def origin_M(self) -> Array:
        """(3,) x [m], y [m], yaw [rad] of the lower-left corner, frame M."""


class _Frame:
    """Metres of M onto pixels: x to the right, y up."""

    def __init__(self, corners: Array) -> None:
        self.low, self.high = corners.min(axis=0), corners.max(axis=0)
        span = np.maximum(self.high - self.low, 1e-3)
        self.scale = _LONGEST / float(span.max())
        self.width = float(span[0] * self.scale + 2 * _MARGIN)
        self.height = float(span[1] * self.scale + 2 * _MARGIN)

    def __call__(self, xy: ArrayLike) -> Array:
        p = np.asarray(xy, dtype=float)
        x = _MARGIN + (p[..., 0] - self.low[0]) * self.scale
        y = self.height - _MARGIN - (p[..., 1] - self.low[1]) * self.scale
        return np.stack([x, y], axis=-1)

    def matrix(self, origin: Array, unit: float) -> str:
        """SVG transform of a figure in units of ``unit`` [m] laid at ``origin`` (x, y, yaw)."""
        c, s = np.cos(origin[2]) * unit * self.scale, np.sin(origin[2]) * unit * self.scale
        x, y = self(origin[:2])
        return f"matrix({c:.5f} {-s:.5f} {-s:.5f} {-c:.5f} {x:.3f} {y:.3f})"


def floor_map(
    grid: GridMap,
    plan: Plan,
    true_xy: Array,
    belief_xy: Array,
    *,
    goal: Array,
    occupancy: Occupancy | None = None,
    modes: Sequence[str] | None = None,
    later: Sequence[Plan] = (),
) -> str:
    """The map as an SVG with a legend.

    Args:
        grid: Cells of the planner.
        plan: Drawn in the colours of its modes.
        true_xy: (n, 2) [m] in M.
        belief_xy: (n, 2) [m] in M.
        goal: (2,) [m] in M.
        occupancy: Walls and obstacles, drawn beneath.
        modes: n names; the true way is drawn in their colours where there are several.
        later: Plans made on the way, drawn thinner.
    """
    frame = _Frame(_corners(grid, occupancy, true_xy))
    parts = [_axes(frame)]
    if occupancy is not None:
        parts.append(_walls(frame, occupancy))
    parts += [_cells(frame, grid), _plan(frame, plan)]
    parts += [_plan(frame, other, width=3) for other in later]
    parts.append(_path(frame, belief_xy, "line belief map"))
    several = modes is not None and len(set(modes)) > 1
    parts.append(
        _coloured(frame, true_xy, modes)
        if several and modes is not None
        else _path(frame, true_xy, "line true map")
    )
    parts += [_start(frame, true_xy[0]), _goal(frame, goal)]
    parts.append(tag("circle", r=4, cx=-99, cy=-99, class_="ghost belief"))
    parts.append(
        tag(
            "path", d="M11 0L-6 6L-3 0L-6 -6z", class_="ghost robot", transform="translate(-99 -99)"
        )
    )
    picture = tag(
        "svg",
        "".join(parts),
        viewBox=f"0 0 {frame.width:.0f} {frame.height:.0f}",
        class_="floor",
        role="img",
        aria_label="Map with plan and path",
        data_map=" ".join(
            f"{v:.6g}" for v in (frame.low[0], frame.low[1], frame.scale, _MARGIN, frame.height)
        ),
    )
    legend = _legend(plan, occupancy, modes if several else None)
    return f"<figure><figcaption>{legend}</figcaption>{picture}</figure>"


def _corners(grid: GridMap, occupancy: Occupancy | None, true_xy: Array) -> Array:
    nx, ny = grid.shape
    unit = np.array([[0, 0], [nx, 0], [0, ny], [nx, ny]], dtype=float)
    boxes = [_place(unit * grid.cell, grid.origin_M), true_xy[np.isfinite(true_xy).all(axis=1)]]
    if occupancy is not None:
        if occupancy.occupied.ndim != 2 or not occupancy.resolution > 0:
            raise InvalidInput(
                "report: expected an occupancy raster (h, w) and a resolution > 0 m, got"
                f" {occupancy.occupied.shape} and {occupancy.resolution}"
            )
        h, w = occupancy.occupied.shape
        size = np.array([w, h]) * occupancy.resolution
        unit = np.array([[0, 0], [1, 0], [0, 1], [1, 1]]) * size
        boxes.append(_place(unit, occupancy.origin_M))
    return np.concatenate(boxes)


def _place(local: Array, origin: Array) -> Array:
    c, s = np.cos(origin[2]), np.sin(origin[2])
    return np.asarray(origin[:2]) + local @ np.array([[c, s], [-s, c]])


def _axes(frame: _Frame) -> str:
    parts = []
    span = frame.high - frame.low
    most_x, most_y = (max(2, round(9 * s / span.max())) for s in span.tolist())
    for value in ticks(float(frame.low[0]), float(frame.high[0]), most=most_x):
        x = float(frame((value, 0.0))[0])
        parts.append(tag("line", x1=x, x2=x, y1=_MARGIN, y2=frame.height - _MARGIN, class_="grid"))
        parts.append(
            text(x, frame.height - _MARGIN + 18, f"{value:g}", class_="tick", text_anchor="middle")
        )
    for value in ticks(float(frame.low[1]), float(frame.high[1]), most=most_y):
        y = float(frame((0.0, value))[1])
        parts.append(tag("line", x1=_MARGIN, x2=frame.width - _MARGIN, y1=y, y2=y, class_="grid"))
        parts.append(text(_MARGIN - 8, y + 5, f"{value:g}", class_="tick", text_anchor="end"))
    parts.append(
        text(
            frame.width - _MARGIN, frame.height - 8, "x [m]", class_="tick soft", text_anchor="end"
        )
    )
    parts.append(text(6, _MARGIN - 12, "y [m]", class_="tick soft"))
    return "".join(parts)


def _walls(frame: _Frame, occupancy: Occupancy) -> str:
    """The fine picture: image rows run downwards, so the raster is turned over, twice."""
    h, w = occupancy.occupied.shape
    pixels = np.zeros((h, w, 4), dtype=np.uint8)
    pixels[occupancy.occupied[::-1]] = (110, 116, 124, 255)
    flip = "matrix(1 0 0 -1 0 " + str(h) + ")"
    image = tag(
        "image",
        href=png_data(pixels),
        x=0,
        y=0,
        width=w,
        height=h,
        transform=flip,
        preserveAspectRatio="none",
        class_="field",
    )
    return tag("g", image, transform=frame.matrix(occupancy.origin_M, occupancy.resolution))


def _cells(frame: _Frame, grid: GridMap) -> str:
    """Blocked cells, and cells that force one mode in its colour."""
    parts = [tag("path", d=_rectangles(grid.blocked), class_="blocked")]
    for mode in (Mode.BIPED, Mode.CRAWL, Mode.ROLL):
        forced = (grid.allowed == mode.bit) & ~grid.blocked
        if forced.any():
            parts.append(
                tag("path", d=_rectangles(forced), fill=MODE_COLOURS[mode], fill_opacity=0.16)
            )
    return tag("g", "".join(parts), transform=frame.matrix(grid.origin_M, grid.cell))


def _rectangles(cells: NDArray[np.bool_]) -> str:
    """One path over all True cells, runs along x joined."""
    pieces = []
    for j in range(cells.shape[1]):
        edges = np.flatnonzero(np.diff(np.concatenate([[0], cells[:, j].astype(np.int8), [0]])))
        for a, b in zip(edges[::2], edges[1::2], strict=True):
            pieces.append(f"M{a} {j}H{b}V{j + 1}H{a}z")
    return "".join(pieces)


def _plan(frame: _Frame, plan: Plan, *, width: int | None = None) -> str:
    p = frame(plan.xy_M)
    parts = []
    for t, mode in enumerate(plan.modes):
        (x1, y1), (x2, y2) = p[t], p[t + 1]
        parts.append(
            tag(
                "line",
                x1=x1,
                y1=y1,
                x2=x2,
                y2=y2,
                class_="plan",
                stroke=MODE_COLOURS[mode],
                **({} if width is None else {"style": f"stroke-width:{width}"}),
            )
        )
    return "".join(parts)


def _coloured(frame: _Frame, xy: Array, modes: Sequence[str]) -> str:
    """The way gone on a dark seam, each stretch in the colour of the mode it was gone in."""
    parts, begin = [_path(frame, xy, "line true map seam")], 0
    for k in range(1, len(modes) + 1):
        if k == len(modes) or modes[k] != modes[begin]:
            stretch = xy[begin : k + 1]
            colour = MODE_COLOURS.get(modes[begin], "#777777")
            parts.append(_path(frame, stretch, "line map", colour=colour))
            begin = k
    return "".join(parts)


def _path(frame: _Frame, xy: Array, style: str, *, colour: str | None = None) -> str:
    """The way gone, thinned to steps of about two pixels."""
    p = frame(xy[np.isfinite(xy).all(axis=1)])
    keep, last = [], np.array([np.inf, np.inf])
    for k, point in enumerate(p):
        if k == len(p) - 1 or np.abs(point - last).max() >= 2.0:
            keep.append(point)
            last = point
    own = {} if colour is None else {"stroke": colour}
    points = " ".join(f"{x:.1f},{y:.1f}" for x, y in keep)
    return tag("polyline", points=points, class_=style, **own)


def _start(frame: _Frame, xy: Array) -> str:
    x, y = frame(xy)
    return tag("circle", cx=x, cy=y, r=7, class_="mark") + text(
        x + 11, y - 9, "start", class_="label halo"
    )


def _goal(frame: _Frame, xy: Array) -> str:
    x, y = frame(xy)
    cross = tag(
        "path", d=f"M{x - 9:.1f} {y:.1f}H{x + 9:.1f}M{x:.1f} {y - 9:.1f}V{y + 9:.1f}", class_="mark"
    )
    ring = tag("circle", cx=x, cy=y, r=9, class_="mark")
    return cross + ring + text(x + 13, y - 11, "goal", class_="label halo")


def _legend(plan: Plan, occupancy: Occupancy | None, modes: Sequence[str] | None) -> str:
    keys = [
        f'<span><i style="background:{MODE_COLOURS[m]}"></i>plan, {html.escape(m)}</span>'
        for m in dict.fromkeys(plan.modes)
    ]
    if modes is None:
        keys.append('<span><i class="true"></i>true path</span>')
    keys += [
        f'<span><i style="background:{MODE_COLOURS.get(m, "#777777")};height:3px"></i>'
        f"true path, {html.escape(m.replace('_', ' '))}</span>"
        for m in dict.fromkeys(modes or ())
    ]
    keys.append('<span><i class="belief"></i>believed path</span>')
    keys.append('<span><i class="blocked"></i>blocked for the robot\'s centre</span>')
    if occupancy is not None:
        keys.append('<span><i class="walls"></i>walls and obstacles</span>')
    return f'<span>Map <small>[m]</small></span><span class="keys">{"".join(keys)}</span>'
