"""What a foot's contact does as it is unloaded, by how the soles give way.

    python benchmarks/soles.py [--seeds 3] [--policy FILE] [--speed 0.5714]

The same policy, robots and commands on soles with different ``solimp`` (MuJoCo's impedance of a
contact: at zero depth, at full depth, full depth in m): how deep a standing robot sinks in, the
share of contacts shorter than 0.05 s, how many milliseconds the foot had been off the ground
before they began, and the largest force in them.
"""

from __future__ import annotations

import argparse
import copy
from functools import partial

import mujoco
import numpy as np

from mobius.assemble import flat_model
from mobius.evaluate.episode import Setup, drive
from mobius.evaluate.gauge import CHATTER_S, DT
from mobius.evaluate.jobs import run_jobs
from mobius.evaluate.tracking import COMMANDS, SETTLE_S, schedule
from mobius.model.dimensions import SOLE_SOLIMP

VARIANTS = (
    (0.9, 0.95, 0.001, 0.5, 2.0),
    (0.0, 0.95, 0.0005, 0.5, 2.0),
    SOLE_SOLIMP,
    (0.0, 0.95, 0.001, 0.5, 2.0),
    (0.0, 0.9, 0.003, 0.5, 2.0),
)
"""The first is MuJoCo's own."""


def model_with(solimp: tuple[float, ...]) -> mujoco.MjModel:
    """The robot on a flat floor with other soles."""
    model = copy.deepcopy(flat_model())
    model.geom_solimp[model.geom_priority == 1] = solimp
    return model


def depth(solimp: tuple[float, ...]) -> float:
    """Mean depth of the soles' contact points of a robot that stands [m]."""
    model = model_with(solimp)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("stand").id)
    mujoco.mj_step(model, data, nstep=600)
    return float(-data.contact.dist.mean())


def contacts(seed: int, solimp: tuple[float, ...], policy: str | None, speed: float) -> np.ndarray:
    """Every contact of one episode as a row: length [s], time off before [s], largest force [N]."""
    segments = schedule("crawl", seed, count=COMMANDS, speed=speed)
    setup = Setup("crawl", seed, policy, True)
    readings = drive(setup, segments, model=model_with(solimp)).readings
    rows = []
    for foot, on in enumerate(readings.contact.T):
        step = np.diff(on.astype(int))
        begin, end = np.flatnonzero(step > 0) + 1, np.flatnonzero(step < 0) + 1
        for b in begin[readings.t[begin] >= SETTLE_S]:
            after, before = end[end > b], end[end <= b]
            if after.size and before.size:
                largest = readings.force[b : after[0], foot].max()
                rows.append(((after[0] - b) * DT, (b - before[-1]) * DT, largest))
    return np.array(rows).reshape(-1, 3)


def main() -> None:
    """A line for every sole."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--policy", default=None)
    parser.add_argument("--speed", type=float, default=1.0)
    args = parser.parse_args()
    print(f"{'solimp':>24s}  depth  short  off before, force: medians of the short ones")
    for solimp in VARIANTS:
        work = partial(contacts, solimp=solimp, policy=args.policy, speed=args.speed)
        rows = np.concatenate(run_jobs(work, list(range(args.seeds))))
        short = rows[:, 0] < CHATTER_S - 0.5 * DT
        off, force = np.median(rows[short, 1:], axis=0) if short.any() else (np.nan, np.nan)
        print(
            f"{' '.join(f'{v:g}' for v in solimp):>24s} {1e3 * depth(solimp):4.2f} mm"
            f" {100 * short.mean():5.1f} % {1e3 * off:6.1f} ms {force:5.1f} N",
            flush=True,
        )


if __name__ == "__main__":
    main()
