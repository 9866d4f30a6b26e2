"""How far from the drawing a robot may be: one property at a time, past the training range."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from mobius.control.bodies import body_of
from mobius.errors import UnknownName
from mobius.evaluate.commands import AXES, FULL, schedule
from mobius.evaluate.episode import Policy, Setup, drive
from mobius.evaluate.jobs import Progress, run_jobs
from mobius.robot import TICK
from mobius.robot.variation import Variation

HOLD_S = 5.0
"""Each of the two commands of an episode [s]."""


@dataclass(frozen=True)
class Sweep:
    """One property that is changed."""

    what: str
    """With its unit."""
    values: tuple[float, ...]
    usual: tuple[float, float]
    """What the other evaluations draw from."""
    vary: Callable[[float], Variation] = lambda value: Variation()
    """The robot at a value."""
    noise: bool = False
    """Whether the value is the factor on sensor noise."""


SWEEPS: dict[str, Sweep] = {
    "friction": Sweep(
        "friction of the soles",
        (0.2, 0.3, 0.4, 0.5, 0.8, 1.2, 1.6),
        (0.5, 1.2),
        lambda value: Variation(friction=value),
    ),
    "payload": Sweep(
        "mass on the trunk [kg]",
        (-2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0),
        (-1.0, 1.0),
        lambda value: Variation(trunk_mass=value),
    ),
    "delay": Sweep(
        "delay of the targets [ms]",
        (0.0, 10.0, 20.0, 30.0, 40.0, 50.0),
        (0.0, 20.0),
        lambda value: Variation(delay_ticks=round(1e-3 * value / TICK)),
    ),
    "motor": Sweep(
        "servo strength, relative",
        (0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3),
        (0.9, 1.1),
        lambda value: Variation(servo_gain=value),
    ),
    "noise": Sweep(
        "sensor noise, relative", (0.0, 1.0, 2.0, 3.0, 5.0, 8.0), (1.0, 1.0), noise=True
    ),
}
"""By name."""


@dataclass
class RobustnessRun:
    """One episode at one point of a sweep."""

    sweep: str
    value: float
    seed: int
    fallen: bool
    error: list[float]
    """Mean absolute error of vx, vy [m/s], wz [rad/s] over means over a stride."""


def setup_at(name: str, value: float, setup: Setup) -> Setup:
    """Who is evaluated at a point of a sweep: nominal but for one property."""
    sweep = SWEEPS[name]
    return Setup(
        setup.body,
        setup.seed,
        setup.policy,
        randomised=False,
        variation=sweep.vary(value),
        noise=value if sweep.noise else 1.0,
    )


def _stand_up_to(job: tuple[str, float, Setup]) -> RobustnessRun:
    name, value, setup = job
    segments = schedule(setup.body, setup.seed, count=2, names=(*FULL, "mixed"))
    episode = drive(setup_at(name, value, setup), segments, hold_s=HOLD_S)
    return RobustnessRun(
        name, value, setup.seed, episode.fallen, [float(v) for v in episode.error()]
    )


@dataclass
class Robustness:
    """The outcome of ``mobius eval BODY robustness``."""

    body: str
    seed: int
    """The first seed."""
    episodes: int
    falls: int
    sweeps: dict[str, dict[str, Any]]
    """Per sweep: what, values, usual (the range drawn elsewhere), survival (share of seeds) and
    mae of vx, vy [m/s], wz [rad/s], a number a value."""
    runs: list[RobustnessRun] = field(default_factory=list)

    def as_json(self) -> dict[str, Any]:
        """Plain values."""
        return asdict(self)


def robustness(
    body: str,
    *,
    seeds: int,
    seed: int = 0,
    policy: Policy = None,
    sweeps: tuple[str, ...] = tuple(SWEEPS),
    workers: int = 0,
    progress: Progress | None = None,
) -> Robustness:
    """Follow two commands for 5 s each, with one property changed and the rest nominal.

    Args:
        body: ``crawl`` or ``biped``.
        seeds: Episodes a point, >= 1; a seed draws commands and sensor noise.
        seed: First seed.
        policy: What drives; the shipped policy if not given.
        sweeps: Which of :data:`SWEEPS`.
        workers: Processes; 0 takes one a CPU.
        progress: Called with the share done after each episode.

    Raises:
        UnknownName: A sweep that does not exist.
    """
    body_of(body)
    for name in sweeps:
        if name not in SWEEPS:
            raise UnknownName("sweep", name, SWEEPS)
    jobs = [
        (name, value, Setup(body, seed + k, policy))
        for name in sweeps
        for value in SWEEPS[name].values
        for k in range(seeds)
    ]
    runs = run_jobs(_stand_up_to, jobs, workers=workers, progress=progress)
    return Robustness(
        body=body,
        seed=seed,
        episodes=len(runs),
        falls=sum(r.fallen for r in runs),
        sweeps={name: per_sweep(name, runs) for name in sweeps},
        runs=runs,
    )


def per_sweep(name: str, runs: list[RobustnessRun]) -> dict[str, Any]:
    """Survival and error at every value of a sweep."""
    sweep = SWEEPS[name]
    points = [[r for r in runs if (r.sweep, r.value) == (name, v)] for v in sweep.values]
    mae = np.array([np.mean([r.error for r in point], axis=0) for point in points])
    return {
        "what": sweep.what,
        "values": list(sweep.values),
        "usual": list(sweep.usual),
        "survival": [float(np.mean([not r.fallen for r in point])) for point in points],
        "mae": dict(zip(AXES, mae.T.tolist(), strict=True)),
    }
