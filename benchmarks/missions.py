"""Whole missions over many seeds: how often the robot arrives, how fast the run is.

    python benchmarks/missions.py MAP X0 Y0 X1 Y1 [--seeds 10] [--seed 0] [--policy rough]
                                  [--json FILE]

Each run is ``mobius run --no-video`` into a folder that is thrown away, with friction, mass,
delay and sensor drift drawn from its seed.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from mobius import mission


def run_seed(args: argparse.Namespace, seed: int) -> dict[str, Any]:
    """Summary of one run."""
    with tempfile.TemporaryDirectory() as folder:
        outcome = mission.run(
            args.map,
            Path(folder) / "run",
            start=(args.x0, args.y0),
            goal=(args.x1, args.y1),
            seed=seed,
            policy=args.policy,
            video=False,
        )
    return outcome.summary


def main() -> None:
    """Run all seeds and print a line each and a line for all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("map")
    for name in ("x0", "y0", "x1", "y1"):
        parser.add_argument(name, type=float)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--policy")
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    rows = []
    for seed in range(args.seed, args.seed + args.seeds):
        s = run_seed(args, seed)
        rows.append(s)
        print(
            f"seed {seed:3d}  {'arrived' if s['goal_reached'] else 'FAILED '}"
            f"  {s['final_distance_m']:.3f} m left"
            f"  {s['falls']} falls  {s['collisions']} collisions"
            f"  {s['path_length_m']:.1f} m  {s['sim_time_s']:.1f} s  {s['real_time_factor']:.1f} x",
            flush=True,
        )
    arrived = sum(r["goal_reached"] for r in rows)
    factor = np.median([r["real_time_factor"] for r in rows])
    print(
        f"{arrived} of {len(rows)} arrived, {sum(r['falls'] for r in rows)} falls,"
        f" {sum(r['collisions'] for r in rows)} collisions,"
        f" worst {max(r['final_distance_m'] for r in rows):.3f} m left,"
        f" median real-time factor {factor:.1f}"
    )
    if args.json is not None:
        args.json.write_text(json.dumps(rows, indent=2))


if __name__ == "__main__":
    main()
