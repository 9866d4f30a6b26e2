"""Pull-ups in physics: hang, pull, hold, two pushes down, lower; judged by the truth."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from mobius.control.admittance import AdmittanceConfig
from mobius.control.pullup import PullUp, leg_targets
from mobius.control.tuning import Tuner
from mobius.estimate import Estimator
from mobius.evaluate.pullup_judge import PullUpJudge, PullUpTruth, Push
from mobius.geometry import mat_to_quat, quat_mul, quat_to_mat, rpy_to_quat
from mobius.model import robot as model_robot
from mobius.model.dimensions import ROBOT_MASS, TIP_ARM
from mobius.model.gripper import finger_tips, pinch_angle
from mobius.model.hang import (
    MIRROR,
    STALL,
    TILT,
    hand_rotation,
    hang_arms,
    hang_torques,
    trunk_rotation,
)
from mobius.model.limit_surface import LimitSurface
from mobius.modes import ModeMachine
from mobius.modes.pullup import WAY, Phase, PullUpScript, PullUpTimes
from mobius.robot.grasp import PinchGrasp
from mobius.robot.interface import TICK
from mobius.robot.sim import SimRobot
from mobius.robot.variation import Variation
from mobius.sense import Senses
from mobius.stack import Stack
from mobius.types import Mode, ModeCommand, Pose, StateEstimate
from mobius.world.bar import Bar, build_bar_scene

__all__ = ["PullUpDraw", "PullUpTrial", "build_pullup", "draw_of", "run_pullup", "stall_shares"]

Array = NDArray[np.float64]

HEIGHT = 1.05
"""Of the bar as drawn up [m]."""
PUSHES = (15.0, 30.0)
"""Down on the trunk, one after the other [N]; the first is the paper's (Sec. V-G4)."""
PUSH_S = 1.0
BACK_S = 3.0
"""Time to come back in [s]."""
QUIET_S = 1.5
"""Hold before the first push [s]."""


@dataclass(frozen=True)
class PullUpDraw:
    """What differs from the drawing in one trial."""

    seed: int
    bar_height: float = HEIGHT
    """[m]."""
    bar_yaw: float = 0.0
    """Bar and robot against the world [rad]: one end this much ahead."""
    bar_tilt: float = 0.0
    """Left end up [rad]."""
    variation: Variation = field(default_factory=Variation)
    surfaces: tuple[LimitSurface, LimitSurface] = (LimitSurface(), LimitSurface())
    noise: float = 1.0
    """Factor on all sensor noise."""


def draw_of(seed: int) -> PullUpDraw:
    """The draw of a seed.

    Bar: height, both ends' height and place +-2 cm. Robot: trunk +-0.5 kg, friction 0.5-1.2. Both
    grasps' limit surfaces by Table IX. Servos and centre of mass as in the drawing.
    """
    rng = np.random.default_rng([seed, 7])
    ends = rng.uniform(-0.02, 0.02, 4)
    variation = Variation(
        friction=float(rng.uniform(0.5, 1.2)),
        trunk_mass=float(rng.uniform(-0.5, 0.5)),
    )
    return PullUpDraw(
        seed=seed,
        bar_height=HEIGHT + float(rng.uniform(-0.02, 0.02)),
        bar_yaw=float(ends[1] - ends[0]),
        bar_tilt=float(ends[3] - ends[2]),
        variation=variation,
        surfaces=(LimitSurface.draw(rng), LimitSurface.draw(rng)),
    )


def bar_model(draw: PullUpDraw) -> mujoco.MjModel:
    """The scene: the bar's faces are turned to meet the hands (by TILT about its axis)."""
    spec = build_bar_scene(
        model_robot.load_spec("full"),
        Bar(height=draw.bar_height, yaw=draw.bar_yaw, tilt=draw.bar_tilt),
    )
    body = spec.body("bar")
    turn = np.array([np.cos(0.5 * TILT), np.sin(0.5 * TILT), 0.0, 0.0])
    body.quat = quat_mul(np.array(body.quat), turn)
    return spec.compile()


def hang_configuration(model: mujoco.MjModel, draw: PullUpDraw) -> Array:
    """(nq,) the dead hang, fingers closed on the bar."""
    x, z, lean = WAY[0, 0], WAY[0, 1], float(np.radians(WAY[0, 2]))
    two = np.ones(2)
    q = np.zeros(22)
    arms = hang_arms(x * two, z * two, lean * two, np.zeros((2, 6)))
    q[:6], q[6:12] = arms[0], arms[1] * MIRROR
    q[12:20] = leg_targets(0.0)
    pinch = pinch_angle(Bar().width)
    q[20:] = pinch
    # the bar's axis passes the middle between the tips, not the closed fingertips
    centre = hand_rotation() @ (finger_tips(pinch).mean(axis=0) + [0.0, 0.0, TIP_ARM])
    R_WB = trunk_rotation(lean)
    p = -(R_WB @ [x, 0.0, z]) - centre * [1.0, 0.0, 1.0]
    turn = quat_mul(rpy_to_quat(0.0, 0.0, draw.bar_yaw), rpy_to_quat(draw.bar_tilt, 0.0, 0.0))
    R = quat_to_mat(turn)
    place = R @ p + [0.0, 0.0, draw.bar_height]
    return model_robot.configuration(model, q, p=place, quat=mat_to_quat(R @ R_WB))


def build_pullup(
    draw: PullUpDraw,
    *,
    config: AdmittanceConfig | None = None,
    together: bool = True,
    tuner: Tuner | None = None,
    times: PullUpTimes | None = None,
) -> tuple[Stack, SimRobot, PullUp]:
    """The whole stack, hanging on its bar with both hands closed."""
    model = bar_model(draw)
    robot = SimRobot(model, variation=draw.variation, qpos=hang_configuration(model, draw))
    for hand, surface in zip(("left", "right"), draw.surfaces, strict=True):
        grasp = PinchGrasp(model, robot.data, hand=hand)
        grasp.close(surface)
        robot.grasps.append(grasp)
    controller = PullUp(
        PullUpScript(times, wait=True), config=config, together=together, tuner=tuner
    )
    estimator = Estimator()
    truth = robot.truth()
    estimator.reset(Pose(p=truth.p_OB, q=truth.q_OB), 0.0)
    stack = Stack(
        robot,
        senses=Senses(seed=draw.seed, noise=draw.noise),
        estimator=estimator,
        machine=ModeMachine(frozenset({Mode.PULL_UP}), mode=Mode.PULL_UP),
        controllers={Mode.PULL_UP: controller},
    )
    return stack, robot, controller


def _wish(belief: StateEstimate) -> ModeCommand:
    return ModeCommand(Mode.PULL_UP, np.zeros(3), belief.stamp)


@dataclass(frozen=True)
class PullUpTrial:
    """One seed."""

    seed: int
    possible: bool
    """Whether the drawn limit surfaces can bear weight and the greatest push at all."""
    success: bool
    why: str
    """What failed; empty where nothing did."""
    truth: PullUpTruth


def run_pullup(
    draw: PullUpDraw,
    *,
    pushes: tuple[float, ...] = PUSHES,
    config: AdmittanceConfig | None = None,
    together: bool = True,
    see: Callable[[Stack, SimRobot, PullUp], None] | None = None,
    limit_s: float = 40.0,
) -> PullUpTrial:
    """One pull-up from dead hang to dead hang.

    Args:
        draw: What differs from the drawing.
        pushes: Down on the trunk while it holds, for 1 s each [N].
        config: Gains instead of the usual ones.
        together: See :class:`mobius.control.pullup.PullUp`.
        see: Called after each tick of 1/600 s, for films.
        limit_s: Longest run [s].
    """
    stack, robot, controller = build_pullup(draw, config=config, together=together)
    judge = PullUpJudge(robot, draw.bar_height)
    script: Any = controller.script
    holds_since, next_push, push = np.inf, 0, None
    while stack.tick * TICK < limit_s:
        now = stack.tick * TICK
        if script.phase is Phase.HOLD and not np.isfinite(holds_since):
            holds_since = now + QUIET_S
        if push is not None and now >= push.ends - 1e-9:
            robot.data.xfrc_applied[judge.trunk, 2] = 0.0
        if script.phase is Phase.HOLD and now >= holds_since - 1e-9:
            if push is not None:
                judge.came_back(push)
                push = None
            if next_push < len(pushes):
                push = Push(pushes[next_push], now, now + PUSH_S)
                judge.before(push)
                robot.data.xfrc_applied[judge.trunk, 2] = -push.force
                holds_since = now + PUSH_S + BACK_S
                next_push += 1
            else:
                script.ask_down()
        stack.turn(_wish)
        judge.see(script.phase, now)
        if see is not None:
            see(stack, robot, controller)
        if controller.state != "running" or judge.fallen:
            break
    return _judged(draw, pushes, judge, controller)


def _judged(
    draw: PullUpDraw, pushes: tuple[float, ...], judge: PullUpJudge, controller: PullUp
) -> PullUpTrial:
    truth = judge.truth()
    why = truth.fault(len(pushes))
    if not why and controller.state != "done":
        why = controller.reason or "not over in time"
    load = 9.81 * (ROBOT_MASS + draw.variation.trunk_mass) + max(pushes, default=0.0)
    return PullUpTrial(draw.seed, is_possible(draw.surfaces, load), not why, why, truth)


def is_possible(surfaces: tuple[LimitSurface, LimitSurface], load: float) -> bool:
    """Whether two grasps bear a vertical load [N], shared equally, with nothing else."""
    across = 0.5 * load * float(np.cos(TILT))
    return all(surface.holds(across) for surface in surfaces)


def stall_shares(points: int = 34) -> Array:
    """(points, 2) share of the way, and of its stall torque what the busiest servo of an arm
    gives there at rest, by statics.
    """
    script = PullUpScript()
    controller = PullUp(script)
    rows = []
    for share in np.linspace(0.0, 1.0, points):
        goal = script.at(float(share))
        q = hang_arms(goal.x_B, goal.z_B, goal.lean)
        torque = hang_torques(goal.lean, q, controller.wish(goal))
        rows.append((share, float(np.abs(torque / STALL).max())))
    return np.array(rows)
