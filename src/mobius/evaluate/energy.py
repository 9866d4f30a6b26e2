"""What a metre, a cell and a change of body cost, from joint power in physics.

Mechanical work is the integral of sum |torque * rate| over all servos, as everywhere. Crawl and
biped walk straight at the speed that plans are followed at, on flat ground; a roll is counted
from the moment it is asked for to the crawl stance after it, as a plan has to pay for it, and
so are changes of body. The result becomes the planner's costs (:meth:`Energy.travel`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mobius.assemble import Start, build_sim_stack, flat_model
from mobius.errors import InvalidInput, MobiusError, UnknownName
from mobius.evaluate.commands import Segment
from mobius.evaluate.episode import Setup, drive
from mobius.evaluate.gauge import DT
from mobius.evaluate.jobs import run_jobs
from mobius.geometry import heading_yaw
from mobius.modes.follow import CRAWLING, WALKING
from mobius.plan import Travel
from mobius.robot import TICK
from mobius.types import Mode, ModeCommand, StateEstimate

Array = NDArray[np.float64]

MODES = ("crawl", "biped", "roll")
SPEED = {"crawl": CRAWLING.speed, "biped": WALKING.speed}
"""At which plans are followed [m/s]."""
CELL = 0.5
"""Edge of the paper's cells [m]."""
GRAVITY = 9.81
WALK_S, RAMP_S = 12.0, 2.0
"""A walk lasts so long [s], and counts after so long [s]."""
ROLLS = 2
"""Rolls one after another per seed."""
STAND_S = 1.5
"""Standing before a motion is asked for [s]."""
PATIENCE_S = 25.0
"""A motion that has not ended so long after it was asked for has failed [s]."""


@dataclass(frozen=True)
class Trial:
    """One walk, roll or change of body of one robot."""

    what: str
    """A mode, or ``crawl>biped``."""
    seed: int
    seconds: float
    metres: float
    joules: float
    mass: float
    """Of the robot as drawn [kg]."""
    failed: bool = False
    """It fell, or did not end in time; such trials do not count towards the means."""
    cells: int = 0
    """Cells that the trunk entered and had not been in."""


@dataclass(frozen=True)
class ModeEnergy:
    """Means of one mode, weighted by the way."""

    m_per_s: float
    J_per_m: float
    J_per_cell: float | None
    """Per cell visited; None where the way was too short to enter one."""
    cost_of_transport: float
    """Energy over weight and way."""
    trials: int
    failures: int


@dataclass(frozen=True)
class SwitchEnergy:
    """Means of a change of body."""

    s: float
    J: float
    trials: int
    failures: int


@dataclass(frozen=True)
class Energy:
    """The result."""

    seed: int
    seeds: int
    modes: dict[str, ModeEnergy]
    switches: dict[str, SwitchEnergy] = field(default_factory=dict)
    """By ``crawl>biped``."""

    def travel(self) -> Travel:
        """As the planner reads it; a change costs its time and energy."""
        pairs = {k: (Mode(k.split(">")[0]), Mode(k.split(">")[1])) for k in self.switches}
        return Travel(
            m_per_s={Mode(k): v.m_per_s for k, v in self.modes.items()},
            J_per_m={Mode(k): v.J_per_m for k, v in self.modes.items()},
            switch_s={pairs[k]: v.s for k, v in self.switches.items()},
            switch_J={pairs[k]: v.J for k, v in self.switches.items()},
            source=f"joint power in physics, flat ground, seeds {self.seed} to"
            f" {self.seed + self.seeds - 1}",
        )

    def as_json(self) -> dict[str, Any]:
        """Every figure, for ``json.dump``."""
        return asdict(self)


def energy(
    *,
    modes: Iterable[str] = MODES,
    switches: bool = True,
    seeds: int = 5,
    seed: int = 0,
    randomised: bool = True,
    workers: int = 1,
    progress: Callable[[float], None] | None = None,
) -> Energy:
    """Measure.

    Args:
        modes: Of ``crawl``, ``biped``, ``roll``.
        switches: Whether changes between crawl and biped are measured, where both are asked for.
        seeds: Robots, >= 1.
        seed: The first.
        randomised: Whether robots, floor and sensors are drawn from the seeds.
        workers: Processes; 0 takes one a CPU.
        progress: Told the share that is done.

    Raises:
        UnknownName: There is no such mode.
        InvalidInput: A motion that is needed is not there.
        MobiusError: A mode failed with every seed.
    """
    wanted = list(dict.fromkeys(modes))
    for name in wanted:
        if name not in MODES:
            raise UnknownName("mode", name, MODES)
    if not wanted:
        raise InvalidInput("expected at least one mode, e.g. --modes crawl")
    works = list(wanted)
    if switches and {"crawl", "biped"} <= set(wanted):
        works.append("switches")
    jobs = [(name, s, randomised) for name in works for s in range(seed, seed + seeds)]
    trials = [t for ts in run_jobs(_work, jobs, workers=workers, progress=progress) for t in ts]
    return summary_of(trials, seed=seed, seeds=seeds)


def summary_of(trials: Sequence[Trial], *, seed: int, seeds: int) -> Energy:
    """Means over trials; modes and changes in the order in which they come."""
    table: dict[str, ModeEnergy] = {}
    changes: dict[str, SwitchEnergy] = {}
    for what in dict.fromkeys(t.what for t in trials):
        own = [t for t in trials if t.what == what]
        good = [t for t in own if not t.failed]
        if not good:
            raise MobiusError(f"energy: '{what}' failed in all of {len(own)} trials")
        joules, seconds = sum(t.joules for t in good), sum(t.seconds for t in good)
        counts = (len(own), len(own) - len(good))
        if ">" in what:
            changes[what] = SwitchEnergy(seconds / len(good), joules / len(good), *counts)
            continue
        metres = sum(t.metres for t in good)
        weight = sum(t.mass * GRAVITY * t.metres for t in good)
        cells = sum(t.cells for t in good)
        per_cell = joules / cells if cells else None
        table[what] = ModeEnergy(
            metres / seconds, joules / metres, per_cell, joules / weight, *counts
        )
    return Energy(seed=seed, seeds=seeds, modes=table, switches=changes)


def cells_entered(p: Array) -> int:
    """Cells that a way (n, 2) [m] enters, each once; the one that it begins in is none."""
    return max(len(np.unique(np.floor(p / CELL), axis=0)) - 1, 0)


def _work(job: tuple[str, int, bool]) -> list[Trial]:
    what, seed, randomised = job
    if what in SPEED:
        return [_walk(what, seed, randomised)]
    needs = ("crawl", "roll") if what == "roll" else ("crawl", "biped")
    run = _Motions(seed, randomised, needs)
    return run.rolls() if what == "roll" else run.changes()


def _walk(body: str, seed: int, randomised: bool) -> Trial:
    """Straight on at the speed of plans."""
    model = flat_model()
    walk = Segment("forward", (SPEED[body], 0.0, 0.0))
    setup = Setup(body, seed, randomised=randomised)
    episode = drive(setup, [walk], hold_s=WALK_S, model=model)
    readings = episode.readings
    counted = readings.t >= RAMP_S
    p = readings.p[counted]
    return Trial(
        what=body,
        seed=seed,
        seconds=float(counted.sum() * DT),
        metres=float(np.linalg.norm(p[-1, :2] - p[0, :2])) if len(p) else 0.0,
        joules=float(readings.power()[counted].sum() * DT),
        mass=float(model.body_mass.sum()),
        failed=episode.fallen,
        cells=cells_entered(p[:, :2]),
    )


class _Motions:
    """One robot that is asked for motions, one after another."""

    def __init__(self, seed: int, randomised: bool, modes: tuple[str, ...]) -> None:
        self.seed, self._model = seed, flat_model()
        start = Start(body="crawl", seed=seed, randomised=randomised)
        several: dict[str, Any] = {"modes": modes}
        self.stack, self.robot = build_sim_stack(self._model, start, **several)
        self._wants = Mode.CRAWL
        self._lost = False

    def rolls(self) -> list[Trial]:
        """A few rolls; metres are those towards the tail."""
        return [self._trial("roll", Mode.ROLL, Mode.CRAWL) for _ in range(ROLLS)]

    def changes(self) -> list[Trial]:
        """Up onto two legs, and down again."""
        up = self._trial("crawl>biped", Mode.BIPED, Mode.BIPED)
        return [up, self._trial("biped>crawl", Mode.CRAWL, Mode.CRAWL)]

    def _trial(self, what: str, ask: Mode, end: Mode) -> Trial:
        """Stand, ask, wait for the end."""
        self._for(STAND_S)
        tick, joules = self.stack.tick, self.stack.energy
        p, yaw = self._pose()
        self._wants = ask
        begun = ended = False
        way = [p]
        while not (ended or self._lost) and (self.stack.tick - tick) * TICK < PATIENCE_S:
            mode = self._turn()
            way.append(self._pose()[0])
            self._lost = mode is Mode.RECOVER or self.stack.machine.stopped
            begun = begun or mode not in (Mode.CRAWL, Mode.BIPED)
            if ask is Mode.ROLL and begun:
                self._wants = Mode.CRAWL
            ended = begun and mode is end
        return Trial(
            what=what,
            seed=self.seed,
            seconds=(self.stack.tick - tick) * TICK,
            metres=float((p - way[-1]) @ [np.cos(yaw), np.sin(yaw)]),
            joules=self.stack.energy - joules,
            mass=float(self._model.body_mass.sum()),
            failed=not ended,
            cells=cells_entered(np.array(way)),
        )

    def _for(self, seconds: float) -> None:
        end = self.stack.tick + round(seconds / TICK)
        while self.stack.tick < end:
            self._turn()

    def _turn(self) -> Mode:
        def source(belief: StateEstimate) -> ModeCommand:
            return ModeCommand(mode=self._wants, twist_H=np.zeros(3), stamp=belief.stamp)

        self.stack.turn(source)
        return self.stack.machine.mode

    def _pose(self) -> tuple[Array, float]:
        truth = self.robot.truth()
        return np.array(truth.p_OB[:2]), float(heading_yaw("crawl", truth.q_OB))
