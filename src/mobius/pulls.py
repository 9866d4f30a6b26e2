"""Table IX in simulation: hands on a bar, pulled along two axes until the grasp gives.

The limit of each grasp is drawn from Table IX, so its mean and spread come back by construction
where everything else is ideal. What the simulation adds, and the figures therefore test: that
physics holds the drawn limit and no other, at the wrist's sensor, with the hand's inertia and
weight, an elastic machine, a force that rises at different rates, and a pull that is not quite
along its axis.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np

from mobius import paper
from mobius.errors import InvalidInput
from mobius.headless import import_mujoco
from mobius.model.hand import CROSSHEAD_STIFFNESS, load_hand
from mobius.model.limit_surface import LimitSurface
from mobius.robot.grasp import STIFFNESS
from mobius.robot.pull_rig import Axis, Pull, PullRig
from mobius.world.bar import Bar, add_bar

AXES: tuple[Axis, ...] = ("x", "z")
"""Of Table IX: along the groove and across it."""
FORCE_RATE = (100.0, 400.0)
"""How fast the force rises in a pull, drawn evenly [N/s] [A]."""
TILT = 0.0175
"""Spread of the angle by which a pull misses its axis [rad] [A]: 1 deg."""
PLACE = 0.002
"""Spread of where the hand closes beside the bar's middle [m] [A]; at most twice that."""
CHUNK = 20
"""Seeds that one job works on."""
Progress = Callable[[float], None]
"""Called with the share of the work that is done (0 to 1)."""


@dataclass(frozen=True)
class Pulls:
    """Pulls to failure, one per axis and seed."""

    seed: int
    """The first."""
    by_axis: dict[str, tuple[Pull, ...]]
    """In the order of the seeds."""

    def mean(self, axis: str) -> float:
        """Mean of the greatest forces [N]."""
        return float(np.mean([p.peak for p in self.by_axis[axis]]))

    def std(self, axis: str) -> float:
        """Standard deviation of the greatest forces [N]; 0 for one pull."""
        peaks = [p.peak for p in self.by_axis[axis]]
        return float(np.std(peaks, ddof=1)) if len(peaks) > 1 else 0.0

    def as_json(self) -> dict[str, Any]:
        """Figures by axis, beside the paper's and beside what was drawn."""
        axes = self.by_axis
        return {
            "seeds": len(axes[AXES[0]]),
            "seed": self.seed,
            "mean_N": {a: self.mean(a) for a in axes},
            "std_N": {a: self.std(a) for a in axes},
            "paper_mean_N": {a: paper.TABLE_IX[a].mean for a in axes},
            "paper_std_N": {a: paper.TABLE_IX[a].std for a in axes},
            "peak_minus_drawn_N": {
                a: float(np.mean([p.peak - p.drawn for p in axes[a]])) for a in axes
            },
            "ended": {a: dict(Counter(p.end for p in axes[a])) for a in axes},
        }

    def rows(self) -> list[dict[str, Any]]:
        """Ours beside the paper's, a row per axis of Table IX."""
        table: list[dict[str, Any]] = []
        for axis in AXES:
            printed, mean, std = paper.TABLE_IX[axis], self.mean(axis), self.std(axis)
            table.append(
                {
                    "axis": axis,
                    "pull": "along the groove" if axis == "x" else "across the groove",
                    "pulls": len(self.by_axis[axis]),
                    "mean_N": round(mean, 2),
                    "paper_mean_N": printed.mean,
                    "mean_off_%": round(100 * (mean / printed.mean - 1), 1),
                    "std_N": round(std, 2),
                    "paper_std_N": printed.std,
                    "std_off_%": round(100 * (std / printed.std - 1), 1),
                }
            )
        return table


def pull_to_failure(
    *, seeds: int = 1000, seed: int = 0, workers: int = 0, progress: Progress | None = None
) -> Pulls:
    """Pull ``seeds`` fresh grasps along each axis of Table IX until they give.

    Args:
        seeds: Pulls per axis, >= 1.
        seed: The first; each draws its limit surface, force rate, tilt and place.
        workers: Processes; 0 takes one a CPU, 1 works here.
        progress: Called after each job.

    Raises:
        InvalidInput: Fewer than one seed.
    """
    if seeds < 1:
        raise InvalidInput(f"pull_to_failure: expected seeds >= 1, got {seeds}")
    every = range(seed, seed + seeds)
    jobs = [(a, every[i : i + CHUNK]) for a in AXES for i in range(0, seeds, CHUNK)]
    found: dict[str, list[Pull]] = {a: [] for a in AXES}
    for k, ((axis, _), part) in enumerate(zip(jobs, _spread(jobs, workers), strict=True)):
        found[axis] += part
        if progress is not None:
            progress((k + 1) / len(jobs))
    return Pulls(seed, {a: tuple(pulls) for a, pulls in found.items()})


def pulling_machine() -> PullRig:
    """The left hand, fingers up, at the middle of a bar."""
    spec = load_hand("left")
    add_bar(spec, Bar(height=0.10, yaw=-np.pi / 2, length=0.30))
    return PullRig(spec.compile())


def pull_once(rig: PullRig, axis: Axis, seed: int) -> Pull:
    """The pull of one seed: a fresh grasp, drawn rate, tilt and place."""
    rng = np.random.default_rng([seed, AXES.index(axis)])
    surface = LimitSurface.draw(rng)
    y, z = (float(v) for v in rng.normal(0.0, PLACE, 2).clip(-2 * PLACE, 2 * PLACE))
    grasp = float(STIFFNESS["xyz".index(axis)])
    together = 1.0 / (1.0 / CROSSHEAD_STIFFNESS + 1.0 / grasp)  # machine and grasp in series
    speed = float(rng.uniform(*FORCE_RATE)) / together
    return rig.pull(surface, axis, speed=speed, tilt=float(rng.normal(0.0, TILT)), offset=(y, z))


Job = tuple[Axis, Sequence[int]]


def _pull_many(job: Job) -> list[Pull]:
    axis, seeds = job
    rig = pulling_machine()
    return [pull_once(rig, axis, seed) for seed in seeds]


def _spread(jobs: Sequence[Job], workers: int) -> Iterator[list[Pull]]:
    """Results in the order of the jobs."""
    workers = min(workers or len(os.sched_getaffinity(0)), len(jobs))
    if workers <= 1:
        yield from map(_pull_many, jobs)
        return
    with ProcessPoolExecutor(workers, initializer=import_mujoco) as pool:
        try:
            yield from pool.map(_pull_many, jobs)
        finally:
            pool.shutdown(wait=False, cancel_futures=True)
