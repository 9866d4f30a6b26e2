"""Video and stills of a run, drawn in child processes and encoded as H.264.

The file appears under its name only when it is whole. Drawing needs OpenGL (software is
enough): see :mod:`mobius.view.gl`.
"""

from __future__ import annotations

import contextlib
import tempfile
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path

import imageio_ffmpeg
import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image

from mobius.errors import InvalidInput, MobiusError
from mobius.files import copy_atomic
from mobius.view.camera import ChaseCamera, chase
from mobius.view.drawing import Job, draw
from mobius.view.gl import NoOpenGL
from mobius.view.paint import NO_BOXES, floor_height, plan_boxes, trail_boxes

__all__ = ["ChaseCamera", "NoOpenGL", "render_still", "render_video", "resample"]

Array = NDArray[np.float64]

_CRF = "21"


def render_video(
    path: str | Path,
    model: mujoco.MjModel,
    qpos: ArrayLike,
    *,
    qpos_fps: float = 30.0,
    fps: float = 20.0,
    speed: float = 1.0,
    size: tuple[int, int] = (960, 540),
    plan_xy: ArrayLike | None = None,
    plan_modes: Sequence[str] | None = None,
    path_true: ArrayLike | None = None,
    captions: Sequence[str] | None = None,
    mocap: ArrayLike | None = None,
    camera: ChaseCamera | None = None,
    oversample: float = 4 / 3,
    shadow: int = 1536,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> None:
    """Draw a run and write it as mp4 (H.264, yuv420p), whole or not at all.

    Args:
        path: Where to, ending in ``.mp4``.
        model: Robot and scene, with one free joint to follow.
        qpos: (m, nq) configurations, evenly spaced in time.
        qpos_fps: How many of them per second of the run [1/s].
        fps: Frames per second of the video [1/s].
        speed: Seconds of the run per second of the video.
        size: Width and height [px], both even.
        plan_xy: (T+1, 2) points of the plan [m], painted on the floor.
        plan_modes: T names of modes, one colour each.
        path_true: (p, 2) [m] way gone, evenly spaced over the same time as ``qpos``;
            painted as far as the robot has come.
        captions: m lines for the lower left corner.
        mocap: (m, c, 7) poses of the scene's c mocap bodies, if any have moved.
        camera: How the camera follows.
        oversample: Drawn so many times larger, then made small, against jagged edges.
        shadow: Edge of the shadow map [px], 0 for no shadows.
        workers: Drawing children; one per core, at most four, by default.
        progress: Called with frames done and frames in all.

    Raises:
        NoOpenGL: Nothing can be drawn here.
        InvalidInput: A shape, a size or a name does not fit.
    """
    path, rows = Path(path), _configurations(model, qpos)
    if path.suffix != ".mp4":
        raise InvalidInput(f"{path}: expected a file name ending in .mp4")
    _check(size, qpos_fps=qpos_fps, fps=fps, speed=speed, oversample=oversample)
    frames, source = resample(model, rows, qpos_fps=qpos_fps, fps=fps, speed=speed)
    boxes, shown = _paint(model, rows[0], plan_xy, plan_modes, path_true, source / len(rows))
    job = Job(
        qpos=frames,
        camera=chase(model, frames, speed / fps, camera=camera or ChaseCamera()),
        boxes=boxes,
        shown=shown,
        captions=_captions(captions, len(rows), source),
        mocap=_mocap(model, mocap, len(rows), source),
        shadow=shadow,
        **_enlarged(size, oversample),
    )
    with tempfile.TemporaryDirectory(prefix="mobius-video-") as folder:
        whole = Path(folder) / "video.mp4"
        with _encoder(whole, (job.width, job.height), size, fps) as encode:
            for done, picture in enumerate(draw(model, job, workers=workers), 1):
                encode(picture)
                if progress is not None:
                    progress(done, len(frames))
        copy_atomic(whole, path)


def render_still(
    model: mujoco.MjModel,
    qpos: ArrayLike,
    *,
    size: tuple[int, int] = (960, 540),
    plan_xy: ArrayLike | None = None,
    plan_modes: Sequence[str] | None = None,
    path_true: ArrayLike | None = None,
    caption: str = "",
    camera: ChaseCamera | None = None,
    oversample: float = 2.0,
    shadow: int = 4096,
) -> NDArray[np.uint8]:
    """One picture of one configuration, (height, width, 3) bytes, row 0 on top.

    Args:
        model: Robot and scene, with one free joint to look at.
        qpos: (nq,).
        size: Width and height [px], both even.
        plan_xy: As for :func:`render_video`.
        plan_modes: As for :func:`render_video`.
        path_true: (p, 2) [m], painted whole.
        caption: Line for the lower left corner.
        camera: Where from.
        oversample: Drawn so many times larger, then made small, against jagged edges.
        shadow: Edge of the shadow map [px], 0 for no shadows.

    Raises:
        NoOpenGL: Nothing can be drawn here.
        InvalidInput: A shape, a size or a name does not fit.
    """
    rows = _configurations(model, np.asarray(qpos, dtype=float)[None])
    _check(size, oversample=oversample)
    boxes, shown = _paint(model, rows[0], plan_xy, plan_modes, path_true, np.ones(1))
    job = Job(
        qpos=rows,
        camera=chase(model, rows, 1.0, camera=camera or ChaseCamera()),
        boxes=boxes,
        shown=shown,
        captions=np.array([caption]),
        mocap=_mocap(model, None, 1, np.zeros(1)),
        shadow=shadow,
        **_enlarged(size, oversample),
    )
    (picture,) = draw(model, job)
    large = Image.frombytes("RGB", (job.width, job.height), picture)
    return np.asarray(large.resize(size, Image.Resampling.BOX))


def resample(
    model: mujoco.MjModel, qpos: Array, *, qpos_fps: float, fps: float, speed: float
) -> tuple[Array, Array]:
    """Configurations at the times of the video's frames, on the way between recorded ones.

    Returns:
        (k, nq) configurations and (k,) where each lies in ``qpos``, in rows.
    """
    last = len(qpos) - 1
    count = int(np.floor(last / qpos_fps * fps / speed + 1e-9)) + 1
    source = np.minimum(np.arange(count) * (speed * qpos_fps / fps), last)
    frames = np.empty((count, model.nq))
    velocity = np.zeros(model.nv)
    for k, at in enumerate(source):
        row = min(int(at), max(last - 1, 0))
        frames[k] = qpos[row]
        if at > row:
            mujoco.mj_differentiatePos(model, velocity, 1.0, qpos[row], qpos[row + 1])
            mujoco.mj_integratePos(model, frames[k], velocity, at - row)
    return frames, source


def _configurations(model: mujoco.MjModel, qpos: ArrayLike) -> Array:
    rows = np.ascontiguousarray(qpos, dtype=float)
    if rows.ndim != 2 or rows.shape[1] != model.nq or not len(rows):
        raise InvalidInput(f"video: expected qpos (m, {model.nq}) with m >= 1, got {rows.shape}")
    if not np.isfinite(rows).all():
        raise InvalidInput("video: expected finite qpos, got NaN or infinity")
    return rows


def _check(size: tuple[int, int], **positive: float) -> None:
    if any(v <= 0 or v % 2 for v in size):
        raise InvalidInput(f"video: expected an even width and height [px], got {size}")
    for name, value in positive.items():
        if not (np.isfinite(value) and value > 0):
            raise InvalidInput(f"video: expected {name} > 0, got {value}")


def _enlarged(size: tuple[int, int], oversample: float) -> dict[str, int]:
    """Size to draw at, even, and the scale of captions that comes out as 100 %."""
    return {
        "width": 2 * round(size[0] * oversample / 2),
        "height": 2 * round(size[1] * oversample / 2),
        "text_scale": int(np.clip(50 * round(2 * oversample), 100, 300)),
    }


def _captions(captions: Sequence[str] | None, m: int, source: Array) -> NDArray[np.str_]:
    if captions is None:
        return np.zeros(0, dtype=str)
    if len(captions) != m:
        raise InvalidInput(f"video: expected {m} captions, one per qpos, got {len(captions)}")
    return np.array([captions[int(at)] for at in source])


def _mocap(model: mujoco.MjModel, mocap: ArrayLike | None, m: int, source: Array) -> Array:
    if mocap is None:
        return np.zeros((0, model.nmocap, 7))
    poses = np.asarray(mocap, dtype=float)
    if poses.shape != (m, model.nmocap, 7):
        raise InvalidInput(
            f"video: expected mocap ({m}, {model.nmocap}, 7), one row per qpos, got {poses.shape}"
        )
    return poses[source.astype(int)]


def _paint(
    model: mujoco.MjModel,
    qpos: Array,
    plan_xy: ArrayLike | None,
    plan_modes: Sequence[str] | None,
    path_true: ArrayLike | None,
    progress: Array,
) -> tuple[Array, NDArray[np.int64]]:
    """Boxes on the floor, and how many of them every frame shows; progress in [0, 1]."""
    floor = partial(floor_height, model, qpos)
    plan, trail, behind = NO_BOXES, NO_BOXES, np.zeros(1, dtype=np.int64)
    if plan_xy is not None:
        xy = np.asarray(plan_xy, dtype=float).reshape(-1, 2)
        plan = plan_boxes(xy, floor, modes=plan_modes)
    if path_true is not None and len(np.asarray(path_true)):
        xy = np.asarray(path_true, dtype=float)[:, :2]
        trail, behind = trail_boxes(xy, floor)
    at = np.minimum((progress * len(behind)).astype(int), len(behind) - 1)
    return np.concatenate([plan, trail]), len(plan) + behind[at]


@contextlib.contextmanager
def _encoder(
    path: Path, large: tuple[int, int], size: tuple[int, int], fps: float
) -> Iterator[Callable[[bytes], None]]:
    """A function that takes the next frame; the file is finished when the block ends."""
    writer = imageio_ffmpeg.write_frames(
        str(path),
        large,
        fps=fps,
        codec="libx264",
        pix_fmt_out="yuv420p",
        quality=None,
        macro_block_size=2,
        ffmpeg_log_level="error",
        output_params=[
            *("-vf", f"scale={size[0]}:{size[1]}:flags=area"),
            *("-crf", _CRF, "-preset", "veryfast", "-movflags", "+faststart"),
        ],
    )
    writer.send(None)
    try:
        yield writer.send
    except OSError as error:
        raise MobiusError(f"video: ffmpeg failed: {str(error).splitlines()[0]}") from None
    finally:
        writer.close()
