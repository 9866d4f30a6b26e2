"""``mobius run``: a whole mission into a folder."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mobius.mission.body import check_modes
from mobius.mission.drive import drive
from mobius.mission.footprint import footprint_of
from mobius.mission.prepare import open_world, plan_mission
from mobius.mission.prices import read_prices
from mobius.mission.stagehand import Stagehand
from mobius.mission.summary import summarise
from mobius.results import Progress, staged, write_results
from mobius.stack import RunRecord
from mobius.world import check_scenario, read_scenario


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a run leaves."""

    record: RunRecord
    summary: dict[str, Any]
    files: dict[str, Path]
    notes: tuple[str, ...]
    """Things that went otherwise than asked, a line each."""


def run(
    source: str | Path,
    out: Path,
    *,
    start: Sequence[float] | None = None,
    goal: Sequence[float] | None = None,
    modes: Iterable[str] = ("crawl",),
    regions: str | Path | None = None,
    scenario: str | Path | None = None,
    costs: str | Path | None = None,
    per_s: float = 0.0,
    per_J: float = 0.0,
    seed: int = 0,
    randomised: bool = True,
    video: bool = True,
    policy: Path | str | None = None,
    replace: bool = False,
    progress: Progress | None = None,
) -> Outcome:
    """Drive a map from start to goal and write everything into ``out``.

    The folder appears when the run is over, whole; with ``replace`` it takes the place of
    an older run. ``costs`` is a file of measured seconds and joules
    (:func:`mobius.plan.read_costs`), ``per_s`` and ``per_J`` are their prices in plans [points].
    ``policy`` decides the room that the way keeps, too (:func:`mobius.mission.footprint_of`).

    Raises:
        MobiusError: A mistake in map, regions, scenario, costs, places, modes or policy;
            nothing has been written.
    """
    chosen, prices = check_modes(modes), read_prices(costs, per_s=per_s, per_J=per_J)
    happens = None if scenario is None else read_scenario(scenario)
    world = open_world(
        source, start=start, goal=goal, regions=regions, footprint=footprint_of(policy)
    )
    if happens is not None and scenario is not None:
        check_scenario(happens, world.occupancy, scenario)
    with staged(out, replace=replace) as folder:
        there = Stagehand(world, happens).world(check=True)
        plan = plan_mission(there, chosen, prices=prices)
        began = time.perf_counter()
        driven = drive(
            world,
            plan,
            modes=chosen,
            scenario=happens,
            seed=seed,
            randomised=randomised,
            policy=policy,
            prices=prices,
            progress=progress,
        )
        wall = time.perf_counter() - began
        record = driven.record
        record.summary = summarise(driven, seed=seed, wall_s=wall)
        record.summary["map"] = world.name
        names, notes = write_results(
            folder,
            driven.stagehand.world(),
            record,
            driven.judge,
            driven.model,
            scene=driven.scene,
            later=[(r.t, r.plan) for r in driven.pilot.replans if r.plan is not None],
            mocap=driven.judge.mocap,
            video=video,
            progress=progress,
        )
    notes += _notes(record.summary)
    return Outcome(record, record.summary, {n: out / n for n in names}, tuple(notes))


def _notes(summary: dict[str, Any]) -> list[str]:
    """What a user should know beside the figures."""
    notes = []
    if summary["ended"] == "time_limit":
        notes.append("the robot ran out of time; report.html shows where it was held up")
    if summary["ended"] == "no_way":
        problems = [r["problem"] for r in summary["replans"] if r["problem"]]
        notes.append(f"the robot found no way on: {problems[-1]}")
    if summary["ended"] == "stopped":
        notes.append(
            "the mode machine stopped the robot: a motion and the recovery after it failed"
        )
    if not summary["forced_modes_used"]:
        wrong = [m for m, f in summary["forced_modes"].items() if not f["used"]]
        notes.append(f"the map forces {' and '.join(wrong)}, which the robot did not use there")
    return notes
