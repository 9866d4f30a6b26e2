"""A map as a scene in physics, and the robot put on it, as often as wanted."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mobius.assemble import Start, build_sim_stack
from mobius.errors import MapError
from mobius.mission.floor import floor_of
from mobius.mission.footprint import WIDE
from mobius.mission.prepare import room_of
from mobius.model.robot import load_spec
from mobius.robot import TICK
from mobius.robot.sim import SimRobot
from mobius.stack import Stack
from mobius.view.live.nouns import Scene
from mobius.world import World, load_world, map_names
from mobius.world.scene import build_scene

MODES = ("crawl", "biped", "roll", "push_ups")
"""What can be asked for."""
_WALL, _UNKNOWN, _FLOOR = (74, 79, 87), (176, 180, 186), (246, 247, 248)


@dataclass(frozen=True, eq=False)
class Stage:
    """One map, compiled once."""

    world: World
    model: Any
    """Pristine; every robot gets a copy, which its variation changes."""
    xml: str
    """The scene as MJCF, for logs."""
    start: tuple[float, float]
    yaw: float
    """Heading in which the robot starts [rad]."""
    room: Callable[[NDArray[np.float64]], float]
    """Distance [m] of a point (2,) [m], frame M, to obstacles."""


def build_stage(source: str) -> Stage:
    """Load a map and compile its scene.

    Raises:
        MobiusError: There is no such map, or physics cannot build it.
    """
    world = load_world(source, **asdict(WIDE))
    try:
        spec = build_scene(world, load_spec("full"))
        model = spec.compile()
    except ValueError as error:
        raise MapError(
            f"map '{world.name}': physics cannot build it ({' '.join(str(error).split())})"
        ) from None
    model.opt.timestep = TICK
    return Stage(world, model, spec.to_xml(), *_where(world), room_of(world))


def _where(world: World) -> tuple[tuple[float, float], float]:
    """Start and heading: the map's, towards its goal; else the free cell with most room."""
    grid = world.grid
    if grid.start is not None:
        xy = np.array(grid.start)
    else:
        room = np.where(grid.blocked, -1.0, world.clearance)
        cell = np.unravel_index(int(room.argmax()), room.shape)
        if grid.blocked[cell]:
            raise MapError(f"map '{world.name}': no cell of it has room for the robot")
        xy = grid.center_of(np.array(cell))
    yaw = float(grid.origin_M[2])
    if grid.goal is not None:
        way = np.array(grid.goal) - xy
        quarter = np.round((np.arctan2(way[1], way[0]) - yaw) / (np.pi / 2)) * np.pi / 2
        yaw += float(quarter)
    return (float(xy[0]), float(xy[1])), yaw


def put_at(stage: Stage, xy: tuple[float, float]) -> Stage:
    """The stage with another start.

    Raises:
        MapError: The robot does not fit there; names the nearest place where it does.
    """
    check_place(stage.world, xy, "start")
    return replace(stage, start=(float(xy[0]), float(xy[1])))


def check_place(world: World, xy: tuple[float, float], what: str) -> None:
    """Refuse a point off the map or where the robot does not fit.

    Raises:
        MapError: With the nearest place that is fine.
    """
    grid = world.grid
    cell = grid.cell_of(np.array(xy, dtype=float))
    if grid.holds(cell) and not grid.blocked[tuple(cell)]:
        return
    free = grid.center_of(np.argwhere(~grid.blocked))
    near = free[np.linalg.norm(free - np.array(xy), axis=1).argmin()]
    where = "lies in or too near an obstacle" if grid.holds(cell) else "is off the map"
    raise MapError(
        f"{what} ({xy[0]:.2f}, {xy[1]:.2f}) m {where}; nearest free cell"
        f" ({near[0]:.2f}, {near[1]:.2f})"
    )


def robot_on(
    stage: Stage, *, seed: int, randomised: bool, policies: dict[str, str]
) -> tuple[Stack, SimRobot]:
    """A fresh robot at the stage's start, with all its modes."""
    start = Start(xy=stage.start, yaw=stage.yaw, seed=seed, randomised=randomised)
    return build_sim_stack(
        copy.deepcopy(stage.model),
        start,
        policy=policies_on(stage, policies),
        ground=floor_of(stage.world),
        modes=MODES,
    )


def policies_on(stage: Stage, chosen: Mapping[str, str]) -> dict[str, str]:
    """What drives each body: what was chosen, else what fits the ground."""
    crawl = "rough" if stage.world.rough else "flat"
    return {"crawl": crawl, "biped": "flat", **chosen}


def picture_of(world: World) -> NDArray[np.uint8]:
    """(h, w, 3) the map from above, row 0 at the top."""
    raster = world.occupancy
    picture = np.empty((*raster.shape, 3), dtype=np.uint8)
    picture[:] = _FLOOR
    picture[raster.unknown] = _UNKNOWN
    picture[raster.occupied] = _WALL
    return np.ascontiguousarray(picture[::-1])


def scene_of(stage: Stage, model: Any, number: int, *, policies: Mapping[str, str]) -> Scene:
    """What a viewer has to know of the stage.

    Args:
        stage: Which.
        model: As the robot on it varied it.
        number: Of the scene.
        policies: That were chosen, by body.
    """
    world, goal = stage.world, stage.world.grid.goal
    return Scene(
        number=number,
        model=model,
        map=world.name,
        maps=tuple(map_names()),
        picture=picture_of(world),
        origin_M=np.array(world.occupancy.origin_M),
        resolution=world.occupancy.resolution,
        start=stage.start,
        goal=None if goal is None else (float(goal[0]), float(goal[1])),
        modes=MODES,
        policies=policies_on(stage, policies),
    )
