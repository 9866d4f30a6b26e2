"""The pull-up's controller: script -> admittance of both hands -> arms -> servo targets, 300 Hz.

Both hands hold one rigid bar, so six of the twelve directions in which they can push move
nothing: there the arms can only fight. The law therefore works on the mean of both hands and on
half their difference, each in the mirrored axes of :mod:`mobius.model.hang`::

    mean  along the bar, torsion   inner forces: regulated to the script's (force control)
    mean  across, pinch normal     height and swing of the trunk: a spring that gives way and
                                   brings it back (impedance)
    mean  about the bar            moment of a trunk that does not hang under its bar: gives a
                                   little
    difference                     trunk's sway, roll and yaw: stiff

A grip that a push has turned about the bar is felt as a lean that the arms do not explain, and
the wrists take it back (:attr:`PullUp.pivot`).

With ``together=False`` each hand runs the law for itself, as in the paper. A servo's target is
the angle plus the torque that the wished wrench needs, over the servo's stiffness.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mobius.control.admittance import Admittance, AdmittanceConfig, WrenchConditioner, Wrenches
from mobius.control.admittance.loop import mobius_config
from mobius.control.pullup_goal import Goal, Script
from mobius.control.tuning import Tuner
from mobius.geometry import quat_to_mat
from mobius.model import dimensions as dim
from mobius.model.arm import gripper_pose
from mobius.model.build import joint_ranges
from mobius.model.dimensions import limb_geometry
from mobius.model.hang import (
    MIRROR,
    MIRROR_WRENCH,
    STIFFNESS,
    hand_rotation,
    hang_arms,
    hang_torques,
)
from mobius.model.joints import JOINTS, LIMB_JOINTS
from mobius.types import NUM_JOINTS, JointCommand, ModeCommand, SensorFrame, StateEstimate

__all__ = ["PullUp", "leg_targets", "pullup_config"]

Array = NDArray[np.float64]

EVERY = 2
"""Ticks of 1/600 s between two acts: 300 Hz."""
LOST = 0.2
"""A hand that bears less than this share of half the weight has lost the bar,"""
LOST_S = 0.1
"""when it does so for this long [s]."""
SILENT_S = 0.5
"""A wrist may say nothing for so long [s]; the law holds meanwhile. Then the robot goes down."""
PIVOT_SHARE, PIVOT_MOST = 0.01, 0.025
"""Share of a new reading of the pivot in its filter (0.3 s), greatest correction [rad]."""
PIVOT_CALM = 4.0
"""While a hand bears this much more or less than half the weight, nothing is learnt [N]."""
OPEN = 0.9
"""Gripper angle that lets go [rad]."""
_ARM = limb_geometry("left_arm")
_BOTH = np.array([[0.5, 0.5], [0.5, -0.5]])
_APART = np.array([[1.0, 1.0], [1.0, -1.0]])
_RANGES = joint_ranges()
_LOW, _HIGH = (np.array([_RANGES[j][k] for j in JOINTS[:6]]) for k in (0, 1))


def pullup_config(**changes: object) -> AdmittanceConfig:
    """Gains of the mean of both hands; axes along the bar, pinch normal, across, and about them.

    A push of 30 N on the trunk is 15 N a hand and gives 3 cm beside what the servos give; it
    comes back with D / K = 0.7 s. ``changes`` are fields of AdmittanceConfig.
    """
    base = mobius_config(
        mass=np.array([2.0, 4.0, 4.0, 0.05, 0.05, 0.05]),
        damping=np.array([400.0, 350.0, 350.0, 5.0, 20.0, 20.0]),
        stiffness=np.array([20.0, 500.0, 500.0, 15.0, 10.0, 10.0]),
        selected_axes=np.array([True, True, True, True, True, False]),
        position_min=np.array([-0.05, -0.08, -0.08, -0.07, -0.1, -0.1]),
        position_max=np.array([0.05, 0.08, 0.08, 0.07, 0.1, 0.1]),
        control_frame_id="gripper",
    )
    return replace(base, **changes)  # type: ignore[arg-type]


def leg_targets(up: float) -> Array:
    """(8,) left and right leg [rad]: hanging (0) to drawn up in front of the belly (1)."""
    down, out = 0.03 + up * (0.33 - 0.03), 0.32 + up * (0.05 - 0.32)
    pitch = (1.0 - up) * 0.5 * np.pi
    fivebar = limb_geometry("left_leg").fivebar
    a, b = (float(v) for v in fivebar.ik(down, out))
    ankle = pitch - float(fivebar.distal_angle(a, b))
    yaw = 0.5 * np.pi
    return np.array([yaw, a, b, ankle, -yaw, a, b, ankle])


class PullUp:
    """A :class:`mobius.stack.Controller`: the robot hangs on both grasps when it begins."""

    every = EVERY

    def __init__(
        self,
        script: Script,
        *,
        config: AdmittanceConfig | None = None,
        together: bool = True,
        tuner: Tuner | None = None,
    ) -> None:
        """One pull-up.

        Args:
            script: Where the goals come from.
            config: Gains; :func:`pullup_config` if not given.
            together: Whether the law works on mean and difference, or on each hand alone.
            tuner: Tunes the force control along the bar while the robot hangs (optional; of one
                axis with ``together``, else of two).
        """
        self.script, self.together, self.tuner = script, together, tuner
        mean = config or pullup_config()
        second = replace(mean, selected_axes=np.zeros(6, dtype=bool)) if together else mean
        self.law = Admittance((mean, second))
        self.wrench = WrenchConditioner((mean, mean))
        R_WG = hand_rotation()
        self._up_S = np.tile(R_WG[2], (2, 1))
        self._still = np.tile(np.eye(3), (2, 1, 1))
        self._weight_G = R_WG.T @ np.array([0.0, 0.0, 1.0])
        self._along_G = R_WG.T @ np.array([0.0, 1.0, 0.0])
        self.reset()

    def reset(self) -> None:
        """Start anew, in the dead hang."""
        self.script.reset()
        self.law.reset()
        self.wrench.reset()
        self.half_weight = 0.5 * 9.81 * dim.ROBOT_MASS
        """What each hand bears, as weighed while hanging [N]."""
        self.state, self.reason = "running", ""
        self.heard = np.zeros((2, 6))
        """Wrench by the bar on each hand, hand axes, mirrored [N, N m]."""
        self.wished = np.zeros(6)
        """The same as wished, for both hands."""
        self._weighed, self._samples = 0.0, 0
        self.pivot = 0.0
        """How far the hands have turned about the bar since the dead hang, back [rad]."""
        self._unexplained, self._level = 0.0, 0.0
        self._began: float | None = None
        self._lost_since = np.inf
        self._last_along = np.zeros(2)
        if self.tuner is not None:
            self.tuner.forget()
        self._arms: Array | None = None

    def act(self, command: ModeCommand, belief: StateEstimate, frame: SensorFrame) -> JointCommand:
        """Targets of all joints for this tick."""
        goal = self.script.step(frame.stamp)
        wrenches = self.wrench.update(
            self._readings(frame), self._up_S, self._still, age=frame.wrench_age
        )
        self.heard = wrenches.wrench_C
        if wrenches.fresh.all():  # nothing is learnt from what was heard before
            self._weigh(goal, frame.stamp)
            self._feel_pivot(goal, belief, frame)
        self._watch(goal, frame.stamp)
        if (frame.wrench_age > SILENT_S).any():
            self.script.abort("a wrist has said nothing for too long")
        self.wished = self.wish(goal)
        shared = self._shared(wrenches)
        if self.tuner is not None:
            self._tune(self.tuner, shared)
        motion = self.law.step(shared, np.zeros((2, 6)), self._references())
        moved = _APART @ motion.x if self.together else motion.x
        moved[:, 3] -= self.pivot
        targets = np.zeros(NUM_JOINTS)
        targets[:12] = self._arm_targets(goal, moved)
        targets[LIMB_JOINTS["left_leg"].start : LIMB_JOINTS["right_leg"].stop] = leg_targets(
            goal.legs
        )
        targets[20:] = 0.0 if goal.grip else OPEN
        if goal.phase == "done":
            self.state = "done"
        elif not goal.grip:
            self.state, self.reason = "failed", self.script.reason
        return JointCommand(q=targets, stamp=frame.stamp)

    def wish(self, goal: Goal) -> Array:
        """(6,) wrench by the bar on the left hand that goes with a goal, hand axes."""
        force = self.half_weight * self._weight_G + goal.along * self._along_G
        moment = goal.moments * np.array([self.half_weight, 1.0, 1.0])
        return np.concatenate([force, moment])

    # -- inside ----------------------------------------------------------------------------

    def _readings(self, frame: SensorFrame) -> Array:
        return frame.wrench_S * np.stack([np.ones(6), MIRROR_WRENCH])

    def _shared(self, wrenches: Wrenches) -> Wrenches:
        """Mean and half difference of what both hands hear; neither is heard with one lost."""
        if not self.together:
            return wrenches
        fresh = np.full(2, bool(wrenches.fresh.all()))
        return Wrenches(_BOTH @ wrenches.wrench_C, _BOTH @ wrenches.raw_C, fresh, wrenches.clipped)

    def _tune(self, tuner: Tuner, wrenches: Wrenches) -> None:
        """Show the tuner a tick of the axis along the bar and take its gains."""
        n = tuner.n
        report = tuner.observe(
            self.law.state[:n, 0],
            wrenches.raw_C[:n, 0],
            self._references()[:n, 0],
            filtered=self._last_along[:n],
            ok=bool(wrenches.fresh.all()),
        )
        self._last_along = wrenches.wrench_C[:, 0].copy()
        if report is not None and report.verdict in ("taken", "shrunk"):
            for arm in range(n):
                self.law.set_gains(arm, "x", report.gains)

    def _references(self) -> Array:
        second = np.zeros(6) if self.together else self.wished
        return np.stack([self.wished, second])

    def _weigh(self, goal: Goal, now: float) -> None:
        """The mean of both hands' load in the quiet half of the dead hang."""
        if self._began is None:
            self._began = now
        if goal.phase != "hang" or now - self._began < 0.6:
            return
        self._weighed += float(self.heard.mean(axis=0)[:3] @ self._weight_G)
        self._samples += 1
        self.half_weight = self._weighed / self._samples

    def _feel_pivot(self, goal: Goal, belief: StateEstimate, frame: SensorFrame) -> None:
        """Lean of the trunk that the arms' angles do not explain, against the dead hang's."""
        arms = frame.q[:12].reshape(2, 6) * np.stack([np.ones(6), MIRROR])
        up_B = 0.5 * (gripper_pose(_ARM, arms)[1] @ self._weight_G).sum(axis=0)
        by_arms = float(np.arctan2(-up_B[2], up_B[0]))
        up_B = quat_to_mat(belief.q_OB)[2]
        unexplained = float(np.arctan2(-up_B[2], up_B[0])) - by_arms
        load = float(self.heard.mean(axis=0)[:3] @ self._weight_G)
        if abs(load - self.half_weight) < PIVOT_CALM:  # what gives way under a push comes back
            self._unexplained += PIVOT_SHARE * (unexplained - self._unexplained)
        if goal.phase == "hang":
            self._unexplained = self._level = self._level + 0.02 * (unexplained - self._level)
        turned = self._unexplained - self._level
        self.pivot = min(max(turned, -PIVOT_MOST), PIVOT_MOST)

    def _watch(self, goal: Goal, now: float) -> None:
        """Abort when a hand no longer bears its share."""
        least = float((self.heard[:, :3] @ self._weight_G).min())
        lost = least < LOST * self.half_weight and self._samples > 0
        self._lost_since = min(self._lost_since, now) if lost else np.inf
        if now - self._lost_since > LOST_S:
            self.script.abort("a hand has lost the bar")

    def _arm_targets(self, goal: Goal, moved: Array) -> Array:
        """(12,) both arms: where the hands shall be, and what the servos give way."""
        two = np.ones(2)
        q = hang_arms(goal.x_B * two, goal.z_B * two, goal.lean * two, moved)
        good = np.isfinite(q).all(axis=1) & (q[:, 2] - q[:, 1] >= dim.MIN_CRANK_SPREAD)
        if self._arms is not None:
            q = np.where(good[:, None], q, self._arms)
        q = np.clip(q, _LOW, _HIGH)
        self._arms = q
        sag = hang_torques(goal.lean * two, q, np.tile(self.wished, (2, 1))) / STIFFNESS
        out: Array = (q + sag) * np.stack([np.ones(6), MIRROR])
        return out.ravel()
