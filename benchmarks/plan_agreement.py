"""Planner: do independent solvers find the same optimum? Exit code 1 if any does not.

    python benchmarks/plan_agreement.py [--maps 500] [--literal 20] [--seed 0]

Random maps up to 6 x 6 cells, T <= 8, every option of a problem drawn at random: our exact
search, didppy, and every path by brute force where there are few enough. Then maps up to
8 x 8 cells with discs and rectangles: our search and Table IV as printed, on SCIP. Needs the
extras ``exact`` and ``baseline``. Map number n is the same whatever ``--maps`` says.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from functools import partial

import numpy as np

from mobius.errors import PlanError
from mobius.plan import NoPlan, Problem, Weights, literal_problem
from mobius.plan.solvers import Solver, solver_of
from mobius.plan.solvers.brute import MAX_PATHS, number_of_paths
from mobius.plan.solvers.scip import scip
from mobius.types import GridMap, Mode

TOL = 1e-6
"""Objectives that differ by less are equal, relative."""


class Tally:
    """How one solver fared."""

    def __init__(self) -> None:
        self.solved = self.no_plan = self.too_large = self.unproven = 0
        self.seconds: list[float] = []


def any_problem(rng: np.random.Generator) -> Problem:
    """Up to 6 x 6 cells, T <= 8, all options at random."""
    nx, ny = (int(v) for v in rng.integers(1, 7, size=2))
    blocked = rng.random((nx, ny)) < rng.choice([0.0, 0.2, 0.35])
    some = rng.random((nx, ny)) < rng.choice([0.0, 0.3])
    allowed = np.where(some, rng.integers(0, 8, (nx, ny)), 7)
    start, goal = (tuple(int(v) for v in rng.integers(0, (nx, ny))) for _ in range(2))
    blocked[start] = blocked[goal] = False
    modes = rng.permutation([m.value for m in (Mode.BIPED, Mode.CRAWL, Mode.ROLL)])
    whole = bool(rng.integers(2))
    return Problem(
        GridMap("random", 0.5, np.zeros(3), blocked, allowed),
        start,
        goal,
        int(rng.integers(0, 9)),
        modes=tuple(modes[: rng.integers(1, 4)].tolist()),
        weights=Weights(
            W_exp=float(rng.choice([0, 1, 20])),
            W_goal=float(rng.choice([0, 1, 20])),
            P={m: float(rng.integers(0, 12)) / (1 if whole else 7) for m in modes.tolist()},
        ),
        connectivity=str(rng.choice(["axis", "axis", "box", "diagonal"])),
        count=str(rng.choice(["sweep", "endpoint"])),
        check=str(rng.choice(["swept", "endpoint"])),
        count_terminal=bool(rng.integers(2)),
        allow_stay=bool(rng.integers(2)),
        must_reach=bool(rng.integers(2)),
        early_stop=bool(rng.integers(2)),
        cell_cost=rng.integers(0, 40, (nx, ny)) / 8 if rng.integers(2) else None,
    )


def printed_problem(rng: np.random.Generator) -> Problem:
    """Up to 8 x 8 cells, T <= 6, with the table's discs and rectangles."""
    nx, ny = (int(v) for v in rng.integers(4, 9, size=2))
    i, j = np.indices((nx, ny))
    allowed, blocked = np.full((nx, ny), 7), np.zeros((nx, ny), dtype=bool)
    for mode in (Mode.CRAWL, Mode.BIPED):
        cx, cy = rng.integers(0, (nx, ny))
        inside = (i - cx) ** 2 + (j - cy) ** 2 <= float(rng.choice([0.0, 1.0, 2.0, 4.0]))
        allowed[inside & (allowed == 7)] = mode.bit
    x, y = (int(v) for v in rng.integers(1, (nx - 1, ny - 1)))
    w, h = (int(v) for v in rng.integers(1, 3, size=2))
    blocked[x : x + w, y : y + h] = True
    blocked[0, 0] = blocked[-1, -1] = False
    grid = GridMap("printed", 0.5, np.zeros(3), blocked, allowed)
    corners = grid.center_of([[0, 0], [nx - 1, ny - 1]])
    grid = GridMap("printed", 0.5, np.zeros(3), blocked, allowed, corners[0], corners[1])
    return literal_problem(
        grid,
        horizon=int(rng.integers(2, 7)),
        weights=Weights(P={Mode.BIPED: 2.0, Mode.CRAWL: 1.0, Mode.ROLL: 4.0}),
        connectivity=str(rng.choice(["axis", "box", "diagonal"])),
    )


def answer(solver: Solver, problem: Problem, tally: Tally, deadline: float | None) -> float | None:
    """The optimum, -inf where there is no plan, ``None`` where it is not proven."""
    began = time.perf_counter()
    try:
        plan = solver(problem, deadline)
    except NoPlan:
        value: float | None = -np.inf
        tally.no_plan += 1
    except PlanError:
        value = None
        tally.unproven += 1
    else:
        value = plan.objective if plan.status == "optimal" else None
        tally.solved += value is not None
        tally.unproven += value is None
    tally.seconds.append(time.perf_counter() - began)
    return value


def compare(
    title: str,
    problems: list[Problem],
    solvers: dict[str, Solver],
    deadline: float | None,
    skip: Callable[[str, Problem], bool] = lambda name, problem: False,
) -> int:
    """Solve all problems with all solvers and print a table; how many disagree."""
    if not problems:
        return 0
    tallies = {name: Tally() for name in solvers}
    bad = 0
    for n, problem in enumerate(problems):
        values = {}
        for name, solver in solvers.items():
            if skip(name, problem):
                tallies[name].too_large += 1
            else:
                values[name] = answer(solver, problem, tallies[name], deadline)
        proven = [v for v in values.values() if v is not None]
        agree = len(proven) == len(values) and np.allclose(proven, proven[0], rtol=TOL, atol=TOL)
        if not agree:
            bad += 1
            print(f"map {n}: {values}\n{problem}", flush=True)
    print(f"\n{title}: {len(problems)} maps, {bad} disagreements")
    print(f"{'solver':14s} {'optimal':>8s} {'no plan':>8s} {'unproven':>9s} {'too large':>10s}")
    for name, t in tallies.items():
        print(
            f"{name:14s} {t.solved:8d} {t.no_plan:8d} {t.unproven:9d} {t.too_large:10d}"
            f"   median {1e3 * np.median(t.seconds or [0]):.1f} ms, total {sum(t.seconds):.1f} s"
        )
    return bad


def drawn(
    make: Callable[[np.random.Generator], Problem], n: int, *, seed: int = 0, first: int = 0
) -> list[Problem]:
    """Maps number ``first`` to ``first + n - 1``."""
    return [make(np.random.default_rng((seed, k))) for k in range(first, first + n)]


def small_maps(problems: list[Problem], deadline: float, *, paths: int = MAX_PATHS) -> int:
    """Ours, didppy and brute force on small maps with all options; how many disagree."""
    return compare(
        f"all options, up to 6 x 6, T <= 8; brute force up to {paths} paths",
        problems,
        {name: solver_of(name) for name in ("exact", "didp", "brute")},
        deadline,
        skip=lambda name, p: name == "brute" and number_of_paths(p) > paths,
    )


def printed_maps(problems: list[Problem], deadline: float) -> int:
    """Ours and Table IV as printed on SCIP; how many disagree."""
    return compare(
        "Table IV as printed, up to 8 x 8, T <= 6",
        problems,
        {"exact": solver_of("exact"), "scip literal": partial(scip, reading="literal")},
        deadline,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--maps", type=int, default=500, help="small maps, all options")
    parser.add_argument("--literal", type=int, default=20, help="maps for Table IV as printed")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--first", type=int, default=0, help="number of the first map")
    parser.add_argument("--paths", type=int, default=MAX_PATHS, help="most paths for brute force")
    parser.add_argument("--deadline", type=float, default=60.0, help="per solver and map [s]")
    args = parser.parse_args()

    which = {"seed": args.seed, "first": args.first}
    bad = small_maps(drawn(any_problem, args.maps, **which), args.deadline, paths=args.paths)
    bad += printed_maps(drawn(printed_problem, args.literal, **which), args.deadline)
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
