"""Better numbers for a motion: CMA-ES over rehearsals of many drawn robots (library ``cma``)."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
from functools import partial

import cma
import numpy as np

from mobius.choreography.designs import Design, design_of
from mobius.choreography.rehearse import rehearse
from mobius.errors import InvalidInput
from mobius.headless import import_mujoco

POPULATION = 16
WORST = 0.3
"""Share of the worst robot's cost that is added to the mean: no robot may be given up."""
UNREACHABLE = 20.0
"""Cost of numbers from which the motion cannot be built."""

Progress = Callable[[int, float, float], None]
"""Called after each generation with its number, the best cost so far and its own best."""


def cost_of(name: str, numbers: Mapping[str, float], seeds: Sequence[int]) -> float:
    """Mean cost over robots, and a share of the worst."""
    design = design_of(name)
    try:
        motion = design.build(numbers)
    except InvalidInput:
        return UNREACHABLE
    costs = [rehearse(motion, design.keyframe, seed).cost for seed in seeds]
    return float(np.mean(costs) + WORST * np.max(costs))


def search(
    name: str,
    numbers: Mapping[str, float],
    *,
    seeds: Sequence[int],
    seconds: float,
    seed: int = 1,
    workers: int = 2,
    progress: Progress | None = None,
) -> tuple[dict[str, float], float]:
    """The best numbers found, and their cost.

    Args:
        name: Of the design.
        numbers: To begin with; never made worse.
        seeds: Of the robots rehearsed with.
        seconds: Wall time after which no new generation begins.
        seed: Of the search itself.
        workers: Processes.
        progress: Called after each generation.

    Raises:
        InvalidInput: The design has no numbers to choose.
    """
    design = design_of(name)
    if not design.ranges:
        raise InvalidInput(f"motion '{name}' is built without numbers; there is nothing to search")
    keys = list(design.ranges)
    low, high, spread = (np.array([design.ranges[k][i] for k in keys]) for i in range(3))
    best = dict(numbers)
    least = cost_of(name, best, seeds)
    start = np.clip((np.array([best[k] for k in keys]) - low) / (high - low), 0.0, 1.0)
    options = {"bounds": [0, 1], "popsize": POPULATION, "verbose": -9, "seed": seed}
    strategy = cma.CMAEvolutionStrategy(
        start, 0.3, {**options, "CMA_stds": spread / (high - low) / 0.3}
    )
    began, generation = time.perf_counter(), 0
    with ProcessPoolExecutor(workers, initializer=import_mujoco) as pool:
        while time.perf_counter() - began < seconds and not strategy.stop():
            points = strategy.ask()
            tried = [
                dict(zip(keys, (low + p * (high - low)).tolist(), strict=True)) for p in points
            ]
            costs = _costs(pool, name, tried, seeds)
            strategy.tell(points, costs)
            winner = int(np.argmin(costs))
            if costs[winner] < least:
                best, least = tried[winner], costs[winner]
            if progress is not None:
                progress(generation, least, costs[winner])
            generation += 1
    return best, least


def _costs(
    pool: Executor, name: str, tried: Sequence[Mapping[str, float]], seeds: Sequence[int]
) -> list[float]:
    return list(pool.map(partial(_cost, name, tuple(seeds)), tried))


def _cost(name: str, seeds: tuple[int, ...], numbers: Mapping[str, float]) -> float:
    return cost_of(name, numbers, seeds)


def chosen(design: Design, numbers: Mapping[str, float]) -> dict[str, float]:
    """Numbers as they are kept: to 1e-5, only those of the design."""
    return {k: round(float(numbers[k]), 5) for k in design.ranges}
