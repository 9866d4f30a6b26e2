"""Fig. 13: the transitions A to D, ours, as strips with the centre of mass over the support.

``python -m mobius.reproduce.fig_13 [--out FILE.png]``. The paper shows photographs and the
offline trajectories; these are runs of the whole stack in simulation.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from mobius.errors import MobiusError
from mobius.geometry import rotate
from mobius.headless import import_mujoco
from mobius.reproduce.common import as_text, write_out

__all__ = ["TRANSITIONS", "Course", "course_of", "draw", "outside"]

Array = NDArray[np.float64]

TRANSITIONS = {
    "A": ("prone_to_crawl", "from the belly to crawl"),
    "B": ("stand_to_crawl", "from two legs to crawl"),
    "C": ("roll", "from crawl over the rails to crawl"),
    "D": ("crawl_to_stand", "from crawl to two legs"),
}
"""The paper's letter -> motion, and what it is."""
FRAMES = 6
"""Pictures in a strip."""
_INK, _SUPPORT, _PATH = "#1d2126", "#9fb8cf", "#c0392b"
_SIZE = (240, 240)


@dataclass(frozen=True, eq=False)
class Course:
    """Where the centre of mass goes over the support; n moments at 30 Hz of one motion.

    Lengths along the heading at the first moment (x) and to its left (y), from the centre of
    mass there [m].
    """

    t: Array
    """(n,) since the motion began [s]."""
    com: Array
    """(n, 2)."""
    height: Array
    """(n,) of the centre of mass [m]."""
    support: list[Array]
    """n arrays (k, 2): where the robot touches the floor."""


def course_of(footage: Any, rows: Sequence[int]) -> Course:
    """The course of a motion.

    Args:
        footage: A :class:`mobius.reel.Footage`.
        rows: First and last frame of the motion.
    """
    first, last = rows
    left = rotate(footage.qpos[first, 3:7], np.array([0.0, 1.0, 0.0]))  # level in all of them
    c, s = np.array([left[1], -left[0]]) / np.hypot(left[0], left[1])
    into = np.array([[c, -s], [s, c]])
    origin = footage.com[first, :2]
    pick = slice(first, last + 1)
    return Course(
        t=footage.t[pick] - footage.t[first],
        com=(footage.com[pick, :2] - origin) @ into,
        height=footage.com[pick, 2],
        support=[(p - origin) @ into for p in footage.support[pick]],
    )


def hull(points: Array) -> Array:
    """(k, 2) corners of the convex hull of points (p, 2), in order; the points where flat."""
    try:
        return points[ConvexHull(points).vertices] if len(points) > 2 else points
    except QhullError:
        return points


def outside(point: Array, points: Array) -> float:
    """How far (2,) a point is outside the hull of points (p, 2) [m]; negative inside.

    nan where fewer than three points, or points in a line, support.
    """
    try:
        return float((ConvexHull(points).equations @ [*point, 1.0]).max())
    except (QhullError, ValueError):
        return float("nan")


def draw(path: Path, parts: Sequence[tuple[str, str, list[NDArray[np.uint8]], Course]]) -> None:
    """Draw the figure.

    Args:
        path: A ``.png``.
        parts: Letter, what it is, FRAMES pictures and the course of each transition.
    """
    from mobius.view.png import save_png
    from mobius.view.sheet import pasted

    figure = Figure(figsize=(15.0, 2.1 * len(parts)), layout="constrained")
    grid = figure.subplots(len(parts), 3, width_ratios=(5.8, 1.6, 1.9), squeeze=False)
    for (strip, top, side), (letter, what, pictures, course) in zip(grid, parts, strict=True):
        strip.imshow(pasted(pictures, FRAMES))
        strip.set_axis_off()
        strip.set_title(f"({letter}) {what}", loc="left", fontsize=10, color=_INK)
        _from_above(top, course)
        _over_time(side, course)
    save_png(path, figure, dpi=100, what="Fig. 13")


def _from_above(axes: Axes, course: Course) -> None:
    """The support at the strip's moments, and the whole path."""
    for k in np.linspace(0, len(course.t) - 1, FRAMES).round().astype(int):
        corners = hull(course.support[k])
        if len(corners) > 2:
            axes.fill(*corners.T, fc=_SUPPORT, ec=_INK, lw=0.6, alpha=0.22)
        elif len(corners):
            axes.plot(*corners.T, color=_SUPPORT, marker="o", ms=2)
    axes.plot(*course.com.T, color=_PATH, lw=1.6)
    axes.plot(*course.com[0], "o", color=_PATH, mfc="white", ms=5)
    axes.plot(*course.com[-1], "o", color=_PATH, ms=5)
    axes.set_aspect("equal", adjustable="datalim")
    _labels(axes, "forward [m]", "left [m]")


def _over_time(axes: Axes, course: Course) -> None:
    """How far forward support and centre of mass are, over time."""
    low, high = (
        np.array([f(p[:, 0]) if len(p) else np.nan for p in course.support])
        for f in (np.min, np.max)
    )
    axes.fill_between(course.t, low, high, color=_SUPPORT, alpha=0.6, lw=0, label="support")
    axes.plot(course.t, course.com[:, 0], color=_PATH, lw=1.6, label="centre of mass")
    axes.legend(fontsize=7, frameon=False, loc="best")
    _labels(axes, "time [s]", "forward [m]")


def _labels(axes: Axes, x: str, y: str) -> None:
    axes.set_xlabel(x, fontsize=8)
    axes.set_ylabel(y, fontsize=8)
    axes.tick_params(labelsize=7)
    axes.spines[["top", "right"]].set_visible(False)


def filmed(seed: int) -> list[tuple[str, str, list[NDArray[np.uint8]], Course]]:
    """Play the four motions and draw their moments.

    Raises:
        MobiusError: Nothing can be drawn here, or a motion failed.
    """
    from mobius.reel import play
    from mobius.reel.shows import show_of
    from mobius.reel.write import SIDE, motion_rows
    from mobius.view.gl import gl_backend
    from mobius.view.sheet import draw_moments
    from mobius.view.stage import stage_model

    gl_backend()
    model, parts = stage_model(), []
    for letter, (name, what) in TRANSITIONS.items():
        footage = play(show_of(name), seed=seed)
        if footage.failed:
            raise MobiusError(
                f"{name} failed at seed {seed}: {footage.failed}; take another --seed"
            )
        rows = motion_rows(footage, FRAMES)
        stamps = [f"{footage.t[k] - footage.t[rows[0]]:.1f} s" for k in rows]
        pictures = draw_moments(model, footage.qpos, rows, captions=stamps, size=_SIZE, camera=SIDE)
        parts.append((letter, what, pictures, course_of(footage, (rows[0], rows[-1]))))
    return parts


def row_of(letter: str, what: str, course: Course) -> dict[str, Any]:
    """One line of what the figure shows, in numbers."""
    margin = np.array([outside(c, p) for c, p in zip(course.com, course.support, strict=True)])
    known = np.isfinite(margin)
    return {
        "": letter,
        "transition": what,
        "seconds": round(float(course.t[-1]), 2),
        "com from m": round(float(course.height[0]), 3),
        "to m": round(float(course.height[-1]), 3),
        "outside support, share": round(float((margin[known] > 0).mean()), 2),
    }


def main() -> None:
    """Play, draw, and print how far the centre of mass leaves the support."""
    parser = argparse.ArgumentParser(
        prog="python -m mobius.reproduce.fig_13", description="Fig. 13"
    )
    parser.add_argument("--out", type=Path, default=Path("fig_13.png"), help="the .png to write")
    parser.add_argument("--seed", type=int, default=0, help="of robot, floor and sensors")
    options = parser.parse_args()
    if options.seed < 0:
        sys.exit(f"fig_13: --seed: expected a whole number >= 0, got {options.seed}")
    import_mujoco()
    try:
        parts = filmed(options.seed)
    except MobiusError as error:
        sys.exit(f"fig_13: {error}")
    print(as_text([row_of(letter, what, course) for letter, what, _, course in parts]))
    write_out("fig_13", lambda: draw(options.out, parts), options.out)


if __name__ == "__main__":
    main()
