"""How well a policy tracks commands in the whole stack: full collision geometry, physics at
1/600 s, randomised robot and floor, the belief of the estimator, never the truth.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mobius.control.bodies import body_of
from mobius.robot import TICK
from mobius.types import Mode, ModeCommand, StateEstimate

Array = NDArray[np.float64]

EPISODE_S = 20.0
SETTLE_S = 1.0
"""After a new command nothing is counted for this long [s]."""
HOLD_S = 4.0
"""Each command is held this long [s]."""
WINDOW_S = 0.5
"""Velocities are averaged over this long before they are compared: about one stride [s]."""


@dataclass
class Episode:
    """One episode of one seed."""

    seed: int
    fallen: bool
    error: list[float]
    """Mean absolute error of vx, vy [m/s], wz [rad/s] over :data:`WINDOW_S` means."""
    raw_error: list[float]
    """The same without averaging."""
    estimate_error: list[float]
    """RMS of believed minus true vx, vy [m/s], wz [rad/s]."""
    power_W: float
    saturation: float
    """Share of joint-samples whose output torque (drive minus back-EMF) exceeds 95 % of stall."""
    height_error_m: float
    """Largest deviation of the trunk's height from its median [m]."""
    loop_residual_mm: float


def commands_of(body: str, seed: int, scale: float = 1.0) -> Array:
    """(k, 3) the commands of an episode: uniform over the body's range, one along one axis.

    Every fourth seed ends standing still.
    """
    rng = np.random.default_rng([seed, 77])
    b = body_of(body)
    k = round(EPISODE_S / HOLD_S)
    commands = scale * rng.uniform(b.command_low, b.command_high, (k, 3))
    commands[rng.integers(k)] *= np.eye(3)[rng.integers(3)]
    if seed % 4 == 0:
        commands[-1] = 0.0
    return commands


def episode(
    body: str, seed: int, *, policy: Path | None = None, randomised: bool = True
) -> Episode:
    """Run one episode in the stack and measure it against the truth."""
    from mobius.assemble import Start, build_sim_stack, flat_model
    from mobius.stack import Judge

    commands = commands_of(body, seed)
    start = Start(body=body, seed=seed, randomised=randomised)
    stack, robot = build_sim_stack(flat_model(), start, policy=policy)
    judge = Judge(robot, body=body)
    mode = body_of(body).mode

    def source(belief: StateEstimate) -> ModeCommand:
        i = min(int(belief.stamp / HOLD_S), len(commands) - 1)
        return ModeCommand(mode=Mode(mode), twist_H=commands[i], stamp=belief.stamp)

    while stack.tick * TICK < EPISODE_S and not judge.fallen:
        sample = stack.turn(source)
        if sample is not None:
            judge.see(sample)
    return _measure(seed, judge)


def _measure(seed: int, judge: Any) -> Episode:
    from mobius.model.joints import JOINTS
    from mobius.model.servo import servo_of

    rows = judge.columns()
    t, true, want = rows["t"], rows["true_twist_H"], rows["cmd_twist_H"]
    belief, torque, height = rows["belief_twist_H"], rows["torque"], rows["true_p"][:, 2]
    counted = (t % HOLD_S) > SETTLE_S
    width = round(WINDOW_S * 60)
    kernel = np.ones(width) / width
    smooth = np.stack([np.convolve(true[:, i], kernel, mode="same") for i in range(3)], axis=1)
    counted_smooth = counted & ((t % HOLD_S) < HOLD_S - 0.5 * WINDOW_S)
    counted_smooth &= t < t[-1] - 0.5 * WINDOW_S
    if not counted_smooth.any():  # fell at once: nothing settled, so everything counts
        counted, counted_smooth = np.ones_like(counted), np.ones_like(counted)
    limit = np.array([servo_of(j).stall_torque for j in JOINTS])

    def mean_abs(error: Array) -> list[float]:
        return [float(v) for v in np.abs(error).mean(axis=0)]

    return Episode(
        seed=seed,
        fallen=judge.fallen,
        error=mean_abs((smooth - want)[counted_smooth]),
        raw_error=mean_abs((true - want)[counted]),
        estimate_error=[float(v) for v in np.sqrt(np.mean((belief - true) ** 2, axis=0))],
        power_W=float(rows["power"].mean()),
        saturation=float((np.abs(torque) > 0.95 * limit).mean()),
        height_error_m=float(np.abs(height - np.median(height)).max()),
        loop_residual_mm=1e3 * judge.loop_residual,
    )


@dataclass
class Tracking:
    """The outcome of ``mobius eval BODY tracking``."""

    body: str
    seed: int
    """The first seed."""
    episodes: int
    falls: int
    mae: dict[str, float]
    """vx, vy [m/s], wz [rad/s]; mean over episodes of the error of 0.5 s means."""
    mae_raw: dict[str, float]
    estimate_rmse: dict[str, float]
    power_W: float
    saturation: float
    height_error_m: float
    loop_residual_mm: float
    """Largest of all episodes."""
    runs: list[dict[str, Any]] = field(default_factory=list)

    def as_json(self) -> dict[str, Any]:
        """Plain values."""
        return asdict(self)


def tracking(
    body: str,
    *,
    seeds: int,
    seed: int = 0,
    policy: Path | None = None,
    randomised: bool = True,
    workers: int = 0,
    progress: Callable[[Episode], None] | None = None,
) -> Tracking:
    """Track random commands over ``seeds`` episodes, the first with ``seed``.

    Args:
        body: ``crawl``.
        seeds: Number of episodes, >= 1.
        seed: First seed.
        policy: ONNX file; the shipped one if not given.
        randomised: Draw friction, mass, servos, delay and sensors.
        workers: Processes; 0 takes one a CPU.
        progress: Called after each episode.
    """
    body_of(body)
    jobs = range(seed, seed + seeds)
    workers = workers or len(os.sched_getaffinity(0))
    episodes: list[Episode] = []
    for result in _run(body, jobs, policy, randomised, min(workers, seeds)):
        episodes.append(result)
        if progress is not None:
            progress(result)
    return summarise(body, seed, episodes)


def _run(
    body: str, jobs: Iterable[int], policy: Path | None, randomised: bool, workers: int
) -> Iterable[Episode]:
    if workers <= 1:
        for job in jobs:
            yield episode(body, job, policy=policy, randomised=randomised)
        return
    with ProcessPoolExecutor(workers) as pool:
        futures = [
            pool.submit(episode, body, job, policy=policy, randomised=randomised) for job in jobs
        ]
        for future in futures:
            yield future.result()


def summarise(body: str, seed: int, episodes: list[Episode]) -> Tracking:
    """Means over episodes; of residual and height the largest."""
    axes = ("vx", "vy", "wz")

    def mean(name: str) -> dict[str, float]:
        values = np.mean([getattr(e, name) for e in episodes], axis=0)
        return {a: float(v) for a, v in zip(axes, values, strict=True)}

    return Tracking(
        body=body,
        seed=seed,
        episodes=len(episodes),
        falls=sum(e.fallen for e in episodes),
        mae=mean("error"),
        mae_raw=mean("raw_error"),
        estimate_rmse=mean("estimate_error"),
        power_W=float(np.mean([e.power_W for e in episodes])),
        saturation=float(np.mean([e.saturation for e in episodes])),
        height_error_m=max(e.height_error_m for e in episodes),
        loop_residual_mm=max(e.loop_residual_mm for e in episodes),
        runs=[asdict(e) for e in episodes],
    )
