"""Put a simulated robot together: body, senses, estimator, policies, mode machine."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from mobius.control.bodies import BODIES, body_of
from mobius.control.peers import controller_of
from mobius.errors import InvalidInput, UnknownName
from mobius.estimate import Estimator
from mobius.model import robot as model_robot
from mobius.modes import (
    Gather,
    Gathered,
    ModeMachine,
    MotionPlayer,
    Posture,
    Recovery,
    load_motion,
    motion_names,
)
from mobius.modes.motions import Motion
from mobius.robot.sim import SimRobot
from mobius.robot.variation import Variation
from mobius.sense import Senses
from mobius.stack import Controller, Heights, Stack
from mobius.types import Mode, Pose
from mobius.world.ground import Ground, add_ground

Drive = Path | str | Controller | None
"""What drives a body: an ONNX file, ``flat``, ``rough``, ``zero``, ``random``, a controller; the
shipped policy for flat floors if None."""

MOTION_OF: dict[Mode, str] = {
    Mode.STAND_UP: "crawl_to_stand",
    Mode.LIE_DOWN: "stand_to_crawl",
    Mode.ROLL: "roll",
    Mode.PUSH_UPS: "push_ups",
}
"""The motion that serves a mode."""
BEGIN_IN: dict[str, Mode] = {
    "crawl": Mode.CRAWL,
    "home": Mode.CRAWL,
    "stand": Mode.BIPED,
}
"""Mode in which a run from a keyframe begins; RECOVER from all others."""


@dataclass(frozen=True, eq=False)
class Start:
    """Where and how a run begins."""

    body: str = "crawl"
    """Which body it begins in."""
    keyframe: str | None = None
    """Posture it begins in instead of the body's stance, e.g. ``prone``."""
    qpos: np.ndarray | None = None
    """Whole configuration (nq,) it begins in instead of keyframe, place and heading."""
    mode: Mode | None = None
    """Mode it begins in, where keyframe or configuration do not tell."""
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
    policy: Drive | Mapping[str, Drive] = None,
    ground: Heights | None = None,
    modes: Iterable[str] | None = None,
    motions: Mapping[str, Motion] | None = None,
) -> tuple[Stack, SimRobot]:
    """A whole robot in a scene; the belief's odom frame is the map frame.

    Args:
        model: Scene with the robot; changed in place by the variation.
        start: Pose and seed.
        policy: What drives the body; by name of the body where there are several.
        ground: Height of the scene's floor, where it is not flat at 0.
        modes: Primary modes it shall have: ``crawl``, ``biped``, ``roll``, ``push_ups``; with
            them come transitions, recovery and a camera that can lose its track. If not given,
            only the body it starts in.
        motions: Motions by name; those that come with the package if not given.

    Raises:
        InvalidInput: A mode lacks a motion, or the start a mode.
        UnknownName: There is no such mode.
    """
    body = body_of(start.body)
    keyframe = start.keyframe or body.keyframe
    if modes is None:
        controllers: dict[Mode, Controller] = {body.mode: _driver(policy, start.body, start.seed)}
        mode = body.mode
    else:
        known = {name: load_motion(name) for name in motion_names()} if motions is None else motions
        controllers = controllers_of(modes, known, policy=policy, seed=start.seed)
        mode = start.mode or _first_mode(start, keyframe)
    robot = SimRobot(
        model,
        variation=variation_of(start),
        keyframe=keyframe,
        xy=start.xy,
        yaw=start.yaw,
        ground=ground,
        qpos=start.qpos,
    )
    senses = Senses(
        seed=start.seed,
        randomised=start.randomised,
        noise=start.noise,
        can_lose=modes is not None,
    )
    estimator = Estimator()
    truth = robot.truth()  # the start is the only pose that the robot is told
    estimator.reset(Pose(p=truth.p_OB, q=truth.q_OB), 0.0)
    stack = Stack(
        robot,
        senses=senses,
        estimator=estimator,
        machine=ModeMachine(frozenset(controllers), mode=mode),
        controllers=controllers,
    )
    return stack, robot


def controllers_of(
    modes: Iterable[str],
    motions: Mapping[str, Motion],
    *,
    policy: Drive | Mapping[str, Drive] = None,
    seed: int = 0,
) -> dict[Mode, Controller]:
    """A controller for each primary mode, the transitions between them, and recovery.

    Args:
        modes: ``crawl``, ``biped``, ``roll``, ``push_ups``.
        motions: By name.
        policy: What drives crawl and biped, the same for both or by body.
        seed: Of a random driver.
    """
    primary = ("crawl", "biped", "roll", "push_ups")
    wanted = list(modes)
    for name in wanted:
        if name not in primary:
            raise UnknownName("mode", name, primary)
    made: dict[Mode, Controller] = {
        BODIES[name].mode: _driver(policy, name, seed) for name in wanted if name in BODIES
    }
    needs = [Mode(name) for name in wanted if name not in BODIES]
    if Mode.CRAWL in made and Mode.BIPED in made:
        needs += [Mode.STAND_UP, Mode.LIE_DOWN]
    if needs and Mode.CRAWL not in made:
        raise InvalidInput(f"mode '{needs[0]}' begins and ends in crawl; give that mode as well")
    for mode in needs:
        if MOTION_OF[mode] not in motions:
            raise InvalidInput(
                f"mode '{mode}' needs the motion '{MOTION_OF[mode]}', which is not there;"
                f" there are: {', '.join(sorted(motions)) or 'none'}"
            )
        made[mode] = MotionPlayer(motions[MOTION_OF[mode]])
    if Mode.CRAWL in made and len(made) > 1:
        made[Mode.GATHER] = Gather(gathered())
    stances = {
        posture: model_robot.keyframe_joints(BODIES[name].keyframe)[1]
        for name, posture in (("crawl", Posture.CRAWLING), ("biped", Posture.STANDING))
        if name in wanted
    }
    if Posture.CRAWLING in stances:  # a robot that can crawl gets up to crawl
        stances.pop(Posture.STANDING, None)
    if stances:
        made[Mode.RECOVER] = Recovery(motions, stances)
    return made


def gathered() -> Gathered:
    """Keyframe ``crawl``, in which the motions on four limbs begin."""
    q, targets = model_robot.keyframe_joints("crawl")
    model = flat_model()
    return Gathered(q, targets, model_robot.centre_of_mass, float(model.body_mass.sum()))


def _driver(policy: Drive | Mapping[str, Drive], body: str, seed: int) -> Controller:
    chosen = policy.get(body) if isinstance(policy, Mapping) else policy
    if chosen is None or isinstance(chosen, str | Path):
        return controller_of(chosen, body, seed=seed)
    return chosen


def _first_mode(start: Start, keyframe: str) -> Mode:
    """The mode that fits where a run starts."""
    return Mode.RECOVER if start.qpos is not None else BEGIN_IN.get(keyframe, Mode.RECOVER)
