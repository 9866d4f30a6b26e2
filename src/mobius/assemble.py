"""Put a simulated robot together: body, senses, estimator, policies, mode machine."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from mobius.control.bodies import body_of
from mobius.control.peers import controller_of
from mobius.estimate import Estimator
from mobius.model import robot as model_robot
from mobius.modes import ModeMachine
from mobius.robot.sim import SimRobot
from mobius.robot.variation import Variation
from mobius.sense import Senses
from mobius.stack import Controller, Heights, Stack
from mobius.types import Pose
from mobius.world.ground import Ground, add_ground


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
    variation: Variation | None = None
    """Friction, mass, servo strength and delay instead of the draw."""
    noise: float = 1.0
    """Factor on the noise of all sensors."""


def flat_model() -> mujoco.MjModel:
    """The full robot on an endless floor, physics step 1/600 s."""
    return model_robot.load_model("full")


def ground_model(ground: Ground) -> mujoco.MjModel:
    """The full robot over uneven ground, physics step 1/600 s."""
    spec = model_robot.load_spec("full")
    add_ground(spec, ground)
    return spec.compile()


def variation_of(start: Start) -> Variation:
    """How the robot of a run differs from the drawing."""
    if start.variation is not None:
        return start.variation
    return Variation.sample(np.random.default_rng(start.seed)) if start.randomised else Variation()


def build_sim_stack(
    model: mujoco.MjModel,
    start: Start,
    *,
    policy: Path | str | Controller | None = None,
    ground: Heights | None = None,
) -> tuple[Stack, SimRobot]:
    """A whole robot in a scene; the belief's odom frame is the map frame.

    Args:
        model: Scene with the robot; changed in place by the variation.
        start: Pose and seed.
        policy: ONNX file, ``flat``, ``rough``, ``zero``, ``random`` or a controller; the
            body's shipped policy for flat floors if not given.
        ground: Height of the scene's floor, where it is not flat at 0.
    """
    body = body_of(start.body)
    controller = (
        controller_of(policy, start.body, seed=start.seed)
        if policy is None or isinstance(policy, str | Path)
        else policy
    )
    robot = SimRobot(
        model,
        variation=variation_of(start),
        keyframe=body.keyframe,
        xy=start.xy,
        yaw=start.yaw,
        ground=ground,
    )
    senses = Senses(seed=start.seed, randomised=start.randomised, noise=start.noise)
    estimator = Estimator()
    truth = robot.truth()  # the start is the only pose that the robot is told
    estimator.reset(Pose(p=truth.p_OB, q=truth.q_OB), 0.0)
    stack = Stack(
        robot,
        senses=senses,
        estimator=estimator,
        machine=ModeMachine(frozenset({body.mode}), mode=body.mode),
        controllers={body.mode: controller},
    )
    return stack, robot
