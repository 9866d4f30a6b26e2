"""Put a simulated robot together: body, senses, estimator, policies, mode machine."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from mobius.control.bodies import body_of
from mobius.control.policy import PolicyController, load_policy, shipped_policy
from mobius.estimate import Estimator
from mobius.model import robot as model_robot
from mobius.modes import ModeMachine
from mobius.robot.sim import SimRobot
from mobius.robot.variation import Variation
from mobius.sense import Senses
from mobius.stack import Stack
from mobius.types import Pose


@dataclass(frozen=True)
class Start:
    """Where and how a run begins."""

    body: str = "crawl"
    """Which body it begins in."""
    xy: tuple[float, float] = (0.0, 0.0)
    """Trunk in frame M [m]."""
    yaw: float = 0.0
    """Heading [rad]."""
    seed: int = 0
    randomised: bool = True
    """Draw friction, mass, servo strength, delay and sensor drift from the seed."""


def flat_model() -> mujoco.MjModel:
    """The full robot on an endless floor, physics step 1/600 s."""
    return model_robot.load_model("full")


def build_sim_stack(
    model: mujoco.MjModel, start: Start, *, policy: Path | None = None
) -> tuple[Stack, SimRobot]:
    """A whole robot in a scene; the belief's odom frame is the map frame.

    Args:
        model: Scene with the robot; changed in place by the variation.
        start: Pose and seed.
        policy: ONNX file; the shipped policy of the body if not given.
    """
    rng = np.random.default_rng(start.seed)
    variation = Variation.sample(rng) if start.randomised else Variation()
    body = body_of(start.body)
    robot = SimRobot(model, variation=variation, keyframe=body.keyframe, xy=start.xy, yaw=start.yaw)
    senses = Senses(seed=start.seed, randomised=start.randomised)
    estimator = Estimator()
    truth = robot.truth()  # the start is the only pose that the robot is told
    estimator.reset(Pose(p=truth.p_OB, q=truth.q_OB), 0.0)
    controller = PolicyController(load_policy(policy or shipped_policy(start.body)))
    stack = Stack(
        robot,
        senses=senses,
        estimator=estimator,
        machine=ModeMachine(frozenset({body.mode}), mode=body.mode),
        controllers={body.mode: controller},
    )
    return stack, robot
