"""One motion on one drawn robot, on the true state: the stage for a search.

The same player, physics, robots, floors and starts as in the trials
(:mod:`mobius.evaluate.trials`), without sensors, estimator and mode machine.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mobius.assemble import variation_of
from mobius.evaluate.trial_start import draw_start
from mobius.geometry import heading_yaw, wrap_angle
from mobius.model.robot import keyframe
from mobius.modes.motions import Motion, MotionPlayer, tilt_of
from mobius.modes.motions.player import MOTION_EVERY, State
from mobius.modes.motions.tilt import wrapped
from mobius.modes.posture import Posture
from mobius.robot import TICK
from mobius.robot.sim import SimRobot
from mobius.types import Mode, ModeCommand

LONGEST_S = 15.0
"""No rehearsal goes on longer [s]."""
SETTLE_S = 1.0
"""The robot comes to rest in its first pose this long before the motion begins [s]."""
REST_S = 0.5
"""The last targets are held this long before it is judged [s]."""
HEIGHT_SCALE = 0.1
"""This much wrong height counts as one [m]."""


@dataclass(frozen=True)
class Rehearsal:
    """How one ended."""

    done: bool
    """Played to its end; else a guard or a condition stopped it."""
    progress: float
    """Share of the stages that were played."""
    pitch_error: float
    """Between the trunk's pitch and that of the posture it should end in [rad]."""
    height_error: float
    """And between their heights [m]."""
    turned: float
    """Change of heading [rad]."""
    seconds: float

    @property
    def cost(self) -> float:
        """0 is perfect: ends where it should, straight, soon. A stopped motion costs 2 to 5."""
        stopped = 0.0 if self.done else 2.0 + 3.0 * (1.0 - self.progress)
        wrong = min(self.pitch_error, 2.0) + min(self.height_error / HEIGHT_SCALE, 1.5)
        return stopped + wrong + 0.5 * min(self.turned, 1.0) + 0.02 * self.seconds


def rehearse(motion: Motion, keyframe_name: str, seed: int) -> Rehearsal:
    """Play a motion once from a keyframe drawn from ``seed``; deterministic."""
    body = "biped" if motion.end is Posture.STANDING else "crawl"
    drawn = draw_start(keyframe_name, body, seed)
    robot = SimRobot(drawn.model, variation=variation_of(drawn.start), qpos=drawn.start.qpos)
    player = MotionPlayer(motion)
    still = ModeCommand(mode=Mode.RECOVER, twist_H=np.zeros(3), stamp=0.0)
    while robot.tick * TICK < SETTLE_S:
        robot.wait()
    first = robot.truth()
    ends = LONGEST_S
    while robot.tick * TICK < ends:
        if robot.tick % MOTION_EVERY == 0:
            robot.write(player.act(still, robot.truth(), robot.read()))
            if player.state is not State.RUNNING:
                ends = min(ends, SETTLE_S + player.elapsed + REST_S)
        robot.wait()
    last = robot.truth()
    wanted = keyframe("stand" if motion.end is Posture.STANDING else "crawl")[0][:7]

    def heading(q: ArrayLike, posture: Posture) -> float:
        return float(heading_yaw("biped" if posture is Posture.STANDING else "crawl", q))

    turned = abs(wrap_angle(heading(last.q_OB, motion.end) - heading(first.q_OB, motion.start)))
    pitch = tilt_of(last.q_OB).pitch_B - tilt_of(wanted[3:]).pitch_B
    return Rehearsal(
        done=player.state is State.DONE,
        progress=player.progress,
        pitch_error=abs(float(wrapped(pitch))),
        height_error=abs(drawn.height(last.p_OB) - float(wanted[2])),
        turned=min(float(turned), float(np.pi - turned)),
        seconds=player.elapsed,
    )
