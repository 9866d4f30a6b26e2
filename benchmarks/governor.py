"""Reference governor: tick, building the set, Algorithm 3 vectorised against its loop.

    python benchmarks/governor.py                # prints; --out FILE.json writes as well

Ticks are of four axes together, percentiles over ticks of a run with references that jump beyond
the limits; the least p99 of several rounds is given beside all of them, because other jobs on the
machine only ever add to it. They run at real-time priority where the machine grants it, as the
loops of ``mobius drive`` and ``mobius ros2`` do. Processor time of the thread stands beside wall
time: it says more
where other jobs take the cores. Building is processor time and wall time. The loop
of Algorithm 3 runs on random samples of the same grid; the ratio is per sample.
"""

from __future__ import annotations

import argparse
import os
import platform
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np

from mobius.control.governor import (
    AXES,
    AdmissibleSet,
    CommandGovernor,
    Governor,
    NearestGovernor,
    ScalarGovernor,
    algorithm_3,
    axis_set,
    axis_system,
)
from mobius.control.governor.sampled_loop import algorithm_3_loop
from mobius.control.governor.sampled_set import grid_of
from mobius.files import write_json_atomic
from mobius.pace import hurry

Row = dict[str, Any]

BARS = {
    "scalar p99 us": 50.0,
    "nearest repaired p99 us": 200.0,
    "build s": 10.0,
    "loop ratio": 100.0,
}
K_ENV = (100.0, 100.0, 100.0, 1.0)


def ticks(governor: Governor, count: int, *, wrench: bool) -> Row:
    """Percentiles [us] of a tick of four axes in the loop."""
    rng, loops = (
        np.random.default_rng(0),
        [axis_system(a, k) for a, k in zip(AXES, K_ENV, strict=True)],
    )
    reach = np.array([[1.4 * a.position_max, 0.3 * a.wrench_max] for a in AXES])
    x, r = np.zeros((4, 4)), np.zeros((4, 2))
    wall, cpu = np.empty(count), np.empty(count)
    for k in range(count):
        if k % 60 == 0:
            r = rng.uniform(-1, 1, (4, 2)) * reach
        state = np.stack([x[:, 3], x[:, 1], -np.array(K_ENV) * x[:, 3]], axis=1) if wrench else x
        begin, start = time.thread_time(), time.perf_counter()
        v = governor.step(state, r)
        wall[k], cpu[k] = time.perf_counter() - start, time.thread_time() - begin
        x = np.stack([s.step(a, b) for s, a, b in zip(loops, x, v, strict=True)])
    return {
        f"p{q}_{name}us": 1e6 * float(np.percentile(times, q))
        for name, times in (("", wall), ("cpu_", cpu))
        for q in (50, 99)
    }


def rounds(make: Callable[[], Governor], args: argparse.Namespace, *, wrench: bool = False) -> Row:
    """The least of every figure over several rounds, and all their p99."""
    each = [ticks(make(), args.ticks, wrench=wrench) for _ in range(args.rounds)]
    best = {name: min(row[name] for row in each) for name in each[0]}
    return {**best, "p99_us_of_rounds": [round(row["p99_us"], 1) for row in each]}


def building() -> tuple[Row, list[AdmissibleSet]]:
    """Seconds for the sets of all four axes; equal axes share one."""
    cpu, wall, sets = 0.0, 0.0, {}
    for axis in (AXES[0], AXES[3]):
        c, w = time.process_time(), time.perf_counter()
        sets[axis.name] = axis_set(axis)
        cpu, wall = cpu + time.process_time() - c, wall + time.perf_counter() - w
    rows = {name: s.sizes[0] for name, s in sets.items()}
    return {"cpu_s": cpu, "wall_s": wall, "rows": rows}, [sets["x"]] * 3 + [sets["torque"]]


def loop_ratio(samples: int) -> Row:
    """Processor time per sample of the loop over that of the vectorised version."""
    axis = AXES[0]
    grid = grid_of(axis)
    points = grid.points()
    some = points[np.random.default_rng(0).choice(len(points), samples, replace=False)]
    start = time.process_time()
    algorithm_3_loop(axis, some)
    loop = (time.process_time() - start) / samples
    start = time.process_time()
    algorithm_3(axis, grid)
    fast = (time.process_time() - start) / len(points)
    return {
        "samples": len(points), "loop_us_per_sample": 1e6 * loop,
        "vectorised_us_per_sample": 1e6 * fast, "ratio": loop / fast,
    }  # fmt: skip


def main() -> None:
    """Run, print, write."""
    parser = argparse.ArgumentParser(description="Reference governor.")
    parser.add_argument("--ticks", type=int, default=6000, help="of a round")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--samples", type=int, default=3000, help="that the loop is run on")
    parser.add_argument("--out", type=Path, help="JSON to write")
    args = parser.parse_args()
    build, sets = building()
    printed = [algorithm_3(AXES[0])] * 3 + [algorithm_3(AXES[3])]
    repaired = [algorithm_3(AXES[0], repaired=True)] * 3 + [algorithm_3(AXES[3], repaired=True)]
    result: Row = {
        "real_time_priority": hurry(),
        "machine": {"cpu": platform.processor() or platform.machine(), "cores": os.cpu_count(),
                    "load": os.getloadavg()[0], "numpy": np.__version__},
        "bars": BARS,
        "build": build,
        "scalar": rounds(lambda: ScalarGovernor(sets), args),
        "command": rounds(lambda: CommandGovernor(sets), args),
        "nearest_printed": rounds(lambda: NearestGovernor(printed), args, wrench=True),
        "nearest_repaired": rounds(lambda: NearestGovernor(repaired), args, wrench=True),
        "algorithm_3": loop_ratio(args.samples),
    }  # fmt: skip
    print(
        f"build, four axes     {build['cpu_s']:8.2f} s CPU {build['wall_s']:8.2f} s wall  (<= 10)"
    )
    for name, bar in (("scalar", 50), ("command", None), ("nearest_printed", None),
                      ("nearest_repaired", 200)):  # fmt: skip
        row = result[name]
        print(f"{name:20s} {row['p50_us']:8.1f} {row['p99_us']:8.1f} us p50, p99; processor"
              f" {row['p50_cpu_us']:8.1f} {row['p99_cpu_us']:8.1f}"
              f"  {'' if bar is None else f'(p99 <= {bar})'}")  # fmt: skip
    a = result["algorithm_3"]
    print(f"Algorithm 3          {a['ratio']:8.0f} x the loop's speed (>= 100)")
    if args.out is not None:
        write_json_atomic(args.out, result)


if __name__ == "__main__":
    main()
