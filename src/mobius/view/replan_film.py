"""Replanning as a film: the map, what moves on it, the robot, and the plan of every moment."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import imageio_ffmpeg
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray
from PIL import Image

from mobius.errors import InvalidInput
from mobius.files import copy_atomic
from mobius.plan import Problem
from mobius.types import Mode, Plan
from mobius.view.map_canvas import (
    COVERED,
    INK,
    OBSTACLE,
    PLANNED_MODES,
    canvas,
    cell_points,
    covered,
    forced,
    ground,
    legend_beside,
    metres,
)
from mobius.view.palette import MODE_COLOURS

__all__ = ["Moment", "film_frames", "write_film"]

Frame = NDArray[np.uint8]
Cell = tuple[int, int]

_MOVING, _TRAIL = "#cf4444", "#6b7280"
_DPI = 64
_COLOURS = 96
"""Of a GIF: mode colours, their tints, and the greys of letters."""
_SUFFIXES = (".gif", ".mp4")


@dataclass(frozen=True, eq=False)
class Moment:
    """What is known before one step is made."""

    plan: Plan
    """Begins where the robot is; its first step is the one that will be made."""
    trail: NDArray[np.int64]
    """(n, 2) cells where the robot has been, the last is where it is."""
    seen: NDArray[np.bool_]
    """(nx, ny) cells covered so far."""
    moving: NDArray[np.bool_]
    """(nx, ny) cells that something else occupies."""


def write_film(
    path: str | Path, problem: Problem, moments: Sequence[Moment], *, fps: float = 5.0
) -> None:
    """Draw every moment and write the film.

    Args:
        path: A ``.gif`` or ``.mp4``; written whole or not at all.
        problem: Its grid is the ground, its start and goal are marked.
        moments: At least one, in order.
        fps: Moments per second [1/s], > 0.

    Raises:
        InvalidInput: Another suffix, no moments, or a place that cannot be written.
    """
    path, suffix = Path(path), Path(path).suffix.lower()
    if suffix not in _SUFFIXES:
        raise InvalidInput(f"{path}: expected a file that ends in {' or '.join(_SUFFIXES)}")
    if not moments or not fps > 0:
        raise InvalidInput(f"a film needs moments and fps > 0, got {len(moments)} and {fps}")
    frames = film_frames(problem, moments)
    with tempfile.TemporaryDirectory(prefix="mobius-film-") as folder:
        whole = Path(folder) / f"film{suffix}"
        (_write_gif if suffix == ".gif" else _write_mp4)(whole, frames, fps)
        try:
            copy_atomic(whole, path)
        except OSError as error:
            raise InvalidInput(
                f"{path} cannot be written ({error.strerror}); choose another file"
            ) from None


def film_frames(problem: Problem, moments: Sequence[Moment]) -> Iterator[Frame]:
    """One picture (h, w, 3) a moment, all of one size, both sides even."""
    grid = problem.grid
    figure, axes = canvas(grid)
    figure.set_dpi(_DPI)
    sheet = FigureCanvasAgg(figure)
    ground(axes, grid)
    metres(axes, grid)
    for what, look in (("start", {"marker": "o", "mfc": "none"}), ("goal", {"marker": "*"})):
        at = np.array(getattr(problem, what)) + 0.5
        axes.plot(*at, ms=13, color=INK, mew=1.4, ls="none", zorder=6, **look)  # type: ignore[arg-type]
    used = {mode for moment in moments for mode in moment.plan.modes}
    _legend(axes, problem, [m for m in problem.modes if m in used])
    fixed = set(axes.get_children())
    for step, moment in enumerate(moments):
        _draw(axes, problem, moment)
        ms = 1e3 * moment.plan.solve_s
        axes.set_title(
            f"step {step}: {int(moment.seen.sum())} cells covered, planned in {ms:.0f} ms",
            fontsize=11,
            loc="left",
        )
        sheet.draw()
        picture = np.asarray(sheet.buffer_rgba())[..., :3]
        h, w = picture.shape[:2]
        yield picture[: h - h % 2, : w - w % 2].copy()
        for artist in set(axes.get_children()) - fixed:
            artist.remove()


def _draw(axes: Axes, problem: Problem, moment: Moment) -> None:
    """Everything that changes from moment to moment."""
    point = cell_points(problem.grid)
    covered(axes, problem.grid, [(int(i), int(j)) for i, j in np.argwhere(moment.seen)])
    trail = moment.trail + 0.5
    axes.plot(trail[:, 0], trail[:, 1], color=_TRAIL, lw=0.09 * point, alpha=0.8, zorder=3)
    way = moment.plan.cells + 0.5
    for t, mode in enumerate(moment.plan.modes):
        axes.plot(*way[t : t + 2].T, color=MODE_COLOURS[mode], lw=0.13 * point, zorder=4)
    axes.plot(way[1:, 0], way[1:, 1], "o", ms=0.2 * point, color=INK, mew=0, zorder=5)
    others = np.argwhere(moment.moving) + 0.5
    size = (0.84 * point) ** 2
    axes.scatter(others[:, 0], others[:, 1], s=size, marker="s", color=_MOVING, lw=0, zorder=7)
    mode = moment.plan.modes[0] if moment.plan.modes else Mode.CRAWL
    look: dict[str, Any] = {"color": MODE_COLOURS[mode], "mec": "white", "mew": 1.2}
    axes.plot(*trail[-1], "o", ms=0.62 * point, zorder=8, **look)


def _legend(axes: Axes, problem: Problem, used: Sequence[Mode]) -> None:
    """What the colours mean, right of the map."""
    dot: dict[str, Any] = {"ls": "none", "ms": 9, "marker": "o"}
    keys: list[Patch | Line2D] = [
        Line2D([], [], color=MODE_COLOURS[m], lw=3, label=f"plan: {m.value}") for m in used
    ]
    keys.append(Line2D([], [], color=MODE_COLOURS[Mode.CRAWL], mec="white", label="robot", **dot))
    keys.append(Line2D([], [], color=_TRAIL, lw=2.5, label="way so far"))
    keys.append(Patch(color=_MOVING, label="moves"))
    keys.append(Patch(color=OBSTACLE, label="obstacle"))
    for mode in PLANNED_MODES:
        if forced(problem.grid, mode).any():
            tint = MODE_COLOURS[mode] + "48"
            keys.append(Patch(fc=tint, ec=MODE_COLOURS[mode], label=f"{mode.value} only"))
    keys.append(Patch(color=COVERED, label="covered"))
    keys.append(Line2D([], [], color=INK, mfc="none", label="start", **dot))
    keys.append(Line2D([], [], color=INK, **{**dot, "marker": "*"}, label="goal"))
    legend_beside(axes, keys)


def _write_gif(path: Path, frames: Iterator[Frame], fps: float) -> None:
    """One palette for all frames, so that only what changes is stored."""
    pictures = [Image.fromarray(f) for f in frames]
    palette = pictures[len(pictures) // 2].quantize(_COLOURS, dither=Image.Dither.NONE)
    small = [p.quantize(palette=palette, dither=Image.Dither.NONE) for p in pictures]
    small[0].save(
        path,
        save_all=True,
        append_images=small[1:],
        duration=[round(1e3 / fps)] * (len(small) - 1) + [2000],
        loop=0,
        optimize=True,
    )


def _write_mp4(path: Path, frames: Iterator[Frame], fps: float) -> None:
    """H.264, yuv420p."""
    first = next(frames)
    h, w = first.shape[:2]
    writer = imageio_ffmpeg.write_frames(
        str(path),
        (w, h),
        fps=fps,
        codec="libx264",
        pix_fmt_out="yuv420p",
        quality=None,
        macro_block_size=2,
        ffmpeg_log_level="error",
        output_params=["-crf", "23", "-preset", "veryfast", "-movflags", "+faststart"],
    )
    writer.send(None)
    try:
        for frame in (first, *frames):
            writer.send(np.ascontiguousarray(frame))
    finally:
        writer.close()
