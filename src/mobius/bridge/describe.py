"""A recorded run in a few lines."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from mobius.bridge.messages import TOPICS
from mobius.bridge.read_run import Run

__all__ = ["describe"]


def describe(run: Run) -> list[str]:
    """Where, how long, in which modes, how far, falls, plans, and the topics with their counts."""
    state = "complete" if run.complete else "not closed"
    lines = [
        f"log      {run.path}",
        f"map      {_origin(run)}",
        f"time     {run.t[0]:.2f} to {run.t[-1]:.2f} s, {len(run)} samples, {state}",
        f"modes    {_modes(run)}",
        f"way      {_way(run)}",
        f"power    {run.power.mean():.1f} W mean, {run.power.max():.0f} W highest, as measured",
        f"falls    {_falls(run)}",
        f"plans    {_plans(run)}",
        f"scene    {'recorded' if run.about.scene else 'not recorded'}",
        "",
        f"{'topic':24s} {'messages':>8s}  type",
    ]
    for name, count in run.counts.items():
        kind = TOPICS[name].type if name in TOPICS else "not read by mobius"
        lines.append(f"{name:24s} {count:8d}  {kind}")
    return lines


def _origin(run: Run) -> str:
    about = run.about
    seed = [] if about.seed is None else [f"seed {about.seed}"]
    versions = [f"{name} {number}" for name, number in about.versions.items() if name != "python"]
    return ", ".join([about.map or "not recorded", *seed, *versions])


def _modes(run: Run) -> str:
    """Each stay in a mode, in order; the last ones of many."""
    starts = [k for k in range(len(run)) if k == 0 or run.modes[k] != run.modes[k - 1]]
    stays = [
        f"{run.modes[a] or 'not recorded'} {run.t[min(b, len(run) - 1)] - run.t[a]:.1f} s"
        for a, b in pairwise([*starts, len(run)])
    ]
    before = [f"({len(stays) - 8} before)"] if len(stays) > 8 else []
    return ", ".join([*before, *stays[-8:]])


def _way(run: Run) -> str:
    track = run.true or run.believed
    if track is None:
        return "not recorded"
    whose = "true" if run.true is not None else "believed"
    line = f"{run.distance:.2f} m ({whose})"
    if run.true is not None and run.believed is not None:
        apart = np.linalg.norm(run.true.p_M[-1, :2] - run.believed.p_M[-1, :2])
        line += f", belief {apart:.2f} m off at the end"
    return line


def _falls(run: Run) -> str:
    if "falls" not in run.summary:
        return "not known; the log has no summary.json beside it"
    told = f"{run.summary['falls']}"
    if "recoveries" in run.summary:
        told += f", {run.summary['recoveries']} recovered"
    return told


def _plans(run: Run) -> str:
    if not run.plans:
        return "none recorded"
    return ", ".join(f"{plan.status} at {t:.1f} s" for t, plan in run.plans)
