"""Missions that need every body, over many seeds: who arrives, in which modes, who gets up again.

    python benchmarks/multimodal.py [multimodal] [--depot MAP.yaml] [--seeds 20] [--seed 0]
        [--modes crawl,biped,roll] [--json FILE]

Each run is ``mobius run --no-video`` into a folder that is thrown away. ``--depot`` adds the map
depot.yaml (not shipped here) with the two regions of depot_regions.yaml. The bar: 17 of 20 runs
per map end within 0.35 m of the goal, every forced mode is used, every fall recovered.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from mobius import mission
from mobius.errors import MobiusError

REGIONS = Path(__file__).with_name("depot_regions.yaml")
DEPOT_ENDS = {"start": (2.0, 10.0), "goal": (13.0, 10.0)}
BAR = 17 / 20
"""Share of the runs of a map that must arrive."""


def run_seed(name: str, options: dict[str, Any], seed: int) -> dict[str, Any]:
    """Summary of one run; one that ends in an error did not arrive."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            outcome = mission.run(name, Path(folder) / "run", seed=seed, video=False, **options)
        except MobiusError as error:
            return {"seed": seed, "goal_reached": False, "error": str(error)}
    return outcome.summary


def line_of(s: dict[str, Any]) -> str:
    """One run on one line."""
    if "error" in s:
        return f"seed {s['seed']:3d}  ERROR    {s['error']}"
    energy = "  ".join(
        f"{name} {row['J_per_cell']:.0f}" for name, row in s["modes"].items() if row["cells"]
    )
    forced = ", ".join(f"{m} {100 * f['share']:.0f} %" for m, f in s["forced_modes"].items())
    return (
        f"seed {s['seed']:3d}  {'arrived' if s['goal_reached'] else 'FAILED '}"
        f"  {s['final_distance_m']:.2f} m left  {s['sim_time_s']:5.0f} s  {s['ended']:10s}"
        f"  {s['falls']} falls {s['recoveries']} up  {s['rolls']} rolls"
        f"  {len(s['replans'])} new plans  {s['collisions']} collisions"
        f"  {s['mode_switches']['driven_per_step']:.2f} switches/step"
        f"  J/cell: {energy}  forced: {forced}"
    )


def verdict(name: str, rows: list[dict[str, Any]]) -> tuple[bool, str]:
    """Whether a map's runs clear the bar, and a line that says so."""
    arrived = sum(r["goal_reached"] for r in rows)
    ran = [r for r in rows if "error" not in r]
    used = sum(r["forced_modes_used"] for r in ran if r["goal_reached"])
    falls, up = sum(r["falls"] for r in ran), sum(r["recoveries"] for r in ran)
    good = arrived >= BAR * len(rows) and used == arrived and up == falls
    power = [r["energy_per_cell_J"] for r in ran]
    rate = [r["mode_switches"]["driven_per_step"] for r in ran]
    middle = (
        f", median {np.median(power):.0f} J per cell and {np.median(rate):.2f} switches per step"
        if ran
        else ""
    )
    return good, (
        f"{name}: {arrived} of {len(rows)} arrived, {used} of these used every forced mode,"
        f" {up} of {falls} falls recovered{middle}: {'clears' if good else 'MISSES'} the bar"
    )


def main() -> None:
    """Run all maps and seeds."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("maps", nargs="*", default=[])
    parser.add_argument("--depot", type=Path)
    parser.add_argument("--modes", default="crawl,biped,roll")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    maps = args.maps or ([] if args.depot else ["multimodal"])
    jobs: list[tuple[str, dict[str, Any]]] = [(m, {"modes": [args.modes]}) for m in maps]
    if args.depot is not None:
        jobs.append((str(args.depot), {"modes": [args.modes], "regions": REGIONS, **DEPOT_ENDS}))
    results: dict[str, list[dict[str, Any]]] = {}

    for name, options in jobs:
        rows = results.setdefault(name, [])
        for seed in range(args.seed, args.seed + args.seeds):
            rows.append(run_seed(name, options, seed))
            print(f"{Path(name).stem}  {line_of(rows[-1])}", flush=True)
        print(verdict(name, rows)[1], flush=True)
    if args.json is not None:
        args.json.write_text(json.dumps(results, indent=2))


if __name__ == "__main__":
    main()
