"""How much tuning helps: force error before and after, over contacts from soft to stiff.

Every case starts from gains that somebody could have set by hand, tunes for 30 s while the
wished wrench changes, and is judged on the same 8 s of wishes, sway and noise before and after.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mobius.control.admittance import DT, AxisGains, Interval, Loop, damping
from mobius.control.admittance.law import batch_steps
from mobius.control.admittance.stability import as_rows
from mobius.control.tuning import Report, Specification, Tuner, TunerConfig
from mobius.errors import InvalidInput, UnknownName
from mobius.evaluate.contact import KINDS, Contact, ContactPlant, references
from mobius.evaluate.jobs import Progress, run_jobs

__all__ = ["RANGE", "STARTS", "Case", "Tuning", "mediocre", "tune_case", "tuning"]

Array = NDArray[np.float64]

RANGE = (500.0, 50_000.0)
"""Softest and stiffest contact [N/m]."""
LOOP = Loop()
TUNE_S, JUDGE_S, SETTLE_S = 30.0, 8.0, 2.0
"""Length of tuning and of a judgement, and the grid of the settling time [s]."""
RUNAWAY = 150.0
"""A force error that nobody would call a transient [N]."""
STARTS = ("one_for_all", "guess")


def mediocre(start: str, contact: Contact, rng: np.random.Generator) -> AxisGains:
    """Gains set by hand.

    ``one_for_all``: one set for every contact, as people do who do not know what will be
    touched. K_f is 1; D is the least (in steps of 10 %) that leaves every pole of the nominal
    loop a damping ratio of 0.5 at the stiffest contact. A spring a tenth as stiff as the
    softest contact, both integrals with 10 s.

    ``guess``: the same rules for a contact whose stiffness was guessed wrong by up to a factor
    of 3 either way, with as much again as a margin.
    """
    if start not in STARTS:
        raise UnknownName("start", start, STARTS)
    if start == "one_for_all":
        stiff, soft = RANGE[1], RANGE[0]
    else:
        wrong = float(np.exp(rng.uniform(-np.log(3.0), np.log(3.0))))
        stiff = soft = 3.0 * wrong * contact.stiffness
        soft /= 10.0
    K = soft / 10.0
    D = 10.0
    while True:
        gains = AxisGains(D=D, K=K, K_f=1.0, K_fi=0.1, K_pi=0.1 * K)
        if damping(gains, Interval(stiff, stiff, lag=(1.0,)), LOOP)[0] >= 0.5:
            return gains
        D *= 1.1


@dataclass(frozen=True)
class Case:
    """One contact and how its gains came out."""

    kind: str
    stiffness: float
    """[N/m]."""
    seed: int
    before: float
    """Force error with the gains at the start, root mean square [N]."""
    after: float
    """With the tuned gains [N]."""
    settled_s: float
    """From then on the gains' force error, each set frozen, was within 10 % of the first error
    of what it was in the end [s]."""
    unstable: bool
    """The true loop had an eigenvalue >= 1 with any gains used, or the force ran away."""
    taken: int
    """Steps taken, shrunk ones among them."""
    refused: int
    gains_before: dict[str, float]
    gains_after: dict[str, float]

    @property
    def change(self) -> float:
        """Relative change of the force error; -0.45 is 45 % less."""
        return self.after / self.before - 1.0


@dataclass(frozen=True, eq=False)
class Run:
    """One tuning run, for figures."""

    error: Array
    """(t, n) wrench minus wish, true [N]."""
    reports: list[tuple[float, Report]]
    """Time [s] and report of every measurement."""


def own_seed(contact: Contact, seed: int) -> list[int]:
    """A contact's own stream of draws within a seed."""
    return [seed, KINDS.index(contact.kind), round(contact.stiffness)]


class _Loop:
    """Law, filter and plant of one contact, ticking."""

    def __init__(self, contact: Contact, gains: AxisGains, ticks: int, seed: int, wishes: int):
        own = own_seed(contact, seed)
        self.w = references(contact, ticks, np.random.default_rng([*own, wishes]))
        self.plant = ContactPlant(contact, self.w[0], seed=own)
        self.state = np.zeros((contact.n, 4))
        self.filtered = self.w[0].copy()
        self.use(gains)

    def use(self, gains: AxisGains) -> None:
        A, B, E = (m[0] for m in batch_steps(as_rows(gains), LOOP.tau))
        self._A, self._w, self._f = A.T.copy(), B[:, 1], E[:, 0]

    def tick(self, k: int, tuner: Tuner | None = None) -> tuple[Array, Report | None]:
        f, read = self.plant.read()
        report = None
        if tuner is not None:
            report = tuner.observe(self.state, read, self.w[k], filtered=self.filtered)
            if report is not None and report.verdict in ("taken", "shrunk"):
                self.use(report.gains)
        self.filtered = self.filtered + LOOP.filter_coefficient * (read - self.filtered)
        s = self.state @ self._A
        self.state = s + self.w[k][:, None] * self._w + self.filtered[:, None] * self._f
        self.plant.move(self.state[:, 0])
        return f - self.w[k], report


def run(
    contact: Contact,
    gains: AxisGains,
    *,
    seconds: float,
    seed: int,
    wishes: int = 0,
    tuner: Tuner | None = None,
) -> Run:
    """Hold a contact for a while, tuning or not.

    Args:
        contact: What is touched.
        gains: At the start.
        seconds: [s].
        seed: Of the plant.
        wishes: Of the wished wrench.
        tuner: Sees every tick; its gains are used as they come.
    """
    ticks = round(seconds / DT)
    loop = _Loop(contact, gains, ticks, seed, wishes)
    error, reports = np.empty((ticks, contact.n)), []
    for k in range(ticks):
        error[k], report = loop.tick(k, tuner)
        if report is not None:
            reports.append((k * DT, report))
    return Run(error, reports)


def rmse(error: Array) -> float:
    """Root mean square over ticks and axes."""
    return float(np.sqrt(np.mean(np.square(error))))


def tune_case(
    kind: str,
    stiffness: float,
    *,
    seed: int,
    start: str = "one_for_all",
    config: TunerConfig | None = None,
    specification: Specification | None = None,
) -> tuple[Case, Run]:
    """Tune one contact and judge it.

    Args:
        kind: wall, bar or peg.
        stiffness: [N/m].
        seed: Of everything drawn.
        start: How the first gains came about, see :func:`mediocre`.
        config: Of the tuner.
        specification: Of the tuner.
    """
    contact = Contact(kind, stiffness)
    gains = mediocre(start, contact, np.random.default_rng([*own_seed(contact, seed), 3]))
    tuner = Tuner(gains, contact.n, loop=LOOP, specification=specification, config=config)
    tuned = run(contact, gains, seconds=TUNE_S, seed=seed, wishes=1, tuner=tuner)

    def judged(g: AxisGains) -> float:
        return rmse(run(contact, g, seconds=JUDGE_S, seed=seed, wishes=2).error)

    used = [gains, *(r.gains for _t, r in tuned.reports)]
    before, after = judged(gains), judged(tuner.gains)
    at = [0.0, *(t for t, _r in tuned.reports)]
    settled = TUNE_S
    for moment in np.arange(TUNE_S - SETTLE_S, -0.5 * SETTLE_S, -SETTLE_S):
        k = int(np.searchsorted(at, moment, side="right")) - 1
        if abs(judged(used[max(k, 0)]) - after) > 0.1 * before:
            break
        settled = float(moment)
    plant = ContactPlant(contact, np.zeros(contact.n), seed=own_seed(contact, seed))
    radius = max(
        plant.closed_loop(as_rows(g)[0], LOOP.filter_coefficient) for g in dict.fromkeys(used)
    )
    verdicts = [r.verdict for _t, r in tuned.reports]
    case = Case(
        kind=kind,
        stiffness=stiffness,
        seed=seed,
        before=before,
        after=after,
        settled_s=settled,
        unstable=bool(radius >= 1.0 or np.abs(tuned.error).max() > RUNAWAY),
        taken=verdicts.count("taken") + verdicts.count("shrunk"),
        refused=verdicts.count("refused"),
        gains_before=asdict(gains),
        gains_after=asdict(tuner.gains),
    )
    return case, tuned


@dataclass(frozen=True)
class Tuning:
    """All cases of an evaluation."""

    start: str
    cases: list[Case]

    def as_json(self) -> dict[str, Any]:
        """The figures, and every case."""
        change = np.array([c.change for c in self.cases])
        settled = [c.settled_s for c in self.cases]
        return {
            "start": self.start,
            "cases": len(self.cases),
            "force_rmse_change": float(np.median(change)),
            "force_rmse_change_p90": float(np.percentile(change, 90)),
            "force_rmse_change_worst": float(change.max()),
            "settled_s": float(np.median(settled)),
            "settled_s_worst": float(max(settled)),
            "unstable": sum(c.unstable for c in self.cases),
            "by_kind": {
                k: float(np.median([c.change for c in self.cases if c.kind == k]))
                for k in dict.fromkeys(c.kind for c in self.cases)
            },
            "runs": [{**asdict(c), "change": c.change} for c in self.cases],
        }


def tuning(
    *,
    seeds: int = 1,
    seed: int = 0,
    start: str = "one_for_all",
    stiffnesses: int = 20,
    workers: int = 0,
    progress: Progress | None = None,
) -> Tuning:
    """All kinds of contact over the range of stiffnesses.

    Args:
        seeds: How many of each contact.
        seed: The first.
        start: How the first gains came about.
        stiffnesses: How many, spaced in the logarithm.
        workers: Processes; 0 takes one a CPU.
        progress: Told the share that is done.
    """
    if stiffnesses < 1:
        raise InvalidInput(f"tuning: expected at least one stiffness, got {stiffnesses}")
    if start not in STARTS:
        raise UnknownName("start", start, STARTS)
    jobs = [
        (kind, float(k), s, start)
        for s in range(seed, seed + seeds)
        for kind in KINDS
        for k in np.geomspace(*RANGE, stiffnesses)
    ]
    return Tuning(start, run_jobs(_one, jobs, workers=workers, progress=progress))


def _one(job: tuple[str, float, int, str]) -> Case:
    kind, stiffness, seed, start = job
    return tune_case(kind, stiffness, seed=seed, start=start)[0]
