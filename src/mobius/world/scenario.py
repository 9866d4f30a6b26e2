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
from dataclasses import dataclass, field, replace
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
LEAST = 0.02
"""Edges and height of an obstacle are at least this [m]; physics knows no thinner boxes."""


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
    keeps_yaw: bool = False
    """Whether an obstacle that moves keeps the heading it has then; else ``area`` says it."""


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
    later: list[Event] = field(init=False)
    """Events whose time or place has not come yet, in the order of the file."""
    held: list[Event] = field(init=False, default_factory=list)
    """Events that are due but wait for room, or for one of the same obstacle that does; in the
    order in which they became due."""

    def __post_init__(self) -> None:
        self.here = {o.name: o.area for o in self.scenario.obstacles}
        self.later = list(self.scenario.events)

    @property
    def pending(self) -> list[Event]:
        """Events that have not come yet."""
        return [*self.held, *self.later]

    @property
    def comes_by_itself(self) -> bool:
        """Whether something is to come though the robot stays where it is."""
        return any(event.t is not None for event in self.later)

    @property
    def areas(self) -> tuple[Rectangle, ...]:
        """Of the obstacles that stand somewhere."""
        return tuple(a for a in self.here.values() if a is not None)

    def due(self, t: float, xy_M: ArrayLike, grid: GridMap, *, room: float = 0.0) -> list[Event]:
        """Events that come now, taken off what is pending; obstacles are moved.

        A place that was reached once stays reached. An obstacle that would come to stand within
        ``room`` of the robot waits until the robot has left, and what happens to it afterwards
        waits, too. What is returned says where the obstacle is now.

        Args:
            t: Time of the run [s].
            xy_M: (2,) trunk [m].
            grid: Its cells say what was reached.
            room: [m].
        """
        at = tuple(grid.cell_of(xy_M))
        ripe = [
            event
            for event in self.later
            if (event.t is not None and t >= event.t)
            or (event.reach is not None and tuple(grid.cell_of(event.reach)) == at)
        ]
        self.later = [event for event in self.later if event not in ripe]
        ripe.sort(key=lambda event: t if event.t is None else event.t)
        due, self.held = [*self.held, *ripe], []
        now, waiting = list[Event](), set[str]()
        for event in due:
            event = self._as_it_stands(event)
            lacks = event.area is not None and bool(event.area.contains(xy_M, grown=room))
            if lacks or event.obstacle in waiting:
                waiting.add(event.obstacle)
                self.held.append(event)
                continue
            self.here[event.obstacle] = event.area
            now.append(event)
        return now

    def _as_it_stands(self, event: Event) -> Event:
        """The event, with the heading that the obstacle has now where it keeps it."""
        before = self.here[event.obstacle]
        if not event.keeps_yaw or event.area is None or before is None:
            return event
        return replace(event, area=replace(event.area, yaw=before.yaw))


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
    for obstacle in obstacles.values():
        _check_order(obstacle, [e for e in events if e.obstacle == obstacle.name])
    return Scenario(tuple(obstacles.values()), tuple(events))


def check_scenario(scenario: Scenario, raster: OccupancyMap, path: str | Path) -> None:
    """Raise :class:`MapError` where an obstacle stands, or is to come, off the map, or where
    an event waits for the robot to reach what it never can.
    """
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
    for event in scenario.events:
        if event.reach is None:
            continue
        pixel, (x, y) = raster.pixel_of(np.array(event.reach)), event.reach
        if not raster.holds(pixel) or raster.occupied[tuple(pixel)]:
            where = "lies in an obstacle" if raster.holds(pixel) else "lies off the map"
            raise MapError(
                f"{event.place}: 'reach' ({x:g}, {y:g}) m {where}, so the robot is never there;"
                " name a point on its way, metres in frame map"
            )


def _check_order(obstacle: Obstacle, events: list[Event]) -> None:
    """Refuse to add what stands there already, and to move or remove what is nowhere.

    Events that wait for a place may come in any order: then only what can never be is refused.
    """
    ordered = all(e.t is not None for e in events)
    if ordered:
        events = sorted(events, key=lambda e: e.t or 0.0)
    kinds = {e.what for e in events}
    stands = obstacle.area is not None
    for event in events:
        adds = event.what == "add"
        maybe = not ordered and bool(kinds & ({"remove"} if adds else {"add"}))
        if adds is stands and not maybe:
            raise MapError(
                f"{event.place}: '{obstacle.name}' stands there already; write 'move', or remove"
                " it first"
                if adds
                else f"{event.place}: '{obstacle.name}' stands nowhere then; add it first, or give"
                " the obstacle a 'center'"
            )
        if ordered:
            stands = event.what != "remove"


def _obstacle(item: Section) -> Obstacle:
    item.only(("name", "center", "size", "yaw", "height"))
    name = item.text("name", example="crate")
    if not name.replace("_", "").replace("-", "").isalnum():
        raise item.error("name", f"expected letters, digits, - and _, got '{name}'")
    size = _pair(item, "size", "[0.6, 0.4]")
    if min(size) < LEAST:
        raise item.error(
            "size", f"expected two lengths >= {LEAST:g} [m], got [{size[0]:g}, {size[1]:g}]"
        )
    height = item.number("height", example="0.5", low=LEAST) if "height" in item else HEIGHT
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
        keeps_yaw=what == "move" and "yaw" not in item,
    )


def _pair(item: Section, key: str, example: str) -> Point:
    x, y = item.numbers(key, 2, example=example)
    return x, y


def _area(item: Section, key: str, size: Point, yaw: float) -> Rectangle:
    if "yaw" in item:
        yaw = item.number("yaw", example="0.3")
    return Rectangle(_pair(item, key, "[3.0, 2.0]"), size, yaw)
