"""Planning at 10 Hz among things that move: time of a plan, and whether anything is met.

    python benchmarks/plan_replan.py [--runs 3] [--steps 200] [--scenarios 1000]

Timing: the reconstructed 20 x 20 map, T = 20, five obstacles of one cell that walk to and fro,
known from now on; a plan a step, receding. Scenarios: 30 steps each on random maps; those
whose whole future leaves no path are counted apart.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mobius.plan import (
    RECONSTRUCTED_WEIGHTS,
    NoPlan,
    Planner,
    Problem,
    broken_rule,
    build_problem,
    reconstructed_map,
    solve,
)
from mobius.reproduce.replanning import walkers
from mobius.types import GridMap

Bools = NDArray[np.bool_]


def drive(
    problem: Problem, closed: Bools, steps: int, deadline_s: float
) -> tuple[list[float], int]:
    """Seconds of every plan, and how many steps met something; stops where no plan is left."""
    planner = Planner(problem, keep_horizon=True)
    seconds, met, at = [], 0, problem.start
    for t in range(steps):
        planner.update(closed=closed[t:])
        began = time.perf_counter()
        try:
            plan = planner.plan(deadline_s)
        except NoPlan:
            return seconds, met + 1
        seconds.append(time.perf_counter() - began)
        truth = replace(problem, closed=closed)
        to = (int(plan.cells[1][0]), int(plan.cells[1][1]))
        met += broken_rule(truth, at, to, plan.modes[0], t) is not None
        planner.update(at=to)
        at = to
    return seconds, met


def scenario(seed: int) -> tuple[Problem, Bools]:
    """A random map of 8 to 12 cells a side with three obstacles that move."""
    rng = np.random.default_rng([seed, 5])
    n = int(rng.integers(8, 13))
    blocked = rng.random((n, n)) < 0.15
    blocked[0, 0] = blocked[-1, -1] = False
    grid = GridMap("random", 0.5, np.zeros(3), blocked, np.full((n, n), 7, np.uint8))
    closed = walkers(rng, blocked, 60, 3)
    closed[:, 0, 0] &= np.arange(60) > 2
    return Problem(grid, (0, 0), (n - 1, n - 1), 8, allow_stay=True), closed


def timing(runs: int, steps: int) -> dict[str, float]:
    """Plans made, steps that met something, median and p99 of a plan [ms]; prints each run."""
    seconds: list[float] = []
    met = 0
    for run in range(runs):
        problem = build_problem(
            reconstructed_map(), horizon=20, weights=RECONSTRUCTED_WEIGHTS, allow_stay=True
        )
        closed = walkers(np.random.default_rng(run), problem.grid.blocked, steps + 40)
        took, collided = drive(problem, closed, steps, 0.035)
        seconds += took
        met += collided
        print(f"run {run}: {len(took)} plans, {collided} steps met something", flush=True)
    p50, p99 = (round(1e3 * float(s), 2) for s in np.percentile(seconds, [50, 99]))
    print(f"20 x 20, T = 20, 5 moving: median {p50:.1f} ms, p99 {p99:.1f} ms")
    return {"plans": len(seconds), "steps_met": met, "median_ms": p50, "p99_ms": p99}


def scenarios(count: int) -> dict[str, int]:
    """How many random scenarios have a collision-free future, and how many collided."""
    hopeless = collided = 0
    for seed in range(count):
        problem, closed = scenario(seed)
        whole = replace(problem, horizon=30, closed=closed)
        if solve(whole, max_states=1, raise_infeasible=False).status == "infeasible":
            hopeless += 1
            continue
        _, met = drive(problem, closed, 30, 0.02)
        collided += met > 0
    free = count - hopeless
    print(
        f"scenarios: {free} with a collision-free future, {collided} of them ended in a collision"
    )
    return {"scenarios": count, "with_a_future": free, "collided": collided}


def main() -> None:
    """Time, then scenarios."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--steps", type=int, default=200)
    parser.add_argument("--scenarios", type=int, default=1000)
    args = parser.parse_args()
    timing(args.runs, args.steps)
    scenarios(args.scenarios)


if __name__ == "__main__":
    main()
