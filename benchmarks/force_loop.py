"""Time of one tick of the force loop: both arms, from the wrists' readings to joint targets.

    python benchmarks/force_loop.py [--ticks 20000] [--json FILE]

A tick is: conditioning of two wrenches, the law of twelve axes, governors on four axes of each
arm, closed-form inverse kinematics, joint limits. The governors are stand-ins: the closed form
of a scalar governor over ROWS inequalities an axis, evaluated whole. Wall time and the
thread's own time are told apart: on a busy machine the first has the scheduler in its tail.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np

from mobius.control.admittance import ForceLoop, mobius_config
from mobius.files import write_json_atomic
from mobius.model.robot import keyframe_joints
from mobius.sense.noise import WrenchNoise
from mobius.types import SensorFrame

RESULTS = Path(__file__).parent / "results" / "force_loop.json"
ROWS = 300
BAR_MS = 1.0
"""p99 of a tick [ms]."""
GOVERNED = ("x", "y", "z", "rz")


class StandIn:
    """kappa = min (h - G x - H v) / (H (r - v)) over ROWS rows, that never bind."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.G, self.H = rng.standard_normal((ROWS, 4)), rng.standard_normal((ROWS, 2))
        self.h, self.v = np.full(ROWS, 1e3), np.zeros(2)

    def step(self, x: np.ndarray, r: np.ndarray) -> np.ndarray:
        """As far towards r as the rows allow."""
        room, ask = self.h - self.G @ x - self.H @ self.v, self.H @ (r - self.v)
        with np.errstate(divide="ignore"):
            kappa = min(1.0, float(np.min(np.where(ask > 0, room / ask, np.inf))))
        self.v = r if kappa >= 1.0 else self.v + max(kappa, 0.0) * (r - self.v)
        return self.v


def frames(n: int, q: np.ndarray) -> list[SensorFrame]:
    """Frames with wrenches as the wrists' sensors would read them."""
    rng = np.random.default_rng(0)
    noise, force = WrenchNoise(rng), np.zeros((2, 6))
    out = []
    for k in range(n):
        force[:, 2] = 4.5 + 3.0 * np.sin(0.02 * k)
        still = np.zeros(22)
        out.append(
            SensorFrame(
                stamp=k / 300,
                q=q,
                dq=still,
                torque=still,
                wrench_S=noise.corrupt(force, 1 / 300),
                gyro_I=np.zeros(3),
                accel_I=np.zeros(3),
            )
        )
    return out


def measure(ticks: int) -> dict[str, float]:
    """Percentiles of a tick [us]."""
    q, targets = keyframe_joints("crawl")
    rng = np.random.default_rng(1)
    governors = {(arm, axis): StandIn(rng) for arm in (0, 1) for axis in GOVERNED}
    config = mobius_config(stiffness=[200.0] * 3 + [5.0] * 3)
    loop = ForceLoop(config, config, governors=governors)
    loop.start(targets)
    upright = np.array([1.0, 0.0, 0.0, 0.0])
    seen = frames(1000, q)
    for frame in seen[:200]:
        loop.step(frame, upright)
    wall, own = np.empty(ticks), np.empty(ticks)
    for k in range(ticks):
        frame = seen[k % len(seen)]
        start, own_start = time.perf_counter(), time.thread_time()
        out = loop.step(frame, upright)
        own[k], wall[k] = time.thread_time() - own_start, time.perf_counter() - start
        assert not out.unreachable.any()
    return {
        "ticks": ticks,
        "rows_per_axis": ROWS,
        "p50_us": 1e6 * float(np.percentile(wall, 50)),
        "p99_us": 1e6 * float(np.percentile(wall, 99)),
        "own_p50_us": 1e6 * float(np.percentile(own, 50)),
        "own_p99_us": 1e6 * float(np.percentile(own, 99)),
        "ticks_over_the_bar": float(np.mean(wall > 1e-3 * BAR_MS)),
    }


def main() -> None:
    """Measure, print, keep."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--ticks", type=int, default=20_000)
    parser.add_argument("--json", type=Path, default=RESULTS)
    args = parser.parse_args()
    result = measure(args.ticks)
    write_json_atomic(args.json, result)
    print(f"a tick: median {result['p50_us']:.0f} us, p99 {result['p99_us']:.0f} us")
    print(f"own time: {result['own_p50_us']:.0f} us, p99 {result['own_p99_us']:.0f} us")
    print(f"bar: p99 <= {BAR_MS:g} ms; kept in {args.json}")


if __name__ == "__main__":
    main()
