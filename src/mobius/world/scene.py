"""World -> MuJoCo: floor, walls, rough patches and shelves around a robot."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from mobius.errors import InvalidInput
from mobius.world.load import World
from mobius.world.scenario import Obstacle
from mobius.world.shapes import RaisedObject, Rectangle, RoughPatch
from mobius.world.terrain import bumps
from mobius.world.walls import SceneOptions as SceneOptions
from mobius.world.walls import wall_boxes as wall_boxes

Array = NDArray[np.float64]

_PLANE, _BOX, _HFIELD = (
    mujoco.mjtGeom.mjGEOM_PLANE,
    mujoco.mjtGeom.mjGEOM_BOX,
    mujoco.mjtGeom.mjGEOM_HFIELD,
)
_HFIELD_BASE = 0.05
"""How far a height field reaches below the floor [m]."""
_NOWHERE = 20.0
"""How deep below the floor an obstacle waits that stands nowhere [m]."""


def build_scene(
    world: World,
    robot: mujoco.MjSpec,
    *,
    options: SceneOptions | None = None,
    obstacles: Sequence[Obstacle] = (),
) -> mujoco.MjSpec:
    """A robot's spec with the world around it.

    The robot's own options (time step, ``jacobian="dense"``, solver) stay as they are, and
    no degree of freedom is added, so its keyframes still fit. New geoms, all on the world
    body and in group 0: ``floor``, ``wall_<k>``, ``rough_<k>``, ``shelf_<k>_board``,
    ``shelf_<k>_leg_<i>``. Obstacles of a scenario are mocap bodies ``moving_<name>`` with a
    geom ``wall_moving_<name>``; one that stands nowhere waits deep below the floor.

    Args:
        world: What to build.
        robot: The robot alone; it is copied, not changed.
        options: Wall height, precision, collision masks.
        obstacles: Boxes that may move during the run.

    Raises:
        InvalidInput: The robot's spec already holds a geom named ``floor``.
    """
    options = options or SceneOptions()
    spec = robot.copy()
    if spec.geom("floor") is not None:
        raise InvalidInput(
            "build_scene: expected the robot alone, got a spec that already has a 'floor';"
            " pass mobius.model.load_spec(), not a scene"
        )
    mask = {"contype": options.contype, "conaffinity": options.conaffinity, "group": 0}
    _add_looks(spec)
    _light(spec, world)
    body = spec.worldbody
    body.add_geom(name="floor", type=_PLANE, size=[0, 0, 0.05], material="world_floor", **mask)
    for k, (box, material) in enumerate(wall_boxes(world, options=options)):
        _add_box(body, f"wall_{k}", box, (0.0, options.wall_height), material=material, **mask)
    for k, patch in enumerate(world.rough):
        _add_rough(spec, f"rough_{k}", patch, **mask)
    for k, thing in enumerate(world.raised):
        _add_shelf(body, f"shelf_{k}", thing, **mask)
    for obstacle in obstacles:
        _add_movable(body, obstacle, **mask)
    return spec


def movable_pose(obstacle: Obstacle, area: Rectangle | None) -> tuple[Array, Array]:
    """Position (3,) [m] and quaternion (4,) of the mocap body of an obstacle that stands on an
    area, or nowhere.
    """
    if area is None:
        return np.array([0.0, 0.0, -_NOWHERE]), np.array([1.0, 0.0, 0.0, 0.0])
    return np.array([*area.center, obstacle.height / 2]), np.array(_quat(area.yaw))


def _add_box(
    body: mujoco.MjsBody, name: str, area: Rectangle, span: tuple[float, float], **geom: Any
) -> None:
    """A box over an area from height span[0] to span[1] [m]."""
    low, high = span
    body.add_geom(
        name=name,
        type=_BOX,
        pos=[*area.center, (low + high) / 2],
        size=[area.size[0] / 2, area.size[1] / 2, (high - low) / 2],
        quat=_quat(area.yaw),
        **geom,
    )


def _add_movable(body: mujoco.MjsBody, obstacle: Obstacle, **geom: Any) -> None:
    pos, quat = movable_pose(obstacle, obstacle.area)
    box = body.add_body(name=f"moving_{obstacle.name}", mocap=True, pos=pos, quat=quat)
    size = [obstacle.size[0] / 2, obstacle.size[1] / 2, obstacle.height / 2]
    name = f"wall_moving_{obstacle.name}"
    box.add_geom(name=name, type=_BOX, size=size, material="world_wood", **geom)


def _add_rough(spec: mujoco.MjSpec, name: str, patch: RoughPatch, **geom: Any) -> None:
    height = bumps(patch)
    spec.add_hfield(
        name=name,
        nrow=height.shape[0],
        ncol=height.shape[1],
        size=[patch.area.size[0] / 2, patch.area.size[1] / 2, patch.amplitude, _HFIELD_BASE],
        userdata=(height / patch.amplitude).ravel(),
    )
    spec.worldbody.add_geom(
        name=name,
        type=_HFIELD,
        hfieldname=name,
        pos=[*patch.area.center, 0.0],
        quat=_quat(patch.area.yaw),
        material="world_rough",
        **geom,
    )


def _add_shelf(body: mujoco.MjsBody, name: str, thing: RaisedObject, **geom: Any) -> None:
    _add_box(
        body, f"{name}_board", thing.area, (thing.bottom, thing.top), material="world_wood", **geom
    )
    for i, leg in enumerate(thing.legs):
        _add_box(body, f"{name}_leg_{i}", leg, (0.0, thing.bottom), material="world_metal", **geom)


def _quat(yaw: float) -> list[float]:
    return [float(np.cos(yaw / 2)), 0.0, 0.0, float(np.sin(yaw / 2))]


def _add_looks(spec: mujoco.MjSpec) -> None:
    """Sky, floor tiles and the materials of everything built here."""
    spec.add_texture(
        name="world_sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=[0.80, 0.87, 0.95],
        rgb2=[0.35, 0.45, 0.58],
        width=256,
        height=1536,
    )
    spec.add_texture(
        name="world_floor",
        type=mujoco.mjtTexture.mjTEXTURE_2D,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_CHECKER,
        rgb1=[0.66, 0.67, 0.68],
        rgb2=[0.61, 0.62, 0.63],
        mark=mujoco.mjtMark.mjMARK_EDGE,
        markrgb=[0.53, 0.54, 0.55],
        width=512,
        height=512,
    )
    spec.add_texture(
        name="world_gravel",
        type=mujoco.mjtTexture.mjTEXTURE_2D,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_FLAT,
        rgb1=[0.58, 0.49, 0.38],
        rgb2=[0.58, 0.49, 0.38],
        mark=mujoco.mjtMark.mjMARK_RANDOM,
        markrgb=[0.44, 0.37, 0.29],
        random=0.12,
        width=128,
        height=128,
    )
    floor = spec.add_material(name="world_floor", texuniform=True, texrepeat=[1, 1], specular=0.1)
    floor.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "world_floor"
    gravel = spec.add_material(name="world_rough", texuniform=True, texrepeat=[2, 2], specular=0.0)
    gravel.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "world_gravel"
    for name, rgba, shine in (
        ("world_wall", [0.90, 0.89, 0.86, 1], 0.1),
        ("world_block", [0.42, 0.53, 0.63, 1], 0.2),
        ("world_wood", [0.74, 0.57, 0.38, 1], 0.3),
        ("world_metal", [0.25, 0.26, 0.28, 1], 0.6),
    ):
        spec.add_material(name=name, rgba=rgba, specular=shine, shininess=shine)


def _light(spec: mujoco.MjSpec, world: World) -> None:
    """A sun with shadows, a weak fill from the other side, and sizes for the camera."""
    grid = world.grid
    corners = grid.center_of([(-0.5, -0.5), (grid.shape[0] - 0.5, grid.shape[1] - 0.5)])
    center = corners.mean(axis=0)
    extent = max(2.0, 0.6 * float(np.linalg.norm(corners[1] - corners[0])))
    spec.stat.center = [*center, 0.2]
    spec.stat.extent = extent
    visual = spec.visual
    visual.headlight.ambient = [0.32, 0.32, 0.34]
    visual.headlight.diffuse = [0.14, 0.14, 0.14]
    visual.headlight.specular = [0.0, 0.0, 0.0]
    visual.rgba.haze = [0.72, 0.78, 0.85, 1.0]
    visual.quality.shadowsize = 4096
    visual.quality.offsamples = 4
    visual.map.shadowclip = 2  # narrower, the sun's frustum ends in a visible moire
    visual.map.znear = 0.02 / extent
    visual.map.zfar = max(20.0, 60.0 / extent)
    visual.global_.offwidth = max(visual.global_.offwidth, 1920)
    visual.global_.offheight = max(visual.global_.offheight, 1080)
    directional = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
    sun = np.array([0.35, 0.5, -1.0])
    spec.worldbody.add_light(
        name="world_sun",
        type=directional,
        pos=[*(center - 0.5 * extent * sun[:2]), -0.5 * extent * sun[2]],
        dir=sun,
        diffuse=[0.48, 0.46, 0.43],
        specular=[0.2, 0.2, 0.2],
        castshadow=True,
    )
    spec.worldbody.add_light(
        name="world_fill",
        type=directional,
        pos=[center[0] + 2, center[1] + 3, 5],
        dir=[-0.5, -0.4, -0.8],
        diffuse=[0.20, 0.21, 0.24],
        specular=[0.0, 0.0, 0.0],
        castshadow=False,
    )
