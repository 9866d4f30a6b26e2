"""What changes while the robot is on its way: ``mobius run --scenario FILE.yaml``.

obstacles:                # boxes on the floor; without `center` not there at first
  - {name: crate, center: [3.0, 2.0], size: [0.6, 0.4], yaw: 0.3, height: 0.5}
  - {name: pallet, size: [0.8, 0.8]}
events:                   # at a time of the run [s], or when the robot is in a cell
  - {t: 12.0, move: crate, to: [4.0, 2.0], yaw: 0.0}
  - {reach: [5.0, 3.0], add: pallet, to: [6.0, 3.0]}
  - {t: 40.0, remove: crate}
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from mobius.errors import MapError, did_you_mean
from mobius.types import GridMap
from mobius.world.keys import Section, read_yaml
from mobius.world.occupancy import OccupancyMap
from mobius.world.shapes import Point, Rectangle

What = Literal["move", "add", "remove"]
WHAT: tuple[What, ...] = ("move", "add", "remove")
HEIGHT = 0.5
"""Of an obstacle that names none [m]."""


@dataclass(frozen=True)
class Obstacle:
    """A box that may come, move and go."""

    name: str
    size: Point
    """Edges [m]."""
    height: float = HEIGHT
    """[m]."""
    area: Rectangle | None = None
    """Where it stands at first, frame M; None: nowhere."""


@dataclass(frozen=True)
class Event:
    """One change."""

    what: What
    obstacle: str
    area: Rectangle | None
    """Where the obstacle is from then on, frame M; None: nowhere."""
    t: float | None
    """Time of the run [s], or None."""
    reach: Point | None
    """The change comes when the robot's trunk is in the cell of this point [m], or None."""
    place: str
    """Where it was written, for messages."""


@dataclass(frozen=True)
class Scenario:
    """Obstacles beside those of the map, and what happens to them."""

    obstacles: tuple[Obstacle, ...] = ()
    events: tuple[Event, ...] = ()


@dataclass(eq=False)
class Scenery:
    """A scenario on its way: where every obstacle is now, and what is still to come."""

    scenario: Scenario
    here: dict[str, Rectangle | None] = field(init=False)
    """Where every obstacle stands; None: nowhere."""
    pending: list[Event] = field(init=False)
    """Events that have not come yet, in the order of the file."""

    def __post_init__(self) -> None:
        self.here = {o.name: o.area for o in self.scenario.obstacles}
        self.pending = list(self.scenario.events)

    @property
    def areas(self) -> tuple[Rectangle, ...]:
        """Of the obstacles that stand somewhere."""
        return tuple(a for a in self.here.values() if a is not None)

    def due(self, t: float, xy_M: ArrayLike, grid: GridMap, *, room: float = 0.0) -> list[Event]:
        """Events that come now, taken off what is pending; obstacles are moved.

        An obstacle that would come to stand within ``room`` of the robot waits until the robot
        has left.

        Args:
            t: Time of the run [s].
            xy_M: (2,) trunk [m].
            grid: Its cells say what was reached.
            room: [m].
        """
        at, now = tuple(grid.cell_of(xy_M)), []
        for event in list(self.pending):
            timely = event.t is not None and t >= event.t
            there = event.reach is not None and tuple(grid.cell_of(event.reach)) == at
            if not (timely or there):
                continue
            if event.area is not None and event.area.contains(xy_M, grown=room):
                continue
            self.here[event.obstacle] = event.area
            self.pending.remove(event)
            now.append(event)
        return now


def read_scenario(path: str | Path) -> Scenario:
    """Read a scenario.

    Raises:
        MapError: A mistake in the file: names file, line, key and fix.
    """
    section = read_yaml(Path(path), what="a scenario", first="obstacles:")
    section.only(("obstacles", "events"))
    obstacles: dict[str, Obstacle] = {}
    for item in section.sections("obstacles"):
        obstacle = _obstacle(item)
        if obstacle.name in obstacles:
            raise item.error("name", f"'{obstacle.name}' is there twice; give each its own name")
        obstacles[obstacle.name] = obstacle
    if not obstacles:
        raise MapError(
            f"{path}: names no obstacle; add e.g."
            " 'obstacles: [{name: crate, center: [3, 2], size: [0.5, 0.5]}]'"
        )
    events = [_event(item, obstacles) for item in section.sections("events")]
    return Scenario(tuple(obstacles.values()), tuple(events))


def check_scenario(scenario: Scenario, raster: OccupancyMap, path: str | Path) -> None:
    """Raise :class:`MapError` where an obstacle stands, or is to come, off the map."""
    places = [(f"{path}: obstacle '{o.name}'", o.area) for o in scenario.obstacles]
    places += [(e.place, e.area) for e in scenario.events]
    for name, area in places:
        if area is not None and not raster.holds(raster.pixel_of(np.array(area.center))):
            x, y = area.center
            w, h = raster.size
            raise MapError(
                f"{name}: ({x:g}, {y:g}) m lies off the map of {w:.2f} x {h:.2f} m; give metres"
                " in frame map"
            )


def _obstacle(item: Section) -> Obstacle:
    item.only(("name", "center", "size", "yaw", "height"))
    name = item.text("name", example="crate")
    if not name.replace("_", "").replace("-", "").isalnum():
        raise item.error("name", f"expected letters, digits, - and _, got '{name}'")
    size = _pair(item, "size", "[0.6, 0.4]")
    if min(size) <= 0:
        raise item.error("size", f"expected two lengths > 0 [m], got [{size[0]:g}, {size[1]:g}]")
    height = item.number("height", example="0.5", above=0.0) if "height" in item else HEIGHT
    if "center" not in item:
        if "yaw" in item:
            raise item.error("yaw", "has no 'center'; add it, or give 'yaw' where it is added")
        return Obstacle(name, size, height)
    return Obstacle(name, size, height, _area(item, "center", size, 0.0))


def _event(item: Section, obstacles: Mapping[str, Obstacle]) -> Event:
    item.only(("t", "reach", *WHAT, "to", "yaw"))
    kinds = [w for w in WHAT if w in item]
    if len(kinds) != 1:
        raise item.error(
            kinds[1] if kinds else "t", "expected one of 'move: NAME', 'add: NAME', 'remove: NAME'"
        )
    if ("t" in item) == ("reach" in item):
        raise item.error(
            kinds[0], "expected either 't: 12.0' (seconds) or 'reach: [5, 3]' (metres)"
        )
    what = kinds[0]
    name = item.text(what, example=next(iter(obstacles)))
    if name not in obstacles:
        raise item.error(
            what,
            f"no obstacle '{name}'.{did_you_mean(name, obstacles)} Known: {', '.join(obstacles)}",
        )
    area = None
    if what == "remove":
        for key in ("to", "yaw"):
            if key in item:
                raise item.error(key, "goes with 'move' or 'add', not with 'remove'")
    else:
        before = obstacles[name].area
        area = _area(item, "to", obstacles[name].size, 0.0 if before is None else before.yaw)
    return Event(
        what=what,
        obstacle=name,
        area=area,
        t=item.number("t", example="12.0", low=0.0) if "t" in item else None,
        reach=_pair(item, "reach", "[5.0, 3.0]") if "reach" in item else None,
        place=f"{item.file}, line {item.line}, key '{item.path.rstrip('.')}'",
    )


def _pair(item: Section, key: str, example: str) -> Point:
    x, y = item.numbers(key, 2, example=example)
    return x, y


def _area(item: Section, key: str, size: Point, yaw: float) -> Rectangle:
    if "yaw" in item:
        yaw = item.number("yaw", example="0.3")
    return Rectangle(_pair(item, key, "[3.0, 2.0]"), size, yaw)
