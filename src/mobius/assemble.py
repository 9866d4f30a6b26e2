"""Put a simulated robot together: body, senses, estimator, policies, mode machine."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from mobius.control.policy import PolicyController, load_policy, shipped_policy
from mobius.estimate import Estimator
from mobius.geometry import quat_mul, rpy_to_quat
from mobius.model import robot as model_robot
from mobius.modes import ModeMachine
from mobius.robot.sim import SimRobot
from mobius.robot.variation import Variation
from mobius.sense import Senses
from mobius.stack import Stack
from mobius.types import Mode, Pose


@dataclass(frozen=True)
class Start:
    """Where and how a run begins."""

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
    """A whole crawling robot in a scene; the belief's odom frame is the map frame.

    Args:
        model: Scene with the robot; changed in place by the variation.
        start: Pose and seed.
        policy: ONNX file; the shipped crawl policy if not given.
    """
    rng = np.random.default_rng(start.seed)
    variation = Variation.sample(rng) if start.randomised else Variation()
    robot = SimRobot(model, variation=variation, xy=start.xy, yaw=start.yaw)
    senses = Senses(seed=start.seed, randomised=start.randomised)
    estimator = Estimator()
    estimator.reset(_start_pose(start.xy, start.yaw, float(robot.data.qpos[2])), 0.0)
    controller = PolicyController(load_policy(policy or shipped_policy("crawl")))
    stack = Stack(
        robot,
        senses=senses,
        estimator=estimator,
        machine=ModeMachine(frozenset({Mode.CRAWL})),
        controllers={Mode.CRAWL: controller},
    )
    return stack, robot


def _start_pose(xy: ArrayLike, yaw: float, height: float) -> Pose:
    x, y = np.asarray(xy, dtype=float)
    return Pose(p=np.array([x, y, height]), q=quat_mul(rpy_to_quat(0.0, 0.0, yaw), [1, 0, 0, 0]))
