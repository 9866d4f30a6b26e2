"""From a map to a plan that the robot's bodies can carry out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.errors import InvalidInput, MapError
from mobius.mission.body import ROOM, fit_modes
from mobius.mission.footprint import NARROW, WIDE, Footprint
from mobius.mission.prices import NO_PRICES, Prices
from mobius.plan import NoPlan, build_problem, check, solve
from mobius.types import GridMap, Mode, Plan
from mobius.world import World, load_world
from mobius.world.clearance import Clearance
from mobius.world.load import blocked_pixels

Array = NDArray[np.float64]

CLEARANCE_WANTED = 0.6
"""Cells closer than this to an obstacle [m] are dearer."""
SLACK = 12
"""Steps that a plan may have on top of the fewest."""
STATES = 150_000
"""States that the search for a plan may go through; no clock, so that the same seed gives the
same run however busy the machine is."""


def open_world(
    source: str | Path,
    *,
    start: Sequence[float] | None = None,
    goal: Sequence[float] | None = None,
    regions: str | Path | None = None,
    need: Sequence[str] = ("start", "goal"),
    footprint: Footprint = WIDE,
) -> World:
    """Load a map for the crawling robot; start and goal must be known and reachable.

    Args:
        source: Map file, or the name of a shipped map.
        start: (2,) [m]; the map's own if not given.
        goal: (2,) [m]; the map's own if not given.
        regions: A file of more regions (:mod:`mobius.world.regions`).
        need: Which of start and goal must be known.
        footprint: What stays clear of obstacles.

    Raises:
        MapError: The map cannot be read, or its start or goal cannot be reached; says so where
            a policy that stands narrower would fit.
        InvalidInput: A place that ``need`` names is not known.
    """

    def load(room: Footprint) -> World:
        return load_world(source, start=start, goal=goal, regions=regions, **asdict(room))

    try:
        world = load(footprint)
    except MapError as error:
        if footprint == NARROW or not _opens(lambda: load(NARROW)):
            raise
        raise MapError(
            f"{error}; the policy for rough ground stands narrower and fits: add --policy rough"
        ) from None
    for what in need:
        if getattr(world.grid, what) is None:
            raise InvalidInput(f"{source}: the map names no {what}; type --{what} X Y (metres)")
    return world


def _opens(load: Callable[[], World]) -> bool:
    try:
        load()
    except MapError:
        return False
    return True


def clearance_cost(world: World) -> Array:
    """(nx, ny) points: 1 a cell, more where an obstacle is near."""
    lack = np.clip(CLEARANCE_WANTED - world.clearance, 0.0, None) / CLEARANCE_WANTED
    return 1.0 + 2.0 * lack


def plan_mission(
    world: World,
    modes: Sequence[Mode],
    *,
    start: ArrayLike | None = None,
    last_mode: Mode | None = None,
    max_states: int = STATES,
    prices: Prices = NO_PRICES,
) -> Plan:
    """The cheapest way of at most 12 steps more than the shortest; checked before it is driven.

    Proven where the plan's status is ``optimal``; else its gap says what is open. Cells admit
    only modes that they have room for (:func:`mobius.mission.body.fit_modes`). The same
    arguments give the same plan.

    Args:
        world: Where.
        modes: Of the plan.
        start: (2,) [m]; the map's own if not given.
        last_mode: The body the robot is in; it matters where changes cost.
        max_states: Budget of the search.
        prices: Of seconds, joules and changes of body, beside those of steps.

    Raises:
        NoPlan: There is no way; says so where lack of room for a forced mode is why.
        MapError: Start or goal is on ground that none of the modes may use.
    """
    grid = replace(world.grid, allowed=fit_modes(world.grid, world.clearance))
    try:
        problem = build_problem(
            grid,
            start=start,
            modes=modes,
            weights=prices.weights(),
            switch_cost=prices.switch_cost(),
            must_reach=True,
            early_stop=True,
            slack=SLACK,
            cell_cost=clearance_cost(world),
            last_mode=last_mode,
        )
        plan = solve(problem, deadline_s=None, max_states=max_states)
    except (NoPlan, MapError) as error:
        cramped = _cramped(world, grid, modes)
        if cramped is None:
            raise
        raise type(error)(f"{error}; {cramped}") from None
    check(problem, plan)
    return plan


def _cramped(world: World, fitted: GridMap, modes: Sequence[Mode]) -> str | None:
    """What a forced mode that lacks room has to do with there being no way."""
    bits = sum(m.bit for m in modes)
    lost = ~world.grid.blocked & (world.grid.allowed & bits > 0) & (fitted.allowed & bits == 0)
    if not lost.any():
        return None
    cell = np.argwhere(lost)[0]
    x, y = world.grid.center_of(cell)
    wants = [m for m in ROOM if world.grid.allowed[tuple(cell)] & m.bit]
    room = " and ".join(f"{m} needs {ROOM[m]:g} m" for m in wants)
    return (
        f"at ({x:.2f}, {y:.2f}) m a region forces a mode that has no room there: {room} to"
        f" obstacles, there are {world.clearance[tuple(cell)]:.2f} m; let the region admit crawl"
        " too, or move it"
    )


def path_heading(plan: Plan) -> float:
    """Heading [rad] in which a plan begins: that of its first move, the reverse for a roll,
    which goes tail first; 0 for a plan that stays.
    """
    for a, b, mode in zip(plan.xy_M[:-1], plan.xy_M[1:], plan.modes, strict=True):
        if np.linalg.norm(b - a) > 1e-9:
            way = a - b if mode is Mode.ROLL else b - a
            return float(np.arctan2(way[1], way[0]))
    return 0.0


def with_ends(
    plan: Plan, grid: GridMap, *, start: ArrayLike | None = None, body: Mode = Mode.CRAWL
) -> Plan:
    """The plan from the exact start over the cells' centres to the exact goal [m].

    Args:
        plan: Over the grid's cells.
        grid: With a goal.
        start: (2,) [m]; the grid's own if not given.
        body: The mode of the robot where the plan has no step.
    """
    begin = grid.start if start is None else np.asarray(start, dtype=float)
    if begin is None or grid.goal is None:
        return plan
    modes = plan.modes or (body,)
    first, last = _walking(modes[0]), _walking(modes[-1])
    return Plan(
        cells=np.concatenate([plan.cells[:1], plan.cells, plan.cells[-1:]]),
        modes=(first, *plan.modes, last),
        xy_M=np.concatenate([begin[None], plan.xy_M, grid.goal[None]]),
        status=plan.status,
        objective=plan.objective,
        bound=plan.bound,
        solve_s=plan.solve_s,
    )


def _walking(mode: Mode) -> Mode:
    """The body for a few centimetres before or after a step."""
    return Mode.BIPED if mode is Mode.BIPED else Mode.CRAWL


def room_of(world: World) -> Callable[[Array], float]:
    """Distance [m] from a point (2,) of M to obstacles, never too large; 0 off the map."""
    raster = world.occupancy
    clearance = Clearance(blocked_pixels(raster, world.raised), raster.resolution)

    def room(p: Array) -> float:
        return float(clearance.at(raster.to_local(p)))

    return room
