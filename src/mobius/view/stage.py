"""A lit, tiled floor to be seen on: the robot's own model with looks, for drawing only."""

from __future__ import annotations

import mujoco
import numpy as np

from mobius.model import robot as model_robot

__all__ = ["TILE", "stage_model"]

TILE = 0.25
"""Edge of a floor tile [m]: a scale for who looks."""
_EXTENT = 4.0


def stage_model(floor_quat: tuple[float, float, float, float] | None = None) -> mujoco.MjModel:
    """The full robot on a tiled floor under a sun; its ``qpos`` is that of the bare robot.

    Args:
        floor_quat: Rotation wxyz of the floor about the origin; level if not given.
    """
    spec = model_robot.load_spec("full")
    spec.add_texture(
        name="stage_sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=[0.93, 0.95, 0.97],
        rgb2=[0.70, 0.77, 0.85],
        width=128,
        height=768,
    )
    spec.add_texture(
        name="stage_tiles",
        type=mujoco.mjtTexture.mjTEXTURE_2D,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_CHECKER,
        rgb1=[0.80, 0.81, 0.82],
        rgb2=[0.70, 0.71, 0.73],
        width=256,
        height=256,
    )
    tiles = spec.add_material(
        name="stage_tiles", texuniform=True, texrepeat=[0.5 / TILE] * 2, specular=0.0
    )
    tiles.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "stage_tiles"
    spec.worldbody.add_geom(
        name="floor",
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[0, 0, 0.05],
        quat=floor_quat or (1.0, 0.0, 0.0, 0.0),
        material="stage_tiles",
    )
    _light(spec)
    return spec.compile()


def _light(spec: mujoco.MjSpec) -> None:
    spec.stat.extent, spec.stat.center = _EXTENT, [0.0, 0.0, 0.2]
    visual = spec.visual
    visual.headlight.ambient = [0.36, 0.36, 0.37]
    visual.headlight.diffuse = [0.18, 0.18, 0.18]
    visual.headlight.specular = [0.0, 0.0, 0.0]
    visual.rgba.haze = [0.93, 0.95, 0.97, 1.0]
    visual.map.znear, visual.map.zfar = 0.02 / _EXTENT, 15.0
    down = np.array([0.3, 0.35, -1.0])
    spec.worldbody.add_light(
        name="stage_sun",
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        pos=-2.0 * down,
        dir=down,
        diffuse=[0.5, 0.49, 0.47],
        specular=[0.2, 0.2, 0.2],
        castshadow=True,
    )
