"""How hard a shove a body takes, standing and walking (Fig. 16)."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from functools import partial
from typing import Any

import numpy as np

from mobius.control.bodies import body_of
from mobius.evaluate.commands import Segment, moving
from mobius.evaluate.episode import Policy, Setup, build
from mobius.evaluate.jobs import Progress, run_jobs
from mobius.robot import TICK
from mobius.types import ModeCommand, StateEstimate

MAGNITUDES = tuple(round(0.1 * k, 1) for k in range(1, 11))
"""Of the shoves, as the change of velocity of a free robot [m/s]."""
DURATION_S = 0.1
"""Of a shove [s]."""
SETTLE_S = 2.0
"""Before the first shove [s]."""
RECOVER_S = 4.0
"""From the end of a shove to the next [s]."""
QUIET_S = 3.0
"""A standing robot that is quiet by then has recovered [s]."""
QUIET = 0.02
"""A trunk slower than this is quiet [m/s]."""
STATES = ("stand", "walk")
"""What a robot is asked to do while it is shoved."""


@dataclass
class PushRun:
    """One robot shoved harder and harder until it fell."""

    seed: int
    state: str
    """One of :data:`STATES`."""
    command: tuple[float, float, float]
    """vx, vy [m/s], wz [rad/s]."""
    survived: list[float] = field(default_factory=list)
    """Magnitudes it survived [m/s]."""
    angles: list[float] = field(default_factory=list)
    """Direction of each shove in the world [rad]."""
    fallen: bool = False


def push_until_fall(
    job: tuple[Setup, str],
    *,
    magnitudes: tuple[float, ...] = MAGNITUDES,
    as_force: bool = False,
) -> PushRun:
    """Shove one robot in random directions, each time harder, until it falls."""
    setup, state = job
    rng = np.random.default_rng([setup.seed, 53, int(state == "walk")])
    walk = moving(setup.body, rng, share=0.6)
    segment = walk if state == "walk" else Segment("stand", (0.0, 0.0, 0.0))
    stack, robot, judge = build(setup)
    run = PushRun(setup.seed, state, segment.twist)
    mode, twist = body_of(setup.body).mode, np.array(segment.twist)

    def source(belief: StateEstimate) -> ModeCommand:
        return ModeCommand(mode=mode, twist_H=twist, stamp=belief.stamp)

    def go_on(seconds: float) -> None:
        end = stack.tick + round(seconds / TICK)
        while stack.tick < end and not judge.fallen:
            sample = stack.turn(source)
            if sample is not None:
                judge.see(sample)

    go_on(SETTLE_S)
    for magnitude in magnitudes:
        if judge.fallen:
            break
        angle = float(rng.uniform(0.0, 2.0 * np.pi))
        run.angles.append(angle)
        shove = magnitude * np.array([np.cos(angle), np.sin(angle)])
        robot.push(shove, DURATION_S, as_force=as_force)
        go_on(DURATION_S + QUIET_S)
        if state == "walk" or np.linalg.norm(robot.truth().v_B) > QUIET:
            go_on(RECOVER_S - QUIET_S)
        if not judge.fallen:
            run.survived.append(magnitude)
    run.fallen = judge.fallen
    return run


@dataclass
class Push:
    """The outcome of ``mobius eval BODY push``."""

    body: str
    seed: int
    """The first seed."""
    episodes: int
    """Robots that were shoved: two a seed, one standing and one walking."""
    falls: int
    as_force: bool
    """Whether the accelerometer felt the shoves."""
    magnitudes_mps: list[float]
    survival: dict[str, list[float]]
    """By state: share of seeds that survived each magnitude and all smaller ones."""
    runs: list[PushRun] = field(default_factory=list)

    def as_json(self) -> dict[str, Any]:
        """Plain values."""
        return asdict(self)


def push(
    body: str,
    *,
    seeds: int,
    seed: int = 0,
    policy: Policy = None,
    randomised: bool = True,
    magnitudes: tuple[float, ...] = MAGNITUDES,
    as_force: bool = False,
    workers: int = 0,
    progress: Progress | None = None,
) -> Push:
    """Shove robots until they fall: 0.1 s, any direction, 0.1 to 1.0 m/s by 0.1.

    A shove of dv adds dv / 60 to the velocity of the whole robot in each of 60 steps of 1/600 s:
    a uniform acceleration, as by a force m dv / 0.1 s through its centre of mass. The
    accelerometer feels it only with ``as_force`` (:meth:`SimRobot.push`), which makes it easier
    for the estimator. A walking robot follows a random command at 60 % of the body's range.

    Args:
        body: ``crawl`` or ``biped``.
        seeds: Number of seeds, >= 1; each stands once and walks once.
        seed: First seed.
        policy: What drives; the shipped policy if not given.
        randomised: Draw friction, mass, servos, delay and sensors.
        magnitudes: Of the shoves, rising [m/s].
        as_force: Shove with a force that the accelerometer feels.
        workers: Processes; 0 takes one a CPU.
        progress: Called with the share done after each robot.
    """
    body_of(body)
    setups = [Setup(body, seed + k, policy, randomised) for k in range(seeds)]
    jobs = [(setup, state) for setup in setups for state in STATES]
    work = partial(push_until_fall, magnitudes=magnitudes, as_force=as_force)
    runs = run_jobs(work, jobs, workers=workers, progress=progress)
    return Push(
        body=body,
        seed=seed,
        episodes=len(runs),
        falls=sum(r.fallen for r in runs),
        as_force=as_force,
        magnitudes_mps=list(magnitudes),
        survival={state: survival(runs, state, magnitudes) for state in STATES},
        runs=runs,
    )


def survival(runs: list[PushRun], state: str, magnitudes: tuple[float, ...]) -> list[float]:
    """Share of the robots in ``state`` that survived each magnitude and all before it."""
    counts = np.array([len(r.survived) for r in runs if r.state == state])
    return [float((counts > k).mean()) for k in range(len(magnitudes))]
