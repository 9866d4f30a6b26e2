"""What a camera of the robot sees, drawn in a child process while the robot goes on.

The child (``python -m mobius.view.eye``) has the model in a file, reads configurations from
standard input and writes pixels to standard output. The loop of the robot never waits for it: it
hands over a configuration when the child is idle, and takes a picture when there is one.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import threading
from pathlib import Path
from typing import Any, BinaryIO

import mujoco
import numpy as np
from numpy.typing import NDArray

from mobius.errors import MobiusError
from mobius.view.gl import gl_backend

__all__ = ["Eye"]

Array = NDArray[np.float64]
Pixels = NDArray[np.uint8]


class Eye:
    """A camera that never keeps anybody waiting; ``with`` ends its child.

    Args:
        model: Scene with the robot.
        camera: Its name in the model.
        size: Width and height [px].

    Raises:
        NoOpenGL: Nothing can be drawn here.
    """

    def __init__(
        self, model: mujoco.MjModel, *, camera: str = "head", size: tuple[int, int] = (320, 240)
    ) -> None:
        backend = gl_backend()
        self.size, self._nq = size, model.nq
        self._folder = tempfile.TemporaryDirectory(prefix="mobius-eye-")
        path = Path(self._folder.name) / "model.mjb"
        mujoco.mj_saveModel(model, str(path))
        words = [str(path), camera, str(size[0]), str(size[1])]
        self._child = subprocess.Popen(
            [sys.executable, "-m", "mobius.view.eye", *words],
            env={**os.environ, "MUJOCO_GL": backend, "LP_NUM_THREADS": "1"},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,  # Ctrl-C is for the robot's program, which ends its child
        )
        self._asked: float | None = None
        self._seen: tuple[float, Pixels] | None = None
        self._dead = False
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def look(self, qpos: Array, stamp: float) -> None:
        """Begin a picture of a configuration (nq,) unless one is being drawn.

        Raises :class:`MobiusError` where the child has died.
        """
        if self._dead:
            raise MobiusError("the camera's drawing process has ended; run without --camera")
        if self._asked is None and self._child.stdin is not None:
            self._asked = stamp
            self._child.stdin.write(np.ascontiguousarray(qpos, dtype=float).tobytes())
            self._child.stdin.flush()

    def take(self) -> tuple[float, Pixels] | None:
        """Stamp [s] and pixels (height, width, 3) of a new picture, once; None without one."""
        seen, self._seen = self._seen, None
        return seen

    def _read(self) -> None:
        width, height = self.size
        pipe = self._child.stdout
        while pipe is not None:
            data = pipe.read(3 * width * height)
            if len(data) < 3 * width * height:
                self._dead = True
                return
            stamp, self._asked = self._asked, None
            pixels = np.frombuffer(data, dtype=np.uint8).reshape(height, width, 3)
            self._seen = (stamp or 0.0, pixels)

    def close(self) -> None:
        """End the child."""
        self._child.kill()
        self._child.wait()
        self._reader.join()
        for pipe in (self._child.stdin, self._child.stdout):
            if pipe is not None:
                pipe.close()
        self._folder.cleanup()

    def __enter__(self) -> Eye:
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()


def _draw(path: str, camera: str, width: int, height: int, ask: BinaryIO, tell: BinaryIO) -> None:
    """The child: one picture for every configuration; the robot comes first."""
    if hasattr(os, "nice"):
        os.nice(10)
    model = mujoco.MjModel.from_binary_path(path)
    model.vis.global_.offwidth, model.vis.global_.offheight = width, height
    model.vis.quality.offsamples, model.vis.quality.shadowsize = 0, 1
    data = mujoco.MjData(model)
    with mujoco.Renderer(model, height, width) as renderer:
        for flag in (mujoco.mjtRndFlag.mjRND_SHADOW, mujoco.mjtRndFlag.mjRND_REFLECTION):
            renderer.scene.flags[flag] = False
        while len(words := ask.read(8 * model.nq)) == 8 * model.nq:
            data.qpos[:] = np.frombuffer(words)
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            mujoco.mj_camlight(model, data)
            renderer.update_scene(data, camera=camera)
            tell.write(renderer.render().tobytes())
            tell.flush()


if __name__ == "__main__":
    _draw(
        sys.argv[1],
        sys.argv[2],
        int(sys.argv[3]),
        int(sys.argv[4]),
        sys.stdin.buffer,
        sys.stdout.buffer,
    )
