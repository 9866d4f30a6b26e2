"""What this machine does: planner, kinematics, physics, estimator and policy, loop."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np


def _median_s(work: Callable[[], object], repeats: int) -> float:
    """Median wall time [s] of one call."""
    work()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return float(np.median(times))


def bench_plan() -> dict[str, float]:
    """20 x 20 cells, T = 20, on the reconstructed map; the paper took 10.67 s (Gurobi)."""
    from mobius import paper
    from mobius.plan import RECONSTRUCTED_WEIGHTS, literal_problem, reconstructed_map, solve

    problem = literal_problem(reconstructed_map(20), horizon=20, weights=RECONSTRUCTED_WEIGHTS)
    seconds = _median_s(lambda: solve(problem), 30)
    return {
        "plan 20x20 T=20 [ms]": 1e3 * seconds,
        "paper's plan time over ours": paper.TABLE_VI_MULTI[0].seconds / seconds,
    }


def bench_kinematics() -> dict[str, float]:
    """Closed-form inverse kinematics over a batch of 100,000 poses."""
    from mobius.model import LIMB_JOINTS, arm, leg, limb_geometry
    from mobius.model.robot import keyframe_joints

    q0 = keyframe_joints("crawl")[0]
    rng, figures = np.random.default_rng(0), {}
    for limb in ("left_arm", "left_leg"):
        g = limb_geometry(limb)
        q = q0[LIMB_JOINTS[limb]] + rng.uniform(-0.2, 0.2, (100_000, 6 if g.is_arm else 4))
        if g.is_arm:
            pose = arm.gripper_pose(g, q)
            seconds = _median_s(lambda g=g, pose=pose: arm.gripper_ik(g, *pose), 7)  # type: ignore[misc]
        else:
            p, pitch = leg.sole_position(g, q), leg.foot_pitch(g, q)
            seconds = _median_s(lambda g=g, p=p, pitch=pitch: leg.sole_ik(g, p, pitch), 7)  # type: ignore[misc]
        figures[f"{limb[5:]} inverse kinematics [1e6/s]"] = 1e-6 * len(q) / seconds
    return figures


def bench_loop(seconds: float = 10.0) -> dict[str, float]:
    """The whole stack crawling on a flat floor, without recording."""
    from mobius.assemble import Start, build_sim_stack, flat_model
    from mobius.robot import TICK
    from mobius.types import Mode, ModeCommand, StateEstimate

    stack, robot = build_sim_stack(flat_model(), Start(randomised=True))

    def forward(belief: StateEstimate) -> ModeCommand:
        return ModeCommand(Mode.CRAWL, np.array([0.3, 0.0, 0.0]), belief.stamp)

    start = time.perf_counter()
    while stack.tick * TICK < seconds:
        stack.turn(forward)
    loop = time.perf_counter() - start
    start = time.perf_counter()
    ticks = round(0.2 * seconds / TICK)
    for _ in range(ticks):
        robot.wait()
    physics = (time.perf_counter() - start) / ticks
    return {
        "loop, real-time factor": seconds / loop,
        "physics step 1/600 s [us]": 1e6 * physics,
        "physics share of the loop": physics * seconds / TICK / loop,
    }


def bench() -> dict[str, float]:
    """All figures by name."""
    return {**bench_plan(), **bench_kinematics(), **bench_loop()}
