"""A plan carried out in physics."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from mobius.errors import MapError
from mobius.mission.floor import floor_of
from mobius.mission.judge import MissionJudge
from mobius.mission.pilot import Pilot
from mobius.mission.prepare import path_heading, with_ends
from mobius.mission.prices import NO_PRICES, Prices
from mobius.mission.stagehand import Stagehand
from mobius.modes import FollowerConfig
from mobius.results import Progress
from mobius.robot import TICK
from mobius.stack import ACT_EVERY, RunRecord
from mobius.types import Mode, ModeCommand, Plan, StateEstimate
from mobius.world import Scenario, World


class Driven(NamedTuple):
    """What a drive leaves."""

    record: RunRecord
    judge: MissionJudge
    model: Any
    """The compiled scene, as it was varied."""
    pilot: Pilot
    stagehand: Stagehand
    scene: str
    """The scene as MJCF, as it was drawn."""


def drive(
    world: World,
    plan: Plan,
    *,
    modes: Sequence[Mode] = (Mode.CRAWL,),
    scenario: Scenario | None = None,
    seed: int = 0,
    randomised: bool = True,
    policy: Path | str | None = None,
    config: FollowerConfig | None = None,
    prices: Prices = NO_PRICES,
    progress: Progress | None = None,
) -> Driven:
    """Carry a plan out in physics, planning anew where that is due.

    Ends one second after the pilot says it arrived, when the robot is lost (with crawl alone:
    at the first fall), when there is no way and nothing is to come, or at the time limit:
    20 s and four times what the plan takes if all goes well, counted anew for a longer plan on
    the way, at most twice the first limit.

    Args:
        world: As its map shows it, without the scenario's obstacles.
        plan: Over the world's cells, made with the obstacles that are there at first.
        modes: That plans may use.
        scenario: What changes on the way.
        seed: Of friction, mass, delay and sensors.
        randomised: Whether they are drawn at all.
        policy: What drives the crawling robot; if not given, the shipped one, that for rough
            ground where the map has some.
        config: Of the crawling follower.
        prices: Of plans on the way.
        progress: Told how far the robot is.
    """
    stagehand = Stagehand(world, scenario)
    pilot = Pilot(stagehand.world(), plan, modes, config=config, prices=prices)
    stack, robot, model, scene = _build(world, plan, modes, stagehand, seed, randomised, policy)
    judge = MissionJudge(robot, recovers=len(modes) > 1, ground=floor_of(world))

    def source(belief: StateEstimate) -> ModeCommand:
        return pilot.command(belief, ACT_EVERY * TICK, stack.machine.mode)

    first = limit = 20.0 + 4.0 * pilot.follower.expected_s
    replans, stop_at, began = 0, np.inf, time.perf_counter()
    while not judge.fallen and stack.tick * TICK < min(limit, stop_at):
        sample = stack.turn(source)
        if sample is None:
            continue
        now = sample.tick * TICK
        truth = judge.see(sample)
        stagehand.turn(now, truth.p_OB[:2], robot, pilot)
        if len(pilot.replans) > replans:
            replans = len(pilot.replans)
            limit = min(max(limit, now + 20.0 + 4.0 * pilot.follower.expected_s), 2.0 * first)
        over = pilot.arrived or _hopeless(pilot, stagehand) or stack.machine.stopped
        stop_at = min(stop_at, stack.tick * TICK + 1.0) if over else np.inf
        if progress is not None and sample.tick % 60 == 0:
            progress("driving", pilot.follower.share)
    record = judge.record(world.grid, plan)
    record.summary.update(
        energy_J=stack.energy,
        loop_s=time.perf_counter() - began,
        ended=_ended(judge, pilot, stack.machine.stopped),
    )
    return Driven(record, judge, model, pilot, stagehand, scene)


def _build(
    world: World,
    plan: Plan,
    modes: Sequence[Mode],
    stagehand: Stagehand,
    seed: int,
    randomised: bool,
    policy: Path | str | None,
) -> tuple[Any, Any, Any, str]:
    """Stack, robot and scene, as model and as MJCF, the robot at the start of the plan.

    Raises:
        MapError: Physics cannot build the scene.
    """
    from mobius.assemble import Start, build_sim_stack
    from mobius.model.robot import load_spec
    from mobius.world.scene import build_scene

    obstacles = stagehand.scenery.scenario.obstacles
    try:
        spec = build_scene(world, load_spec("full"), obstacles=obstacles)
        model = spec.compile()
    except ValueError as error:
        problem = " ".join(str(error).split())
        raise MapError(
            f"map '{world.name}': physics cannot build it ({problem}); look at the sizes of its"
            " rough and raised places and of the scenario's obstacles"
        ) from None
    model.opt.timestep = TICK
    path = with_ends(plan, world.grid)
    x, y = (float(v) for v in path.xy_M[0])
    start = Start(
        body=_first_body(world, plan),
        xy=(x, y),
        yaw=path_heading(path),
        seed=seed,
        randomised=randomised,
    )
    crawl = policy or ("rough" if world.rough else "flat")
    several: dict[str, Any] = {"policy": crawl}
    if len(modes) > 1:
        several = {"policy": {"crawl": crawl}, "modes": [m.value for m in modes]}
    stack, robot = build_sim_stack(model, start, **several)
    return stack, robot, model, spec.to_xml()


def _first_body(world: World, plan: Plan) -> str:
    """The body that the robot begins in: on two legs only where the start admits no crawl."""
    cell = tuple(plan.cells[0])
    upright = bool(plan.modes) and plan.modes[0] is Mode.BIPED
    return "biped" if upright and not world.grid.allowed[cell] & Mode.CRAWL.bit else "crawl"


def _hopeless(pilot: Pilot, stagehand: Stagehand) -> bool:
    """Whether there is no way and nothing to come, while the robot stands, that may give one."""
    return pilot.hopeless and not stagehand.scenery.comes_by_itself


def _ended(judge: MissionJudge, pilot: Pilot, stopped: bool) -> str:
    """How: ``fallen``, ``stopped``, ``arrived``, ``no_way`` or ``time_limit``."""
    if judge.fallen:
        return "fallen"
    if stopped:
        return "stopped"
    return "arrived" if pilot.arrived else "no_way" if pilot.stuck else "time_limit"
