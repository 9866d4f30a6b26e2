"""Planner: large maps, long horizons, real maps. How good is the plan, and what is proven?

    python benchmarks/plan_large.py [--deadline 2.5] [--maps DIR] [--radius 0.41] [--only WORD]

Drawn maps first: random blocks, rooms with doors, 25 % single obstacles at random, with the
goal in the far corner or at the start ("home"). Then every Nav2 yaml of a folder (by default
the shipped maps) in 0.5 m cells, for a disc of the given radius, from one end of its largest
open region to the other and home again. Times are of one call on one thread, from the map's
array to the plan, the bound table included; CPU time stands beside wall time because
other work on the machine only adds to the latter. Every plan is checked.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable, Iterator
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mobius.mission import WIDE
from mobius.plan import RECONSTRUCTED_WEIGHTS, NoPlan, Problem, check, solve
from mobius.plan.bounds import UNREACHED, build_arcs, steps_from
from mobius.types import GridMap
from mobius.world import load_world, map_names

Blocked = NDArray[np.bool_]
Cell = tuple[int, int]
Tell = Callable[[dict[str, Any]], object]


def blocks(n: int, number: int, seed: int = 0) -> Blocked:
    """Blocks of 2 to 6 cells a side."""
    rng = np.random.default_rng(seed)
    blocked = np.zeros((n, n), dtype=bool)
    for _ in range(number):
        (x, y), (w, h) = rng.integers(2, n - 8, 2), rng.integers(2, 7, 2)
        blocked[x : x + w, y : y + h] = True
    return blocked


def rooms(n: int, room: int = 12, seed: int = 0) -> Blocked:
    """Square rooms; every wall between two rooms has one door, a cell wide."""
    rng = np.random.default_rng(seed)
    blocked = np.zeros((n, n), dtype=bool)
    walls = range(room, n - 1, room + 1)
    blocked[list(walls), :] = True
    blocked[:, list(walls)] = True
    for wall, side in product(walls, range(0, n, room + 1)):
        last = min(side + room, n) - 1
        blocked[wall, rng.integers(side, last + 1)] = False
        blocked[rng.integers(side, last + 1), wall] = False
    return blocked


def scattered(n: int, share: float = 0.25, seed: int = 0) -> Blocked:
    """Single cells at random; the corners are free."""
    blocked = np.random.default_rng(seed).random((n, n)) < share
    blocked[:4, :4] = blocked[-4:, -4:] = False
    return blocked


def on_array(name: str, blocked: Blocked, T: int, goal: Cell | None = None, **rest: Any) -> Problem:
    """From the corner (0, 0) to the far corner, or to ``goal``."""
    nx, ny = blocked.shape
    grid = GridMap(name, 0.5, np.zeros(3), blocked, np.full((nx, ny), 7))
    return Problem(grid, (0, 0), goal or (nx - 1, ny - 1), T, weights=RECONSTRUCTED_WEIGHTS, **rest)


def drawn() -> Iterator[tuple[str, Blocked, int, dict[str, Any]]]:
    """Name, map, horizon and options of every drawn case."""
    yield "100 blocks, sweep", blocks(100, 60), 100, {}
    shapes = (("blocks", blocks(300, 500)), ("rooms", rooms(300)), ("25 %", scattered(300)))
    for (name, blocked), home, count in product(shapes, (False, True), ("sweep", "endpoint")):
        options: dict[str, Any] = {"count": count}
        if home:
            options["goal"] = (0, 0)
        yield f"300 {name}, {count}{', home' if home else ''}", blocked, 300, options


def ends(grid: GridMap) -> tuple[Cell, Cell]:
    """Two cells far apart (in steps) in the largest region of a map."""
    best, far, tried = 0, ((0, 0), (0, 0)), np.array(grid.blocked)
    while not tried.all():
        cell: Cell = tuple(int(v) for v in np.argwhere(~tried)[0])
        for _ in range(2):  # the second time from the farthest cell of the first
            problem = Problem(grid, cell, cell, 0)
            arcs = build_arcs(problem)
            steps = steps_from(problem, arcs)
            reached = np.flatnonzero(steps < UNREACHED)
            first, cell = cell, arcs.cell(int(reached[np.argmax(steps[reached])]))
        for flat in reached:
            tried[arcs.cell(int(flat))] = True
        if len(reached) > best:
            best, far = len(reached), (first, cell)
    return far


def real(sources: list[str], radius: float) -> Iterator[tuple[str, Problem]]:
    """Problems on map files."""
    lane = WIDE.lane if radius >= WIDE.lane else None
    for source in sources:
        grid = load_world(source, radius=radius, margin=WIDE.margin, lane=lane, cell=0.5).grid
        here, there = ends(grid)
        for T, count, goal in product((60, 100, 200), ("sweep", "endpoint"), (there, here)):
            for reach in (False, True):
                name = f"{Path(source).stem} T={T} {count}{', home' if goal == here else ''}"
                yield (
                    name + (", reach" if reach else ""),
                    Problem(
                        grid, here, goal, T,
                        weights=RECONSTRUCTED_WEIGHTS, count=count, must_reach=reach,
                    ),
                )  # fmt: skip


def measure(name: str, problem: Problem, deadline: float, built_s: float = 0.0) -> dict[str, Any]:
    """One solve, checked."""
    wall, cpu = time.perf_counter(), time.process_time()
    row: dict[str, Any] = {"case": name, "cells": int((~problem.grid.blocked).sum())}
    row["T"] = problem.horizon
    try:
        plan = solve(problem, deadline_s=deadline)
    except NoPlan as error:
        return row | {"status": "infeasible", "why": str(error)}
    row["wall_s"] = round(built_s + time.perf_counter() - wall, 3)
    row["cpu_s"] = round(built_s + time.process_time() - cpu, 3)
    check(problem, plan)
    gap = plan.gap / max(abs(plan.bound), 1e-9)
    return row | {
        "objective": plan.objective,
        "bound": plan.bound,
        "gap": round(gap, 5),
        "status": plan.status,
    }


def show(row: dict[str, Any]) -> None:
    if row["status"] == "infeasible":
        print(f"{row['case']:44s} {row['cells']:6d} {row['T']:4d}  {row['why']}")
        return
    print(
        f"{row['case']:44s} {row['cells']:6d} {row['T']:4d} {row['wall_s']:7.2f} s"
        f" {row['cpu_s']:7.2f} s {row['objective']:9g} {row['bound']:9g} {row['gap']:7.2%}"
        f" {row['status']}",
        flush=True,
    )


def drawn_rows(deadline: float, only: str = "", tell: Tell = show) -> list[dict[str, Any]]:
    """The drawn maps whose name holds a word, each told as it is done."""
    rows = []
    for name, blocked, T, options in drawn():
        if only in name:
            began = time.perf_counter()
            problem = on_array(name, blocked, T, **options)
            rows.append(measure(name, problem, deadline, time.perf_counter() - began))
            tell(rows[-1])
    return rows


def real_rows(
    folder: Path | None, radius: float, deadline: float, only: str = "", tell: Tell = show
) -> list[dict[str, Any]]:
    """The Nav2 maps of a folder (``None``: the shipped ones), each told as it is done."""
    sources = map_names() if folder is None else sorted(str(p) for p in folder.glob("*.yaml"))
    rows = []
    for name, problem in real(sources, radius):
        if only in name:
            rows.append(measure(name, problem, deadline))
            tell(rows[-1])
    return rows


def head() -> str:
    """The line above the table."""
    return (
        f"{'case':44s} {'cells':>6s} {'T':>4s} {'wall':>9s} {'CPU':>9s} {'objective':>9s}"
        f" {'bound':>9s} {'gap':>7s} status"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--deadline", type=float, default=2.5, help="for the 300 x 300 maps [s]")
    parser.add_argument("--map-deadline", type=float, default=2.0, help="for the other maps [s]")
    parser.add_argument("--maps", type=Path, help="folder of Nav2 yaml files; shipped ones if not")
    parser.add_argument("--radius", type=float, default=WIDE.radius, help="of the robot [m]")
    parser.add_argument("--only", default="", help="cases whose name holds this word")
    parser.add_argument("--json", action="store_true", help="print one JSON list only")
    args = parser.parse_args()
    tell: Tell = show
    if args.json:
        tell = list[dict[str, Any]]().append  # nobody is told
    else:
        print(head())
    rows = drawn_rows(args.deadline, args.only, tell)
    rows += real_rows(args.maps, args.radius, args.map_deadline, args.only, tell)
    if args.json:
        print(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
