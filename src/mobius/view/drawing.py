"""Drawing children: frames are dealt out to a few of them like cards and taken back in turn."""

from __future__ import annotations

import os
import subprocess
import tempfile
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray

from mobius.errors import MobiusError
from mobius.view.gl import gl_backend, last_line, worker_command

__all__ = ["Job", "draw"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Job:
    """What is to be drawn: k pictures of one model."""

    qpos: Array
    """(k, nq)."""
    camera: Array
    """(k, 6) as :func:`mobius.view.camera.chase` gives it."""
    boxes: Array
    """(b, 19) painted boxes, see :class:`mobius.view.render_worker.Painter`."""
    shown: NDArray[np.int64]
    """(k,) how many of the boxes each picture shows."""
    captions: NDArray[np.str_]
    """(k,) lines for the lower left corner, or none at all (0,)."""
    width: int
    """[px]."""
    height: int
    """[px]."""
    shadow: int
    """Edge of the shadow map [px], 0 for no shadows."""
    text_scale: int
    """Size of captions, 100, 150, 200, 250 or 300 [%]."""
    mocap: Array = field(default_factory=lambda: np.zeros((0, 0, 7)))
    """(k, c, 7) positions [m] and quaternions of the scene's c mocap bodies; none (0, c, 7)
    leaves them where the model has them."""


def draw(model: mujoco.MjModel, job: Job, *, workers: int | None = None) -> Iterator[bytes]:
    """Raw pixels (height, width, 3) of the pictures, in order.

    Args:
        model: Robot and scene.
        job: What to draw.
        workers: Drawing children; one per core, at most four, by default.

    Raises:
        NoOpenGL: Nothing can be drawn here.
        MobiusError: A child ended early; the message says why.
    """
    backend, frames = gl_backend(), len(job.qpos)
    count = min(workers or min(os.cpu_count() or 1, 4), frames)
    threads = max(1, (os.cpu_count() or 1) // count)
    env = {**os.environ, "MUJOCO_GL": backend, "LP_NUM_THREADS": str(threads)}
    with tempfile.TemporaryDirectory(prefix="mobius-draw-") as name:
        folder = Path(name)
        mujoco.mj_saveModel(model, str(folder / "model.mjb"))
        np.savez(folder / "job.npz", **asdict(job))
        children: list[subprocess.Popen[bytes]] = []
        try:
            for index in range(count):
                children.append(_start(folder, index, count, env))
            for k in range(frames):
                picture = _read(children[k % count], 3 * job.width * job.height)
                if picture is None:
                    why = _complaint(folder, k % count, children[k % count])
                    raise MobiusError(f"video: drawing stopped at frame {k} of {frames}: {why}")
                yield picture
        finally:
            for child in children:
                child.kill()
                child.communicate()


def _start(folder: Path, index: int, count: int, env: dict[str, str]) -> subprocess.Popen[bytes]:
    """One child; what it complains of goes to a file, so that no pipe fills up unread."""
    with open(folder / f"stderr-{index}", "wb") as complaints:
        return subprocess.Popen(
            worker_command(str(folder), str(index), str(count)),
            stdout=subprocess.PIPE,
            stderr=complaints,
            env=env,
        )


def _read(child: subprocess.Popen[bytes], size: int) -> bytes | None:
    """The next picture, None when the child has ended before it was whole."""
    if child.stdout is None:
        return None
    picture = child.stdout.read(size)
    return picture if len(picture) == size else None


def _complaint(folder: Path, index: int, child: subprocess.Popen[bytes]) -> str:
    code = child.wait()
    said = (folder / f"stderr-{index}").read_text(errors="replace")
    return last_line(said) or f"exit code {code}"
