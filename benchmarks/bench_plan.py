"""Planner: time to a proven optimum, through the public API only.

    python benchmarks/bench_plan.py [--repeats 50] [--json]

Times are in-process wall times of ``solve`` on one thread, building the bound table
included. The paper's time (10.67 s, Table VI, solver on an unnamed CPU) is for a map that
is not published; ours is a reconstruction, so the ratio is for orientation only.
"""

from __future__ import annotations

import argparse
import json
import platform
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from mobius.plan import (
    RECONSTRUCTED_WEIGHTS,
    Problem,
    build_problem,
    check,
    literal_problem,
    reconstructed_map,
    solve,
)
from mobius.types import GridMap

PAPER_SECONDS = 10.67  # Table VI, all modes, 20 x 20, T = 20


def literal(n: int, T: int) -> Problem:
    return literal_problem(reconstructed_map(n), horizon=T, weights=RECONSTRUCTED_WEIGHTS)


def repaired(n: int, T: int, **options: Any) -> Problem:
    return build_problem(reconstructed_map(n), horizon=T, weights=RECONSTRUCTED_WEIGHTS, **options)


def large(n: int, T: int, *, blocks: int = 60, seed: int = 0) -> Problem:
    """A big map with random blocks of 2 to 6 cells a side."""
    rng = np.random.default_rng(seed)
    blocked = np.zeros((n, n), dtype=bool)
    for _ in range(blocks):
        (x, y), (w, h) = rng.integers(2, n - 8, 2), rng.integers(2, 7, 2)
        blocked[x : x + w, y : y + h] = True
    grid = GridMap("blocks", 0.5, np.zeros(3), blocked, np.full((n, n), 7))
    return Problem(grid, (0, 0), (n - 1, n - 1), T, weights=RECONSTRUCTED_WEIGHTS)


CASES: dict[str, Callable[[], Problem]] = {
    "literal Table IV 20x20 T=20 (reconstructed map)": lambda: literal(20, 20),
    "literal Table IV 10x10 T=10 (reconstructed map)": lambda: literal(10, 10),
    "literal Table IV 20x20 T=40 (reconstructed map)": lambda: literal(20, 40),
    "repaired 20x20 T=20 (reconstructed map)": lambda: repaired(20, 20),
    "repaired 20x20 T=40 (reconstructed map)": lambda: repaired(20, 40),
    "repaired, box steps, 20x20 T=20 (reconstructed map)": lambda: repaired(
        20, 20, connectivity="box"
    ),
    "crawl to the goal 20x20 (reconstructed map)": lambda: build_problem(
        reconstructed_map(), modes=("crawl", "biped"), must_reach=True
    ),
    "repaired 100x100 T=100 (60 random blocks)": lambda: large(100, 100),
}
PAPER_CASE = "literal Table IV 20x20 T=20 (reconstructed map)"


def measure(problem: Problem, repeats: int) -> dict[str, Any]:
    plan = solve(problem)
    check(problem, plan)
    seconds = []
    for _ in range(repeats):
        began = time.perf_counter()
        solve(problem)
        seconds.append(time.perf_counter() - began)
    median, p99 = np.percentile(seconds, [50, 99])
    return {
        "status": plan.status,
        "objective": plan.objective,
        "bound": plan.bound,
        "median_ms": round(1e3 * float(median), 3),
        "p99_ms": round(1e3 * float(p99), 3),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=50, help="solves per case")
    parser.add_argument("--json", action="store_true", help="print one JSON object only")
    args = parser.parse_args()
    rows = {name: measure(make(), args.repeats) for name, make in CASES.items()}
    ratio = PAPER_SECONDS / (1e-3 * rows[PAPER_CASE]["median_ms"])
    if args.json:
        result = {
            "cases": rows,
            "repeats": args.repeats,
            "paper_s": PAPER_SECONDS,
            "ratio_to_paper": round(ratio, 1),
            "ratio_note": "reconstructed map; the paper's map and CPU are not published",
            "python": platform.python_version(),
            "numpy": np.__version__,
            "machine": platform.machine(),
        }
        print(json.dumps(result, indent=1))
        return
    print(f"{'case':54s} {'status':9s} {'objective':>9s} {'bound':>7s} {'median':>9s} {'p99':>9s}")
    for name, r in rows.items():
        print(
            f"{name:54s} {r['status']:9s} {r['objective']:9g} {r['bound']:7g}"
            f" {r['median_ms']:6.1f} ms {r['p99_ms']:6.1f} ms"
        )
    print(
        f"paper: {PAPER_SECONDS} s for 20x20, T = 20; ours / paper = 1 / {ratio:.0f} on a"
        " reconstructed map"
    )


if __name__ == "__main__":
    main()
