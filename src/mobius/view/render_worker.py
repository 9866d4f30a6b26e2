"""The child process that draws. Started by :mod:`mobius.view.drawing`, never imported by it.

``python -m mobius.view.render_worker --probe`` draws one pixel and says whether that
worked. ``... JOB INDEX COUNT`` draws every COUNT-th frame of the job folder from INDEX on
and writes the raw pixels to standard output; it ends when nobody reads them any more.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray

__all__ = ["Painter"]

_LIGHT_DISTANCE = 4.0
_SHADOW_REACH = 3.5
"""Shadows are cast this far around the robot [m]."""
_SLICES, _STACKS = 12, 6


class Painter:
    """Draws configurations of one model off screen.

    Args:
        model: Robot and scene; its visual quality settings are overwritten.
        size: Width and height [px].
        shadow: Edge of the shadow map [px]; 0 draws no shadows.
        text_scale: Size of captions, 100, 150, 200, 250 or 300 [%].
        max_geoms: Room for what is drawn beside the model.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        size: tuple[int, int],
        *,
        shadow: int,
        text_scale: int = 100,
        max_geoms: int = 0,
    ) -> None:
        quality, screen = model.vis.quality, model.vis.global_
        # Without a graphics card multisampling costs more than a larger picture made small.
        quality.offsamples, quality.shadowsize = 0, max(shadow, 1)
        # Round things of a robot are small on the screen: few facets, twice the speed.
        quality.numslices, quality.numstacks = _SLICES, _STACKS
        screen.offwidth, screen.offheight = size
        model.vis.map.shadowclip = _SHADOW_REACH / model.stat.extent
        self._gl = mujoco.GLContext(*size)
        self._gl.make_current()
        self._context = mujoco.MjrContext(model, text_scale)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        self._model, self._data = model, mujoco.MjData(model)
        self._option, self._camera = mujoco.MjvOption(), mujoco.MjvCamera()
        self._scene = mujoco.MjvScene(model, maxgeom=model.ngeom + max_geoms + 100)
        self._scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = shadow > 0
        self._scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = False
        self._view = mujoco.MjrRect(0, 0, *size)
        self._pixels = np.empty((size[1], size[0], 3), dtype=np.uint8)

    def draw(
        self,
        qpos: NDArray[np.float64],
        camera: NDArray[np.float64],
        *,
        boxes: NDArray[np.float64],
        caption: str = "",
        mocap: NDArray[np.float64] | None = None,
    ) -> NDArray[np.uint8]:
        """One picture.

        Args:
            qpos: (nq,).
            camera: (6,) as :func:`mobius.view.camera.chase` gives it.
            boxes: (b, 19) painted boxes: centre (3), half sizes (3), rotation matrix (9),
                red, green, blue, opacity (4).
            caption: Written in the lower left corner.
            mocap: (c, 7) positions [m] and quaternions of the c mocap bodies.

        Returns:
            (height, width, 3) bytes, row 0 on top.
        """
        self._data.qpos[:] = qpos
        if mocap is not None:
            self._data.mocap_pos[:], self._data.mocap_quat[:] = mocap[:, :3], mocap[:, 3:]
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_comPos(self._model, self._data)
        mujoco.mj_camlight(self._model, self._data)
        mujoco.mj_tendon(self._model, self._data)
        view = self._camera
        view.lookat[:], view.distance = camera[:3], camera[3]
        view.azimuth, view.elevation = np.degrees(camera[4]), np.degrees(camera[5])
        mujoco.mjv_updateScene(
            self._model,
            self._data,
            self._option,
            None,
            view,
            mujoco.mjtCatBit.mjCAT_ALL,
            self._scene,
        )
        self._carry_lights(camera[:3])
        self._add_boxes(boxes)
        mujoco.mjr_render(self._view, self._scene, self._context)
        if caption:
            font, corner = mujoco.mjtFont.mjFONT_NORMAL, mujoco.mjtGridPos.mjGRID_BOTTOMLEFT
            mujoco.mjr_overlay(font, corner, self._view, caption, "", self._context)
        mujoco.mjr_readPixels(self._pixels, None, self._view, self._context)
        return self._pixels[::-1]

    def close(self) -> None:
        """Give the OpenGL context back."""
        self._context.free()
        self._gl.free()

    def _carry_lights(self, look: NDArray[np.float64]) -> None:
        """Directional lights cast shadows only near their own place: keep them overhead."""
        for light in self._scene.lights[: self._scene.nlight]:
            if light.type == mujoco.mjtLightType.mjLIGHT_DIRECTIONAL and not light.headlight:
                light.pos[:] = look - _LIGHT_DISTANCE * np.asarray(light.dir)

    def _add_boxes(self, boxes: NDArray[np.float64]) -> None:
        for box in boxes:
            geom = self._scene.geoms[self._scene.ngeom]
            mujoco.mjv_initGeom(
                geom,
                mujoco.mjtGeom.mjGEOM_BOX,
                box[3:6],
                box[:3],
                box[6:15],
                box[15:].astype(np.float32),
            )
            geom.emission, geom.specular, geom.shininess = 0.0, 0.0, 0.0
            geom.category = mujoco.mjtCatBit.mjCAT_DECOR
            self._scene.ngeom += 1


def _probe() -> None:
    painter = Painter(mujoco.MjModel.from_xml_string("<mujoco/>"), (8, 8), shadow=0)
    painter.draw(np.zeros(0), np.array([0, 0, 0, 1, 0, -1.0]), boxes=np.zeros((0, 19)))
    painter.close()


def _work(folder: Path, index: int, count: int) -> None:
    job = np.load(folder / "job.npz")
    model = mujoco.MjModel.from_binary_path(str(folder / "model.mjb"))
    qpos, camera, boxes, shown = job["qpos"], job["camera"], job["boxes"], job["shown"]
    mocap = job["mocap"]
    width, height, shadow, text_scale = (
        int(job[name]) for name in ("width", "height", "shadow", "text_scale")
    )
    painter = Painter(
        model, (width, height), shadow=shadow, text_scale=text_scale, max_geoms=len(boxes)
    )
    # Not sys.stdout.buffer: under PYTHONUNBUFFERED it has no buffer, and a pipe takes less
    # than a picture at a time.
    with open(sys.stdout.fileno(), "wb", closefd=False) as pipe:
        for k in range(index, len(qpos), count):
            caption = str(job["captions"][k]) if len(job["captions"]) else ""
            picture = painter.draw(
                qpos[k],
                camera[k],
                boxes=boxes[: shown[k]],
                caption=caption,
                mocap=mocap[k] if len(mocap) else None,
            )
            pipe.write(picture.tobytes())
            pipe.flush()
    painter.close()


def main(args: list[str]) -> int:
    """Entry point of the child."""
    try:
        if args == ["--probe"]:
            _probe()
        else:
            _work(Path(args[0]), int(args[1]), int(args[2]))
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
