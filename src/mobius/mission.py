"""One run over a map: load, plan, drive, judge, and leave files to look at."""

from __future__ import annotations

import platform
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mobius.errors import InvalidInput
from mobius.modes import FollowerConfig, PathFollower
from mobius.plan import Weights, build_problem, check, solve
from mobius.results import Progress, staged, write_results
from mobius.robot import TICK
from mobius.stack import ACT_EVERY, Judge, RunRecord
from mobius.types import GridMap, Mode, ModeCommand, Plan, StateEstimate
from mobius.world import World, load_world

Array = NDArray[np.float64]

FOOTPRINT_RADIUS = 0.41
"""Disc around the trunk that holds the crawling stance in every heading [m]; a test holds the
boxes around its collision geometry to it."""
FOOTPRINT_MARGIN = 0.04
"""How far the robot's centre may stray from its planned line [m]."""
LANE = 0.34
"""Least distance to obstacles where it only goes straight [m]: half the stance's width of
0.62 m and 3 cm."""
CLEARANCE_WANTED = 0.6
"""Cells closer than this to an obstacle [m] are dearer."""
ARRIVE_WITHIN = 0.35
"""A run counts as arrived when the true trunk ends this close to the goal [m]."""
SETTLE_S = 1.5
"""The robot stands this long before it sets out [s]: at rest the estimator finds the gyro's
bias."""
MODES_SO_FAR = (Mode.CRAWL,)
"""Modes the robot can carry out."""


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a run leaves."""

    record: RunRecord
    summary: dict[str, Any]
    files: dict[str, Path]
    notes: tuple[str, ...]
    """Things that went otherwise than asked, a line each."""


def check_modes(modes: Iterable[str]) -> tuple[Mode, ...]:
    """Names to modes. Raises :class:`InvalidInput` for one that cannot be carried out yet."""
    from mobius.errors import UnknownName

    chosen = []
    for name in modes:
        if name not in {m.value for m in Mode}:
            raise UnknownName("mode", name, [m.value for m in MODES_SO_FAR])
        mode = Mode(name)
        if mode not in MODES_SO_FAR:
            able = ", ".join(m.value for m in MODES_SO_FAR)
            raise InvalidInput(f"mode '{name}' cannot be driven yet; type --modes {able}")
        chosen.append(mode)
    if not chosen:
        raise InvalidInput("expected at least one mode, e.g. --modes crawl")
    return tuple(chosen)


def open_world(
    source: str | Path, *, start: Sequence[float] | None = None, goal: Sequence[float] | None = None
) -> World:
    """Load a map for the crawling robot; start and goal must be known and reachable."""
    world = load_world(
        source,
        radius=FOOTPRINT_RADIUS,
        margin=FOOTPRINT_MARGIN,
        lane=LANE,
        start=start,
        goal=goal,
    )
    for what in ("start", "goal"):
        if getattr(world.grid, what) is None:
            raise InvalidInput(f"{source}: the map names no {what}; type --{what} X Y (metres)")
    return world


def clearance_cost(world: World) -> Array:
    """(nx, ny) points: 1 a cell, more where an obstacle is near."""
    lack = np.clip(CLEARANCE_WANTED - world.clearance, 0.0, None) / CLEARANCE_WANTED
    return 1.0 + 2.0 * lack


def plan_mission(world: World, modes: Sequence[Mode], *, deadline_s: float = 2.0) -> Plan:
    """The cheapest way of at most 12 steps more than the shortest; checked before it is driven.

    Proven where the plan's status is ``optimal``; else its gap says what is open.
    """
    problem = build_problem(
        world.grid,
        modes=modes,
        weights=Weights(W_exp=0.0),
        must_reach=True,
        early_stop=True,
        slack=12,
        cell_cost=clearance_cost(world),
    )
    plan = solve(problem, deadline_s=deadline_s)
    check(problem, plan)
    return plan


def path_heading(plan: Plan) -> float:
    """Heading [rad] of the plan's first move; 0 for a plan that stays."""
    for a, b in zip(plan.xy_M[:-1], plan.xy_M[1:], strict=True):
        if np.linalg.norm(b - a) > 1e-9:
            return float(np.arctan2(b[1] - a[1], b[0] - a[0]))
    return 0.0


def with_ends(plan: Plan, grid: GridMap) -> Plan:
    """The plan from the exact start over the cells' centres to the exact goal [m]."""
    if grid.start is None or grid.goal is None:
        return plan
    last = plan.modes[-1] if plan.modes else MODES_SO_FAR[0]
    first = plan.modes[0] if plan.modes else MODES_SO_FAR[0]
    return Plan(
        cells=np.concatenate([plan.cells[:1], plan.cells, plan.cells[-1:]]),
        modes=(first, *plan.modes, last),
        xy_M=np.concatenate([grid.start[None], plan.xy_M, grid.goal[None]]),
        status=plan.status,
        objective=plan.objective,
        bound=plan.bound,
        solve_s=plan.solve_s,
    )


def room_of(world: World) -> Callable[[Array], float]:
    """Distance [m] from a point (2,) of M to obstacles, that of its cell's centre."""

    def room(p: Array) -> float:
        i, j = world.grid.cell_of(p)
        return float(world.clearance[i, j]) if world.grid.holds((i, j)) else 0.0

    return room


def drive(
    world: World,
    plan: Plan,
    *,
    seed: int = 0,
    randomised: bool = True,
    policy: Path | str | None = None,
    config: FollowerConfig | None = None,
    progress: Progress | None = None,
) -> tuple[RunRecord, Judge, Any]:
    """Carry a plan out in physics; returns the record, the judge and the compiled scene.

    Ends one second after the follower says it arrived, at a fall, or at the time limit
    (four times what the path takes at cruising speed, plus 20 s). If no policy is named, the
    shipped one for rough ground is used where the map has some.
    """
    from mobius.assemble import Start, build_sim_stack
    from mobius.model.robot import load_spec
    from mobius.world.scene import build_scene

    path = with_ends(plan, world.grid)
    model = build_scene(world, load_spec("full")).compile()
    model.opt.timestep = TICK
    x, y = (float(v) for v in path.xy_M[0])
    start = Start(xy=(x, y), yaw=path_heading(plan), seed=seed, randomised=randomised)
    policy = policy or ("rough" if world.rough else "flat")
    stack, robot = build_sim_stack(model, start, policy=policy)
    judge = Judge(robot)
    follower = PathFollower(
        path, config, room=room_of(world), grid_yaw=float(world.grid.origin_M[2])
    )
    limit = 20.0 + 4.0 * follower.length / follower.config.speed
    stop_at = np.inf

    def source(belief: StateEstimate) -> ModeCommand:
        if belief.stamp < SETTLE_S:
            return ModeCommand(mode=follower.mode(), twist_H=np.zeros(3), stamp=belief.stamp)
        return follower.command(belief, ACT_EVERY * TICK)

    began = time.perf_counter()
    while not judge.fallen and stack.tick * TICK < min(limit, stop_at):
        sample = stack.turn(source)
        if sample is None:
            continue
        judge.see(sample)
        if follower.arrived and stop_at == np.inf:
            stop_at = stack.tick * TICK + 1.0
        if progress is not None and sample.tick % 60 == 0:
            progress("driving", min(follower.progress / max(follower.length, 1e-9), 1.0))
    loop_s = time.perf_counter() - began
    record = judge.record(world.grid, plan)
    ended = "fallen" if judge.fallen else "arrived" if follower.arrived else "time_limit"
    record.summary.update(energy_J=stack.energy, loop_s=loop_s, ended=ended)
    return record, judge, model


def summarise(record: RunRecord, judge: Judge, *, seed: int, wall_s: float) -> dict[str, Any]:
    """What ``summary.json`` holds; the real-time factor is that of the loop without files."""
    plan = record.plan
    goal = plan.xy_M[-1] if record.grid.goal is None else record.grid.goal
    distance = float(np.linalg.norm(record.true_p[-1, :2] - goal))
    sim_s = float(record.t[-1]) + ACT_EVERY * TICK
    cells = {tuple(c) for c in record.grid.cell_of(record.true_p[:, :2])}
    steps = np.linalg.norm(np.diff(record.true_p[:, :2], axis=0), axis=1)
    yaw = record.belief_rpy[:, 2] - record.true_rpy[:, 2]
    yaw = (yaw + np.pi) % (2 * np.pi) - np.pi
    velocity = record.belief_twist_H[:, :2] - record.true_twist_H[:, :2]
    energy = float(record.summary["energy_J"])
    position = record.belief_p[:, :2] - record.true_p[:, :2]
    return {
        "goal_reached": bool(distance <= ARRIVE_WITHIN and not judge.fallen),
        "final_distance_m": distance,
        "ended": record.summary["ended"],
        "falls": int(judge.fallen),
        "collisions": judge.collisions,
        "sim_time_s": sim_s,
        "wall_time_s": wall_s,
        "real_time_factor": sim_s / float(record.summary["loop_s"]),
        "path_length_m": float(steps.sum()),
        "energy_J": energy,
        "energy_per_cell_J": energy / max(len(cells), 1),
        "cells_visited": len(cells),
        "mean_power_W": energy / sim_s,
        "loop_residual_mm": 1e3 * judge.loop_residual,
        "plan": {
            "objective": plan.objective,
            "bound": plan.bound,
            "status": plan.status,
            "solve_ms": 1e3 * plan.solve_s,
            "modes": sorted({m.value for m in plan.modes}),
        },
        "estimator": {
            "position_rmse_m": float(np.sqrt(np.mean(np.sum(position**2, axis=1)))),
            "yaw_rmse_rad": float(np.sqrt(np.mean(yaw**2))),
            "velocity_rmse_mps": float(np.sqrt(np.mean(np.sum(velocity**2, axis=1)))),
        },
        "seed": seed,
        "versions": versions(),
    }


def versions() -> dict[str, str]:
    """Of what a result depends on."""
    names = ("mobius", "mujoco", "numpy", "onnxruntime")
    return {"python": platform.python_version(), **{n: version(n) for n in names}}


def run(
    source: str | Path,
    out: Path,
    *,
    start: Sequence[float] | None = None,
    goal: Sequence[float] | None = None,
    modes: Iterable[str] = ("crawl",),
    seed: int = 0,
    randomised: bool = True,
    video: bool = True,
    policy: Path | str | None = None,
    replace: bool = False,
    progress: Progress | None = None,
) -> Outcome:
    """Drive a map from start to goal and write everything into ``out``.

    The folder appears when the run is over, whole; with ``replace`` it takes the place of
    an older run.

    Raises:
        MobiusError: A mistake in map, places, modes or policy; nothing has been written.
    """
    chosen = check_modes(modes)
    world = open_world(source, start=start, goal=goal)
    with staged(out, replace=replace) as folder:
        plan = plan_mission(world, chosen)
        began = time.perf_counter()
        record, judge, model = drive(
            world, plan, seed=seed, randomised=randomised, policy=policy, progress=progress
        )
        wall = time.perf_counter() - began
        record.summary = summarise(record, judge, seed=seed, wall_s=wall)
        record.summary["map"] = world.name
        names, notes = write_results(
            folder, world, record, judge, model, video=video, progress=progress
        )
    if record.summary["ended"] == "time_limit":
        notes.append("the robot ran out of time; report.html shows where it was held up")
    return Outcome(record, record.summary, {n: out / n for n in names}, tuple(notes))
