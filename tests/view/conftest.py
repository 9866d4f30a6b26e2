from dataclasses import dataclass

import numpy as np
import pytest

from mobius.stack import RunRecord
from mobius.types import GridMap, Mode, Plan


def _record(seconds=20.0, *, seed=0):
    """A made-up crawl: 0.3 m/s along x, then a left turn into y; trotting; drifting belief."""
    rng = np.random.default_rng(seed)
    n = int(seconds * 60)
    t = np.arange(n) / 60
    s = 0.3 * t
    corner = 0.6 * s[-1]
    x, y = np.minimum(s, corner), np.maximum(s - corner, 0)
    yaw = np.clip((s - corner) / 0.3 + 0.5, 0, 1) * np.pi / 2
    true_p = np.column_stack([x + 0.25, y + 0.25, 0.21 + 0.005 * np.sin(9 * t)])
    belief_p = true_p + np.column_stack([0.01 * t / t[-1], 0.02 * t / t[-1], 0 * t])
    rpy = np.column_stack([0.02 * np.sin(9 * t), 0.03 * np.cos(9 * t), yaw])
    twist = np.column_stack([np.full(n, 0.3), np.zeros(n), np.gradient(yaw, t)])
    phase = 2 * np.pi * 1.5 * t
    swing = np.column_stack([np.sin(phase), -np.sin(phase), -np.sin(phase), np.sin(phase)])
    torque = rng.normal(size=(n, 22)) * np.linspace(0.2, 2.5, 22)
    q = rng.normal(size=(n, 22)) * 0.05
    nx, ny = int(corner / 0.5) + 3, int(max(y) / 0.5) + 3
    blocked = np.zeros((nx, ny), dtype=bool)
    blocked[:-2, 2:] = True
    allowed = np.full((nx, ny), 7, dtype=np.uint8)
    allowed[2:4, :2] = Mode.CRAWL.bit
    k = round(corner / 0.5)
    cells = np.array([[i, 0] for i in range(k + 1)] + [[k, j] for j in range(1, ny - 2)])
    grid = GridMap("two_rooms.yaml", 0.5, np.zeros(3), blocked, allowed)
    plan = Plan(
        cells=cells,
        modes=(Mode.CRAWL,) * (len(cells) - 2) + (Mode.BIPED,),
        xy_M=grid.center_of(cells),
        status="optimal",
        objective=12.5,
        bound=12.5,
        solve_s=0.0123,
    )
    summary = {
        "goal_reached": True,
        "final_distance_m": 0.12,
        "falls": 0,
        "collisions": 1,
        "sim_time_s": seconds,
        "wall_time_s": seconds / 8,
        "real_time_factor": 8.0,
        "path_length_m": float(s[-1]),
        "energy_J": 812.5,
        "energy_per_cell_J": 81.25,
        "cells_visited": 10,
        "plan": {"objective": 12.5, "status": "optimal", "solve_ms": 12.3, "modes": ["crawl"]},
        "estimator": {"position_rmse_m": 0.013, "yaw_rmse_rad": 0.002, "velocity_rmse_mps": 0.02},
        "seed": 7,
        "versions": {"mobius": "0.1.0", "mujoco": "4.0.0"},
    }
    return RunRecord(
        t=t,
        q=q,
        q_target=q + 0.01,
        torque=torque,
        power=np.abs(torque).sum(axis=1),
        true_p=true_p,
        true_rpy=rpy,
        true_twist_H=twist + 0.03 * np.sin(9 * t)[:, None],
        belief_p=belief_p,
        belief_rpy=rpy + 0.001,
        belief_twist_H=twist,
        cmd_twist_H=twist,
        contact_force=np.maximum(swing, 0) * 60,
        contact_belief=(swing > 0.1).astype(float),
        modes=["crawl"] * (n - 60) + ["biped"] * 60,
        frame_t=t[::2],
        frame_qpos=np.zeros((len(t[::2]), 7)),
        grid=grid,
        plan=plan,
        summary=summary,
    )


@pytest.fixture(scope="session")
def make_record():
    """Makes a synthetic run of so many seconds."""
    return _record


@dataclass
class Raster:
    occupied: np.ndarray
    resolution: float
    origin_M: np.ndarray


@pytest.fixture(scope="session")
def make_occupancy():
    """Makes what stands there, as the world would say it."""

    def make(occupied, resolution=0.1, origin=(0.0, 0.0, 0.0)):
        return Raster(occupied, resolution, np.array(origin))

    return make


@pytest.fixture
def record():
    return _record()
