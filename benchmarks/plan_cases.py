"""Planner: the twelve cases of 20 x 20 cells, ours beside didppy and SCIP (a part of plan.py)."""

from __future__ import annotations

import time
from collections.abc import Callable
from itertools import product
from typing import Any

import numpy as np

from mobius.errors import MissingDependency, PlanError
from mobius.plan import NoPlan, Problem, check, solve
from mobius.plan.solvers import solver_of
from plan_problems import case

Row = dict[str, Any]

BAR_MS = 15.0
PEERS = ("didp", "scip")
TOL = 1e-6
"""Objectives that differ by less are equal, relative."""


def ours(make: Callable[[], Problem], repeats: int) -> Row:
    """From nothing to a plan, again and again; every plan is the same, one is checked.

    Without a deadline, so that a busy machine makes it slower and proves no less.
    """
    problem = make()
    plan = solve(problem, deadline_s=None)
    check(problem, plan)
    seconds, cpu = [], []
    for _ in range(repeats):
        began, cpu_began = time.perf_counter(), time.process_time()
        solve(make(), deadline_s=None)
        seconds.append(time.perf_counter() - began)
        cpu.append(time.process_time() - cpu_began)
    return {
        "solver": "ours",
        "status": plan.status,
        "objective": plan.objective,
        "bound": plan.bound,
        "median_ms": round(1e3 * float(np.median(seconds)), 3),
        "worst_ms": round(1e3 * max(seconds), 3),
        "median_cpu_ms": round(1e3 * float(np.median(cpu)), 3),
    }


def peer(name: str, problem: Problem, limit_s: float, own: Row) -> Row:
    """How far an independent solver gets within its limit, stating the problem included."""
    row: Row = {"solver": name, "objective": None, "bound": None, "times_ours": None}
    if limit_s <= 0:
        return {**row, "status": "left out"}
    began = time.perf_counter()
    try:
        plan = solver_of(name)(problem, limit_s)
    except MissingDependency as error:
        return {**row, "status": "missing", "note": str(error)}
    except NoPlan:
        status = "infeasible"
    except PlanError as error:
        status, row["note"] = "no plan", str(error)
    else:
        status, row["objective"], row["bound"] = plan.status, plan.objective, plan.bound
    seconds = time.perf_counter() - began
    row |= {"status": status, "seconds": round(seconds, 4)}
    row["times_ours"] = round(1e3 * seconds / own["median_ms"], 1)
    return row


def agrees(own: Row, others: list[Row]) -> bool:
    """Whether no peer has a plan better than our bound, nor a proof that ours does not meet."""
    tol = TOL * max(1.0, abs(own["objective"]))
    found = [r for r in others if r["objective"] is not None]
    return all(r["objective"] <= own["bound"] + tol for r in found) and all(
        own["objective"] <= r["bound"] + tol for r in found
    )


def twelve(limits: dict[str, float], repeats: int) -> Row:
    """The twelve cases, each with its peers; ``limits`` [s] by name."""
    print(f"\n20 x 20, reconstructed map, repaired problem; bar {BAR_MS:g} ms a case, proven")
    print(f"{'T  steps count':20s}{'ours: median  worst    cpu, status, objective':46s}  peers")
    rows = []
    for T, connectivity, count in product((15, 20, 40), ("axis", "box"), ("endpoint", "sweep")):
        own = ours(lambda T=T, a=connectivity, b=count: case(T, a, b), repeats)  # type: ignore[misc]
        problem = case(T, connectivity, count)
        others = [peer(name, problem, limits[name], own) for name in PEERS]
        row = {"T": T, "connectivity": connectivity, "count": count, "ours": own, "peers": others}
        row["agrees"] = agrees(own, others)
        rows.append(row)
        first = (
            f"{T:<3d}{connectivity:5s}{count:12s}{own['median_ms']:8.1f} {own['worst_ms']:6.1f}"
            f" {own['median_cpu_ms']:6.1f} ms {own['status']:9s}{own['objective']:10g}"
        )
        print(f"{first}   {'; '.join(map(_said, others))}", flush=True)
    within = met([r["ours"] for r in rows], BAR_MS)
    for note in sorted({p["note"] for r in rows for p in r["peers"] if p["status"] == "missing"}):
        print(f"left out: {note}")
    if not all(r["agrees"] for r in rows):
        print("DISAGREEMENT: a peer has a better plan, or a lower bound, than ours allows")
    return {"bar_ms": BAR_MS, **within, "rows": rows}


def met(rows: list[Row], bar_ms: float) -> Row:
    """How many are proven within the bar, by wall and by processor time; prints it."""
    proven = [r for r in rows if r["status"] == "optimal"]
    wall, cpu = (sum(r[k] <= bar_ms for r in proven) for k in ("median_ms", "median_cpu_ms"))
    print(f"{wall} of {len(rows)} proven within {bar_ms:g} ms (by processor time {cpu}), medians")
    return {"met": wall, "met_cpu": cpu}


def _said(row: Row) -> str:
    """One peer's result in a few words."""
    name, status = row["solver"], row["status"]
    if status in ("missing", "left out"):
        return f"{name} {status}"
    sign = "" if status in ("optimal", "infeasible") else ">"
    text = f"{name} {sign}{row['seconds']:.2f} s = {sign}{row['times_ours']:g}x, {status}"
    if row["objective"] is None or status == "optimal":
        return text
    return f"{text} {row['objective']:g} of <= {row['bound']:g}"
