"""Replanning among things that move, as a film.

``python -m mobius.reproduce.replanning [--out FILE.gif]``: the reconstructed 20 x 20 map, five
obstacles of one cell that walk to and fro, known from now on; a plan of 20 steps is made anew
for every step. The paper plans once, before the robot moves (Sec. VI); there is nothing printed
to hold this against.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mobius.errors import MobiusError, PlanError
from mobius.plan import (
    RECONSTRUCTED_WEIGHTS,
    NoPlan,
    Planner,
    Problem,
    broken_rule,
    build_problem,
    reconstructed_map,
)
from mobius.reproduce.common import write_out
from mobius.view.replan_film import Moment, write_film

__all__ = ["drive", "scene", "walkers"]

Bools = NDArray[np.bool_]

DEADLINE_S = 0.05
"""For every plan [s]."""


def walkers(rng: np.random.Generator, blocked: Bools, steps: int, count: int = 5) -> Bools:
    """(steps, nx, ny) where obstacles are that walk straight and turn back at walls.

    Args:
        rng: Draws where they begin and which way they walk.
        blocked: (nx, ny) walls.
        steps: How long they are watched.
        count: How many; they pass through one another.
    """
    closed = np.zeros((steps, *blocked.shape), dtype=bool)
    free = np.argwhere(~blocked)
    for _ in range(count):
        at = free[rng.integers(len(free))]
        d = np.array([(1, 0), (-1, 0), (0, 1), (0, -1)])[rng.integers(4)]
        for t in range(steps):
            closed[t, at[0], at[1]] = True
            to = at + d
            if not ((to >= 0) & (to < blocked.shape)).all() or blocked[tuple(to)]:
                d = -d
                to = at + d
            if ((to >= 0) & (to < blocked.shape)).all() and not blocked[tuple(to)]:
                at = to
    return closed


def scene(seed: int, steps: int) -> tuple[Problem, Bools]:
    """The problem, and (steps + 21, 20, 20) what moves on its map.

    Being away from the goal costs a tenth of what it does in Table VI: the robot covers ground
    on its way there.
    """
    weights = replace(RECONSTRUCTED_WEIGHTS, W_goal=RECONSTRUCTED_WEIGHTS.W_goal / 10)
    problem = build_problem(reconstructed_map(), horizon=20, weights=weights, allow_stay=True)
    rng = np.random.default_rng(seed)
    return problem, walkers(rng, problem.grid.blocked, steps + problem.horizon + 1)


def drive(
    problem: Problem, closed: Bools, steps: int, *, deadline_s: float | None = DEADLINE_S
) -> list[Moment]:
    """Plan, make the first step, plan again.

    Args:
        problem: Where the robot begins; its horizon recedes.
        closed: (K, nx, ny) what moves, from now on.
        steps: Plans made, >= 1.
        deadline_s: Wall time of every search [s].

    Returns:
        A moment for every plan.

    Raises:
        PlanError: The robot met something, or no way was left at some step.
    """
    truth = replace(problem, closed=closed)
    planner = Planner(problem, keep_horizon=True)
    trail, moments = [problem.start], []
    for t in range(steps):
        planner.update(closed=closed[t:])
        try:
            plan = planner.plan(deadline_s)
        except NoPlan as error:
            raise PlanError(f"step {t}: {error}") from None
        seen = np.zeros(problem.grid.shape, bool)
        if planner.problem.seen is not None:
            seen |= planner.problem.seen
        seen[trail[-1]] = True
        moments.append(Moment(plan, np.array(trail), seen, closed[t]))
        to = (int(plan.cells[1][0]), int(plan.cells[1][1]))
        if (wrong := broken_rule(truth, trail[-1], to, plan.modes[0], t)) is not None:
            raise PlanError(f"step {t}: {wrong}")
        planner.update(at=to)
        trail.append(to)
    return moments


def main() -> None:
    """Drive, tell how long the plans took, and write the film."""
    parser = argparse.ArgumentParser(
        prog="python -m mobius.reproduce.replanning", description="replanning as a film"
    )
    parser.add_argument("--out", type=Path, default=Path("replanning.gif"), help=".gif or .mp4")
    parser.add_argument("--steps", type=int, default=40, help="plans made")
    parser.add_argument("--seed", type=int, default=0, help="where the obstacles begin")
    parser.add_argument("--fps", type=float, default=4.0, help="steps per second of the film")
    options = parser.parse_args()
    if options.steps < 1:
        sys.exit(f"replanning: --steps: expected a whole number >= 1, got {options.steps}")
    if options.seed < 0:
        sys.exit(f"replanning: --seed: expected a whole number >= 0, got {options.seed}")
    problem, closed = scene(options.seed, options.steps)
    try:
        moments = drive(problem, closed, options.steps)
    except MobiusError as error:
        sys.exit(f"replanning: {error}; take another --seed")
    ms = [1e3 * m.plan.solve_s for m in moments]
    print(
        f"{len(moments)} plans: median {np.median(ms):.1f} ms, longest {max(ms):.1f} ms; nothing"
        f" was met, {int(moments[-1].seen.sum())} cells covered"
    )

    def write() -> None:
        write_film(options.out, problem, moments, fps=options.fps)

    write_out("replanning", write, options.out)


if __name__ == "__main__":
    main()
