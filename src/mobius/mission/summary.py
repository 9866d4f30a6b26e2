"""What ``summary.json`` holds."""

from __future__ import annotations

import platform
from importlib.metadata import version
from itertools import pairwise
from typing import Any

import numpy as np

from mobius.mission.body import ARRIVE_WITHIN
from mobius.mission.by_mode import by_mode, forced_modes
from mobius.mission.drive import Driven
from mobius.robot import TICK
from mobius.stack import ACT_EVERY, RunRecord


def summarise(driven: Driven, *, seed: int, wall_s: float) -> dict[str, Any]:
    """Figures of a run; the real-time factor is that of the loop without files."""
    record, judge, plan = driven.record, driven.judge, driven.record.plan
    goal = plan.xy_M[-1] if record.grid.goal is None else record.grid.goal
    distance = float(np.linalg.norm(record.true_p[-1, :2] - goal))
    sim_s = float(record.t[-1]) + ACT_EVERY * TICK
    cells = {tuple(c) for c in record.grid.cell_of(record.true_p[:, :2])}
    steps = np.linalg.norm(np.diff(record.true_p[:, :2], axis=0), axis=1)
    energy = float(record.summary["energy_J"])
    forced = forced_modes(record)
    return {
        "goal_reached": bool(distance <= ARRIVE_WITHIN and not judge.down),
        "final_distance_m": distance,
        "ended": record.summary["ended"],
        "falls": len(judge.falls),
        "recoveries": len(judge.recoveries),
        "collisions": judge.collisions,
        "sim_time_s": sim_s,
        "wall_time_s": wall_s,
        "real_time_factor": sim_s / float(record.summary["loop_s"]),
        "path_length_m": float(steps.sum()),
        "energy_J": energy,
        "energy_per_cell_J": energy / max(len(cells), 1),
        "cells_visited": len(cells),
        "mean_power_W": energy / sim_s,
        "loop_residual_mm": 1e3 * judge.loop_residual,
        "plan": {
            "objective": plan.objective,
            "bound": plan.bound,
            "status": plan.status,
            "solve_ms": 1e3 * plan.solve_s,
            "modes": sorted({m.value for m in plan.modes}),
        },
        "modes": by_mode(record),
        "mode_switches": _switches(driven),
        "forced_modes": forced,
        "forced_modes_used": all(f["used"] for f in forced.values()),
        "rolls": driven.pilot.rolls,
        "rolls_without_room": driven.pilot.rolls_refused,
        "motions_failed": driven.pilot.failures,
        "replans": _replans(driven),
        "scenario": driven.stagehand.log,
        "estimator": _estimator(record),
        "seed": seed,
        "versions": versions(),
    }


def _switches(driven: Driven) -> dict[str, Any]:
    """Changes between biped, crawl and roll, in all and per step: of the first plan, and as
    driven, over the steps made of all plans.
    """
    modes, pilot = driven.record.plan.modes, driven.pilot
    planned = sum(a is not b for a, b in pairwise(modes))
    return {
        "steps": len(modes),
        "planned": planned,
        "planned_per_step": planned / max(len(modes), 1),
        "steps_driven": pilot.steps,
        "driven": pilot.switches,
        "driven_per_step": pilot.switches / max(pilot.steps, 1.0),
    }


def _replans(driven: Driven) -> list[dict[str, Any]]:
    """Every plan made on the way."""
    return [
        {
            "t": r.t,
            "why": r.why,
            "status": "none" if r.plan is None else r.plan.status,
            "solve_ms": None if r.plan is None else 1e3 * r.plan.solve_s,
            "problem": r.problem,
        }
        for r in driven.pilot.replans
    ]


def _estimator(record: RunRecord) -> dict[str, float]:
    """Root mean square errors of the belief."""
    yaw = record.belief_rpy[:, 2] - record.true_rpy[:, 2]
    yaw = (yaw + np.pi) % (2 * np.pi) - np.pi
    velocity = record.belief_twist_H[:, :2] - record.true_twist_H[:, :2]
    position = record.belief_p[:, :2] - record.true_p[:, :2]
    return {
        "position_rmse_m": float(np.sqrt(np.mean(np.sum(position**2, axis=1)))),
        "yaw_rmse_rad": float(np.sqrt(np.mean(yaw**2))),
        "velocity_rmse_mps": float(np.sqrt(np.mean(np.sum(velocity**2, axis=1)))),
    }


def versions() -> dict[str, str]:
    """Of what a result depends on."""
    names = ("mobius", "mujoco", "numpy", "onnxruntime")
    return {"python": platform.python_version(), **{n: version(n) for n in names}}
