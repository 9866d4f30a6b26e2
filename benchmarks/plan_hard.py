"""Planner: the hard family, ours beside didppy at equal time.

    python benchmarks/plan_hard.py [--maps 100] [--deadline 5] [--first 0] [--out FILE]
                                   [--no-peer]

Saturated 8 x 8 maps (T = 40: about as many steps as cells), combs, rooms and 25-30 % random
20 x 20 maps (T = 40-60), half of each class with ``sweep``, half with ``endpoint`` counting.
Map number n is the same whatever ``--maps`` says. Both solvers get ``--deadline`` seconds of
wall time per map on one thread, one after the other; on a machine that has other things to do
both get less done. didppy needs the extra ``exact``.
"""

from __future__ import annotations

import argparse
import time
from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mobius.errors import PlanError
from mobius.files import write_json_atomic
from mobius.plan import RECONSTRUCTED_WEIGHTS, Problem, check, solve
from mobius.plan.solvers import solver_of
from mobius.types import GridMap, Plan

KINDS = ("saturated", "saturated", "comb", "rooms", "random")
UNLIMITED = 10**12
"""Search states: only the deadline stops the search."""

Blocked = NDArray[np.bool_]


def saturated(rng: np.random.Generator) -> tuple[Blocked, int]:
    """8 x 8 cells, 0-20 % blocked, T = 40."""
    return rng.random((8, 8)) < rng.uniform(0.0, 0.2), 40


def comb(rng: np.random.Generator) -> tuple[Blocked, int]:
    """15 x 15 cells, corridors one cell wide that hang together in one or two places."""
    blocked = np.zeros((15, 15), dtype=bool)
    for i in range(1, 15, 2):
        blocked[i] = True
        blocked[i, rng.choice([0, 7, 14], size=rng.integers(1, 3), replace=False)] = False
    return blocked, int(rng.integers(40, 61))


def rooms(rng: np.random.Generator) -> tuple[Blocked, int]:
    """20 x 20 cells, nine rooms with a door in every wall between two."""
    blocked = np.zeros((20, 20), dtype=bool)
    for wall in (6, 13):
        blocked[wall, :] = blocked[:, wall] = True
    for wall in (6, 13):
        for room in (0, 7, 14):
            i, j = room + rng.integers(0, 6, size=2)
            blocked[wall, i] = blocked[j, wall] = False
    return blocked, int(rng.integers(40, 61))


def scattered(rng: np.random.Generator) -> tuple[Blocked, int]:
    """20 x 20 cells, 25-30 % of them blocked at random."""
    return rng.random((20, 20)) < rng.uniform(0.25, 0.3), int(rng.integers(40, 61))


MAKERS = {"saturated": saturated, "comb": comb, "rooms": rooms, "random": scattered}


def connected(blocked: Blocked) -> Blocked:
    """The map with all but its largest area filled up."""
    label = np.arange(1, blocked.size + 1).reshape(blocked.shape) * ~blocked
    while True:
        near = np.pad(label, 1)
        spread = np.max(
            [label, near[2:, 1:-1], near[:-2, 1:-1], near[1:-1, 2:], near[1:-1, :-2]], axis=0
        )
        spread[blocked] = 0
        if (spread == label).all():
            break
        label = spread
    numbers, sizes = np.unique(label[label > 0], return_counts=True)
    return label != numbers[np.argmax(sizes)]


def hard_problem(n: int) -> tuple[str, Problem]:
    """Class and problem number n of the family."""
    rng = np.random.default_rng([n, 2511])
    kind = KINDS[n // 2 % len(KINDS)]
    blocked, T = MAKERS[kind](rng)
    blocked = connected(blocked)
    free = np.argwhere(~blocked)
    count = ("sweep", "endpoint")[n % 2]
    grid = GridMap(f"{kind} {n}", 0.5, np.zeros(3), blocked, np.full(blocked.shape, 7))
    problem = Problem(
        grid, tuple(free[0]), tuple(free[-1]), T, weights=RECONSTRUCTED_WEIGHTS, count=count
    )
    return f"{kind}, {count}", problem


def ours(problem: Problem, deadline_s: float) -> Plan:
    return solve(problem, deadline_s=deadline_s, max_states=UNLIMITED)


def run(problem: Problem, solver: Any, deadline_s: float) -> dict[str, Any]:
    """One solver on one problem."""
    wall, cpu = time.perf_counter(), time.process_time()
    try:
        plan = solver(problem, deadline_s)
    except PlanError:  # nothing found by the deadline
        return {
            "status": "none",
            "objective": None,
            "bound": None,
            "gap": 1.0,
            "wall_s": deadline_s,
        }
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    check(problem, plan)
    return {
        "status": plan.status,
        "objective": plan.objective,
        "bound": plan.bound,
        "gap": (plan.bound - plan.objective) / max(abs(plan.bound), 1e-9),
        "wall_s": round(wall, 3),
        "cpu_s": round(cpu, 3),
    }


def table(rows: list[dict[str, Any]], solvers: list[str]) -> str:
    """What the rows come to, per class and in all."""
    classes = defaultdict(list)
    for row in rows:
        classes[row["class"]].append(row)
    classes["all"] = rows
    lines = [
        f"{'class':22s} {'solver':6s} {'n':>4s} {'proven':>7s} {'median gap':>11s}"
        f" {'max gap':>8s} {'median s':>9s}"
    ]
    for name, some in classes.items():
        for solver in solvers:
            got = [row[solver] for row in some]
            gaps, seconds = [g["gap"] for g in got], [g["wall_s"] for g in got]
            proven = sum(g["status"] == "optimal" for g in got)
            lines.append(
                f"{name:22s} {solver:6s} {len(got):4d} {proven:7d} {100 * np.median(gaps):9.2f} %"
                f" {100 * max(gaps):6.2f} % {np.median(seconds):9.2f}"
            )
    if "didp" in solvers:
        pairs = [(r["ours"]["objective"], r["didp"]["objective"], r["class"]) for r in rows]
        worse = [c for a, b, c in pairs if b is not None and a < b - 1e-6]
        better = sum(b is None or a > b + 1e-6 for a, b, _ in pairs)
        lines.append(f"ours better than didp on {better}, worse on {len(worse)} {worse or ''}")
    return "\n".join(lines)


def compare(
    numbers: Iterable[int], deadline_s: float, *, peer: bool, out: Path | None = None
) -> list[dict[str, Any]]:
    """Maps of some numbers, ours and (``peer``) didppy; prints each and the table of all."""
    solvers = {"ours": ours, "didp": solver_of("didp")} if peer else {"ours": ours}
    rows = []
    for n in numbers:
        kind, problem = hard_problem(n)
        row: dict[str, Any] = {"map": n, "class": kind, "T": problem.horizon}
        for name, solver in solvers.items():
            row[name] = run(problem, solver, deadline_s)
        rows.append(row)
        told = "; ".join(
            f"{s} {row[s]['status']} {row[s]['objective']} of {row[s]['bound']}"
            f" in {row[s]['wall_s']} s ({row[s].get('cpu_s')} s cpu)"
            for s in solvers
        )
        print(f"map {n} {kind} T={problem.horizon}: {told}", flush=True)
        if out:
            write_json_atomic(out, {"deadline_s": deadline_s, "rows": rows})
    print(table(rows, list(solvers)))
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--maps", type=int, default=100, help="how many")
    parser.add_argument("--first", type=int, default=0, help="number of the first map")
    parser.add_argument("--step", type=int, default=1, help="take every n-th map only")
    parser.add_argument("--deadline", type=float, default=5.0, help="per solver and map [s]")
    parser.add_argument("--no-peer", action="store_true", help="leave didppy out")
    parser.add_argument("--out", type=Path, help="file for the rows as JSON")
    args = parser.parse_args()
    numbers = range(args.first, args.first + args.maps * args.step, args.step)
    compare(numbers, args.deadline, peer=not args.no_peer, out=args.out)


if __name__ == "__main__":
    main()
