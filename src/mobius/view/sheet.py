"""Moments of a run as one picture: a grid of frames, each with its own caption."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image

from mobius.errors import InvalidInput
from mobius.view.camera import ChaseCamera, chase
from mobius.view.drawing import Job, draw
from mobius.view.paint import NO_BOXES
from mobius.view.png import write_picture

__all__ = ["draw_moments", "pasted", "write_sheet"]

Picture = NDArray[np.uint8]

_GAP = 4
"""Between the frames [px]."""
_COLOURS = 256
"""Of a sheet's palette: a third of the size, and no loss that is seen."""


def draw_moments(
    model: mujoco.MjModel,
    qpos: ArrayLike,
    rows: Sequence[int],
    *,
    captions: Sequence[str] | None = None,
    qpos_fps: float = 30.0,
    size: tuple[int, int] = (320, 180),
    camera: ChaseCamera | None = None,
    oversample: int = 2,
    shadow: int = 1536,
    workers: int | None = None,
) -> list[Picture]:
    """Frames of a run, seen by the camera that follows the whole run.

    Args:
        model: Robot and scene, with one free joint to follow.
        qpos: (m, nq) configurations, evenly spaced in time.
        rows: Which of them to draw.
        captions: A line for the lower left corner of each drawn frame.
        qpos_fps: Configurations per second [1/s].
        size: Width and height of a frame [px], both even.
        camera: How the camera follows.
        oversample: Drawn so many times larger, then made small, against jagged edges.
        shadow: Edge of the shadow map [px], 0 for no shadows.
        workers: Drawing children; one per core, at most four, by default.

    Returns:
        Pictures (height, width, 3).

    Raises:
        NoOpenGL: Nothing can be drawn here.
        InvalidInput: No row, one that is not there, or captions that do not fit.
    """
    all_rows = np.ascontiguousarray(qpos, dtype=float)
    chosen = np.asarray(rows, dtype=int)
    if not chosen.size or chosen.min() < 0 or chosen.max() >= len(all_rows):
        raise InvalidInput(f"sheet: expected rows from 0 to {len(all_rows) - 1}, got {list(rows)}")
    if captions is not None and len(captions) != len(chosen):
        raise InvalidInput(f"sheet: expected {len(chosen)} captions, got {len(captions)}")
    sight = chase(model, all_rows, 1.0 / qpos_fps, camera=camera or ChaseCamera())
    large = size[0] * oversample, size[1] * oversample
    job = Job(
        qpos=all_rows[chosen],
        camera=sight[chosen],
        boxes=NO_BOXES,
        shown=np.zeros(len(chosen), dtype=np.int64),
        captions=np.zeros(0, dtype=str) if captions is None else np.array(captions),
        width=large[0],
        height=large[1],
        shadow=shadow,
        text_scale=int(np.clip(100 * oversample, 100, 300)),
    )
    return [
        np.asarray(Image.frombytes("RGB", large, p).resize(size, Image.Resampling.BOX))
        for p in draw(model, job, workers=workers)
    ]


def pasted(pictures: Sequence[Picture], columns: int) -> Picture:
    """Pictures of one size on white, row by row; (height, width, 3)."""
    height, width = pictures[0].shape[:2]
    lines = -(-len(pictures) // columns)
    shape = (lines * (height + _GAP) - _GAP, columns * (width + _GAP) - _GAP, 3)
    sheet = np.full(shape, 255, dtype=np.uint8)
    for k, picture in enumerate(pictures):
        y, x = (k // columns) * (height + _GAP), (k % columns) * (width + _GAP)
        sheet[y : y + height, x : x + width] = picture
    return sheet


def write_sheet(path: str | Path, pictures: Sequence[Picture], *, columns: int) -> None:
    """Write a contact sheet as ``.png``, whole or not at all.

    Args:
        path: Ends in ``.png``.
        pictures: Of one size.
        columns: Frames in a row, >= 1.
    """
    if Path(path).suffix.lower() != ".png":
        raise InvalidInput(f"{path}: a contact sheet is drawn as .png; give a name that ends so")
    sink = io.BytesIO()
    small = Image.fromarray(pasted(pictures, columns)).quantize(_COLOURS)
    small.save(sink, format="PNG", optimize=True)
    write_picture(path, sink.getvalue())
