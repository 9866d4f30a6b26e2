"""A horizontal bar on two posts, to hang from."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, sin

import mujoco
import numpy as np

from mobius.errors import InvalidInput

_BOX = mujoco.mjtGeom.mjGEOM_BOX
_PLANE = mujoco.mjtGeom.mjGEOM_PLANE
_METAL, _DARK = [0.72, 0.74, 0.77, 1.0], [0.30, 0.31, 0.33, 1.0]


@dataclass(frozen=True)
class Bar:
    """An aluminium profile of square section with grooves along it, on two posts.

    The paper gives no size; the section is that of a common 30 mm profile with 8 mm grooves.
    """

    height: float = 0.90
    """Of the bar's middle above the floor [m]."""
    xy: tuple[float, float] = (0.0, 0.0)
    """Middle of the bar in frame M [m]."""
    yaw: float = 0.0
    """Turn about z [rad]; at 0 the bar runs along y, from the right hand to the left."""
    tilt: float = 0.0
    """Left end up [rad]."""
    length: float = 1.0
    """[m]."""
    width: float = 0.030
    """Edge of the square section [m]."""
    groove: float = 0.008
    """Width of the groove in each face [m]; only seen."""

    def __post_init__(self) -> None:
        sizes = (self.height, self.length, self.width)
        if not all(np.isfinite(v) and v > 0 for v in sizes) or self.groove >= self.width:
            raise InvalidInput(
                "Bar: expected positive height, length, width [m] and a groove narrower than the"
                f" width, got {self.height}, {self.length}, {self.width}, {self.groove}"
            )


def add_bar(spec: mujoco.MjSpec, bar: Bar | None = None, *, name: str = "bar") -> None:
    """Add a body ``name`` with the bar and its posts to a scene, in place.

    The bar's local x is its axis. Its geom ``name`` takes no friction: what a hand holds there
    is the grasp's business (:mod:`mobius.robot.grasp`), contact only keeps bodies apart.
    Posts are geoms ``name_post_0`` and ``name_post_1``.
    """
    bar = bar or Bar()
    half, w = bar.length / 2, bar.width / 2
    body = spec.worldbody.add_body(
        name=name, pos=[*bar.xy, bar.height], quat=_along(bar.yaw, bar.tilt)
    )
    smooth = {"condim": 1, "priority": 2, "group": 0}
    body.add_geom(name=name, type=_BOX, size=[half, w, w], rgba=_METAL, **smooth)
    seen = {"contype": 0, "conaffinity": 0, "group": 0, "rgba": _DARK}
    g = bar.groove / 2
    body.add_geom(name=f"{name}_groove_0", type=_BOX, size=[half, w + 2e-4, g], **seen)
    body.add_geom(name=f"{name}_groove_1", type=_BOX, size=[half, g, w + 2e-4], **seen)
    for i, side in enumerate((-1, 1)):
        along = np.array([-sin(bar.yaw), cos(bar.yaw)]) * (half + w) * side * cos(bar.tilt)
        top = bar.height + side * (half + w) * sin(bar.tilt) + w
        spec.worldbody.add_geom(
            name=f"{name}_post_{i}",
            type=_BOX,
            pos=[bar.xy[0] + along[0], bar.xy[1] + along[1], top / 2],
            quat=_along(bar.yaw, 0.0),
            size=[w, w, top / 2],
            rgba=_METAL,
            group=0,
        )


def build_bar_scene(robot: mujoco.MjSpec, bar: Bar | None = None) -> mujoco.MjSpec:
    """The robot's spec with floor, light and a bar around it; the robot is copied.

    Raises:
        InvalidInput: The robot's spec already holds a geom named ``floor``.
    """
    if robot.geom("floor") is not None:
        raise InvalidInput(
            "build_bar_scene: expected the robot alone, got a spec that already has a 'floor';"
            " pass mobius.model.load_spec(), or use add_bar on the scene"
        )
    spec = robot.copy()
    _light(spec)
    spec.worldbody.add_geom(
        name="floor", type=_PLANE, size=[0, 0, 0.05], rgba=[0.62, 0.63, 0.64, 1]
    )
    add_bar(spec, bar)
    return spec


def _along(yaw: float, tilt: float) -> list[float]:
    """Quaternion that lays local x along world y, then turns by tilt and yaw."""
    a = (yaw + np.pi / 2) / 2
    turn, lift = np.array([cos(a), 0, 0, sin(a)]), np.array([cos(tilt / 2), 0, -sin(tilt / 2), 0])
    quat = np.zeros(4)
    mujoco.mju_mulQuat(quat, turn, lift)
    return [float(v) for v in quat]


def _light(spec: mujoco.MjSpec) -> None:
    spec.add_texture(
        name="bar_sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=[0.80, 0.87, 0.95],
        rgb2=[0.35, 0.45, 0.58],
        width=256,
        height=1536,
    )
    spec.stat.center, spec.stat.extent = [0.0, 0.0, 0.6], 1.5
    spec.visual.quality.shadowsize = 4096
    spec.visual.quality.offsamples = 4
    spec.visual.map.znear = 0.01
    spec.visual.headlight.ambient = [0.32, 0.32, 0.34]
    spec.visual.headlight.diffuse = [0.20, 0.20, 0.20]
    spec.visual.global_.offwidth = max(spec.visual.global_.offwidth, 1920)
    spec.visual.global_.offheight = max(spec.visual.global_.offheight, 1080)
    spec.worldbody.add_light(
        name="bar_sun",
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        pos=[1.0, -1.5, 3.0],
        dir=[-0.35, 0.5, -1.0],
        diffuse=[0.55, 0.53, 0.50],
        specular=[0.2, 0.2, 0.2],
    )
