"""Planner: the bars, with the peers in the same run, through the public API only.

    python benchmarks/plan.py                                # everything, small counts
    python benchmarks/plan.py cases large --scip-s 60 --didp-s 60 --out plan.json

cases      20 x 20 cells, T = 15, 20, 40, axis and box, endpoint and sweep: ours, didppy, SCIP on
           the repaired Table IV; a peer that is not done by its limit shows how far it got
printed    Table IV as printed (signs repaired) beside the paper's 10.67 s, ours alone
large      100 x 100 cells with random blocks, T = 100, sweep, then 300 x 300 and, with
           --map-folder, real maps (plan_large.py), ours alone
hard       saturated maps, combs, rooms and random blocks beside didppy at equal time
           (plan_hard.py with small counts)
agreement  ours, didppy and brute force on small maps, ours and SCIP on the printed table
           (plan_agreement.py with small counts)
replan     10 Hz among things that move (plan_replan.py with small counts)

Ours is the median and the worst of several in-process wall times from nothing to a plan: the
map, the problem and the bound table included. The median of processor time stands beside it: it
says more where other jobs take the cores. One thread everywhere. The paper's map and CPU are not
published; ours is a reconstruction, so that ratio is for orientation only.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import platform
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np

from mobius.errors import MissingDependency
from mobius.files import write_json_atomic
from plan_cases import met, ours, twelve
from plan_problems import blocks, printed, to_the_goal

Row = dict[str, Any]

PAPER_SECONDS = 10.67
"""Table VI, all modes, 20 x 20, T = 20."""
LARGE_BAR_MS, REPLAN_BAR_MS = 250.0, 50.0
HARD_STEP = 3
"""Every third hard map: ten of them hold every class with both countings."""


def run_cases(args: argparse.Namespace) -> Row:
    """The twelve cases, each with its peers."""
    return twelve({"didp": args.didp_s, "scip": args.scip_s}, args.repeats)


def run_printed(args: argparse.Namespace) -> Row:
    """The printed table and the shortest way, ours alone."""
    makers = {
        "Table IV as printed, 20 x 20, T = 20": lambda: printed(20, 20),
        "Table IV as printed, 20 x 20, T = 40": lambda: printed(20, 40),
        "Table IV as printed, 10 x 10, T = 10": lambda: printed(10, 10),
        "shortest way to the goal, 20 x 20": to_the_goal,
    }
    print("\nreconstructed map, ours alone")
    rows = {name: ours(make, args.repeats) for name, make in makers.items()}
    for name, r in rows.items():
        _tell(name, r)
    ratio = PAPER_SECONDS / (1e-3 * next(iter(rows.values()))["median_ms"])
    print(f"paper: {PAPER_SECONDS} s for 20 x 20, T = 20 (another map, another CPU): {ratio:.0f}x")
    return {"rows": rows, "paper_s": PAPER_SECONDS, "paper_times_ours": round(ratio, 1)}


def run_large(args: argparse.Namespace) -> Row:
    """Large maps with random blocks, ours alone."""
    print(f"\n100 x 100, T = 100, 60 random blocks, sweep; bar {LARGE_BAR_MS:g} ms, proven")
    rows = []
    for seed in range(args.large_maps):
        row = ours(lambda seed=seed: blocks(seed=seed), max(1, args.repeats // 4))  # type: ignore[misc]
        rows.append({"seed": seed, **row})
        _tell(f"map {seed}", row)
    result = {"bar_ms": LARGE_BAR_MS, **met(rows, LARGE_BAR_MS), "rows": rows}
    import plan_large as other

    print("\n300 x 300, T = 300; bar 3 s, gap 10 %; real maps: 2 s, 2 %")
    print(other.head())
    result["drawn"] = other.drawn_rows(2.5, "300")
    if args.map_folder is not None:
        result["real"] = other.real_rows(args.map_folder, other.WIDE.radius, 2.0)
    return result


def run_hard(args: argparse.Namespace) -> Row:
    """Some of plan_hard.py's maps, spread over its classes."""
    import plan_hard as other

    peer = args.didp_s > 0 and _installed("didppy")
    print(f"\nhard maps, 5 s each{'' if peer else ', without didppy'}; bar median gap 0.5 %")
    numbers = range(0, HARD_STEP * args.hard_maps, HARD_STEP)
    return {"deadline_s": 5.0, "rows": other.compare(numbers, 5.0, peer=peer)}


def _tell(name: str, r: Row) -> None:
    times = f"{r['median_ms']:8.1f} {r['worst_ms']:6.1f} {r['median_cpu_ms']:6.1f} ms"
    print(
        f"{name:38s}{times} {r['status']:9s}{r['objective']:10g} of <= {r['bound']:g}", flush=True
    )


def run_agreement(args: argparse.Namespace) -> Row:
    """A few of plan_agreement.py's maps."""
    import plan_agreement as other

    result: Row = {"maps": args.maps, "printed_maps": args.printed_maps}
    for name, extra, make, judge, n in (
        ("didppy", "exact", other.any_problem, other.small_maps, args.maps),
        ("pyscipopt", "baseline", other.printed_problem, other.printed_maps, args.printed_maps),
    ):
        if not _installed(name):
            print(f"left out: {MissingDependency(name, extra, 'this comparison')}")
            result[f"{name}_disagreements"] = None
            continue
        result[f"{name}_disagreements"] = judge(other.drawn(make, n), 60.0)
    return result


def _installed(package: str) -> bool:
    from importlib.util import find_spec

    return find_spec(package) is not None


def run_replan(args: argparse.Namespace) -> Row:
    """A few of plan_replan.py's runs and scenarios."""
    import plan_replan as other

    print(f"\nreplanning; bar p99 {REPLAN_BAR_MS:g} ms, no collision")
    result = other.timing(args.runs, args.steps) | other.scenarios(args.scenarios)
    return {"bar_ms": REPLAN_BAR_MS, **result}


SECTIONS: dict[str, Callable[[argparse.Namespace], Row]] = {
    "cases": run_cases,
    "printed": run_printed,
    "large": run_large,
    "hard": run_hard,
    "agreement": run_agreement,
    "replan": run_replan,
}


def parsed(argv: list[str] | None = None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("sections", nargs="*", help=f"{', '.join(SECTIONS)}; all if none")
    parser.add_argument("--repeats", type=int, default=21, help="timed solves a case, >= 1")
    parser.add_argument("--scip-s", type=float, default=60.0, help="SCIP's limit [s]; 0: without")
    parser.add_argument("--didp-s", type=float, default=60.0, help="didppy's; 0: without")
    parser.add_argument("--large-maps", type=int, default=5, help="maps of 100 x 100")
    parser.add_argument("--map-folder", type=Path, help="large: folder of Nav2 yaml files")
    parser.add_argument("--hard-maps", type=int, default=10, help="hard: maps of the family")
    parser.add_argument("--maps", type=int, default=25, help="agreement: small maps")
    parser.add_argument("--printed-maps", type=int, default=5, help="agreement: printed tables")
    parser.add_argument("--runs", type=int, default=1, help="replan: drives")
    parser.add_argument("--steps", type=int, default=100, help="replan: steps of a drive")
    parser.add_argument("--scenarios", type=int, default=25, help="replan: random scenarios")
    parser.add_argument("--json", action="store_true", help="print one JSON object, no tables")
    parser.add_argument("--out", type=Path, help="also write the JSON to this file")
    args = parser.parse_args(argv)
    unknown = [s for s in args.sections if s not in SECTIONS]
    if unknown:
        parser.error(f"unknown section '{unknown[0]}'; known: {', '.join(SECTIONS)}")
    if args.out is not None and args.out.is_dir():
        parser.error(f"--out: {args.out} is a folder; name a file in it")
    counts = ("repeats", "large_maps", "hard_maps", "runs", "steps")
    if any(getattr(args, name) < 1 for name in counts):
        names = ", ".join(f"--{name.replace('_', '-')}" for name in counts)
        parser.error(f"{names}: expected a whole number >= 1")
    if not (args.scip_s >= 0 and args.didp_s >= 0):
        parser.error("--scip-s, --didp-s: expected seconds >= 0")
    return args


@contextlib.contextmanager
def quiet(yes: bool) -> Iterator[None]:
    """Tables to standard error, so that standard output is one JSON object."""
    with contextlib.redirect_stdout(sys.stderr) if yes else contextlib.nullcontext():
        yield


def main(argv: list[str] | None = None) -> None:
    args = parsed(argv)
    result: Row = {
        "threads": 1,
        "cpu": _cpu(),
        "load_before": round(os.getloadavg()[0], 2) if hasattr(os, "getloadavg") else None,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "limits_s": {"didp": args.didp_s, "scip": args.scip_s},
    }
    with quiet(args.json):
        print(f"one thread; {result['cpu']}, load {result['load_before']} before")
        for name in args.sections or SECTIONS:
            result[name] = SECTIONS[name](args)
    if args.json:
        print(json.dumps(result, indent=1))
    if args.out is not None:
        write_json_atomic(args.out, result)


def _cpu() -> str:
    """The processor's name where the system tells it."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


if __name__ == "__main__":
    main()
