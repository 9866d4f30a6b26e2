"""The force loop of both arms, 300 Hz: wrenches -> admittance -> governor -> IK -> targets.

Deviations are counted from the gripper poses at :meth:`ForceLoop.start`, in the trunk's axes
or in those of the gripper at that moment. Where the arm cannot reach what the law commands,
the arm keeps its last targets, the law is set back to what they are, and that is told.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.control.admittance.arms import arms_ik, arms_pose, arms_rotation
from mobius.control.admittance.config import AdmittanceConfig, FtSensor, GravityCompensation
from mobius.control.admittance.controller import Admittance, Governed, Governor, Motion
from mobius.control.admittance.law import SERVO_LAG
from mobius.control.admittance.wrench import WrenchConditioner, Wrenches
from mobius.errors import InvalidInput
from mobius.geometry import exp_so3, quat_to_mat
from mobius.model import dimensions as dim
from mobius.model.build import joint_ranges
from mobius.model.joints import JOINTS
from mobius.types import NUM_JOINTS, JointCommand, SensorFrame, frozen_array

__all__ = ["ForceLoop", "LoopOutput", "mobius_config", "mobius_tool"]

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

ARMS = slice(0, 12)
"""Left and right arm in a joint vector."""
SENSOR_Z = -0.024
"""The wrist's sensor from the wrist centre along the gripper's z [m], as in the MJCF."""
_RANGES = joint_ranges()
_LOW, _HIGH = (np.array([_RANGES[j][k] for j in JOINTS[ARMS]]).reshape(2, 6) for k in (0, 1))


def mobius_tool() -> GravityCompensation:
    """What hangs on a wrist's sensor: yaw servo, sensor, palm and fingers (MJCF: the body's
    joint to the rest of the wrist is where a simulated sensor measures).
    """
    m = dim.MASS_ARM
    finger = -dim.FINGER_PIVOT[1] - 0.5 * dim.FINGER_KNEE[1] - 0.25 * dim.FINGER_TIP[1]
    parts = [
        (m["wrist_yaw"], -0.004),
        (m["ft_sensor"], SENSOR_Z),
        (m["palm"], -0.042),
        (2 * m["finger"], finger),
    ]
    mass = sum(kg for kg, _z in parts)
    z = sum(kg * z for kg, z in parts) / mass
    return GravityCompensation(cog_pos=np.array([0.0, 0.0, z - SENSOR_Z]), cog_force=9.81 * mass)


def mobius_config(**changes: object) -> AdmittanceConfig:
    """A configuration with this robot's tool and (simulated) sensor; ``changes`` are fields of
    AdmittanceConfig.
    """
    sensor = FtSensor(sign=-1, tip=np.array([0.0, 0.0, -dim.TIP_ARM - SENSOR_Z]))
    base = AdmittanceConfig(gravity_compensation=mobius_tool(), ft_sensor=sensor)
    return replace(base, **changes)  # type: ignore[arg-type]


@dataclass(frozen=True, eq=False)
class LoopOutput:
    """One tick of the force loop."""

    command: JointCommand
    """Targets of all joints; those that are not the arms' stay as at the start."""
    motion: Motion
    """What the law commands, and what was clipped."""
    wrenches: Wrenches
    """What it heard, axes C."""
    unreachable: Flags
    """(2,) left and right arm that kept its last targets."""


class ForceLoop:
    """Both arms under admittance control."""

    def __init__(
        self,
        left: AdmittanceConfig,
        right: AdmittanceConfig,
        *,
        tau: float = SERVO_LAG,
        governors: Mapping[tuple[int, Governed], Governor] | None = None,
    ) -> None:
        """Two arms, left is 0 and right is 1 everywhere.

        Args:
            left: Configuration.
            right: Configuration.
            tau: Servo lag in the state that governors see [s].
            governors: By arm and axis, ``{(0, "z"): governor}``, or axes that one governor
                serves together, ``{(0, ("x", "y")): governor}``.
        """
        configs: Sequence[AdmittanceConfig] = (left, right)
        self.law = Admittance(configs, tau=tau, governors=governors)
        self.wrench = WrenchConditioner(configs)
        self._own_axes = np.array([c.control_frame_id == "gripper" for c in configs])
        self.x_ref = np.zeros((2, 6))
        """(2, 6) wished deviation of each gripper [m, rad]."""
        self.wrench_reference = np.zeros((2, 6))
        """(2, 6) wished wrench by the environment on each gripper [N, N m]."""
        self._targets: Array | None = None

    def start(self, targets: ArrayLike) -> None:
        """Take over from joint targets (22,) [rad] without a jump: x is zero there."""
        frozen_array(self, "_targets", targets, (NUM_JOINTS,))
        assert self._targets is not None
        q = self._targets[ARMS].reshape(2, 6)
        self.p0_B, self.R0_BG = arms_pose(q)
        if not np.isfinite(self.p0_B).all():
            raise InvalidInput("ForceLoop.start: these targets are no pose of the arms")
        self.R_BC = np.where(self._own_axes[:, None, None], self.R0_BG, np.eye(3))
        self._arms = q.copy()
        self.law.reset()
        self.wrench.reset()

    def frames(self, frame: SensorFrame, q_WB: ArrayLike) -> tuple[Array, Array]:
        """World's z axis (2, 3) in each sensor's axes, and R_CS (2, 3, 3)."""
        R_BG = arms_rotation(frame.q[ARMS].reshape(2, 6))
        up_B = quat_to_mat(q_WB)[2]
        return up_B @ R_BG, np.swapaxes(self.R_BC, -1, -2) @ R_BG

    def tare(self, frame: SensorFrame, q_WB: ArrayLike) -> None:
        """Let what the wrists feel now count as no load (Sec. V-G4, hanging at the start)."""
        up_S, R_CS = self.frames(frame, q_WB)
        self.wrench.tare_load(frame.wrench_S, up_S, R_CS)

    def step(
        self,
        frame: SensorFrame,
        q_WB: ArrayLike,
        *,
        wrench_S: Array | None = None,
        age: Array | float | None = None,
    ) -> LoopOutput:
        """One tick.

        Args:
            frame: The newest readings.
            q_WB: (4,) believed attitude of the trunk, wxyz; only its tilt matters.
            wrench_S: (2, 6) instead of the frame's wrenches; NaN where a sensor is silent.
            age: (2,) of the wrenches [s]; if not given, the frame's for its own ones and 0 for
                ``wrench_S``.
        """
        if self._targets is None:
            raise InvalidInput("ForceLoop.step: call start(targets) first")
        up_S, R_CS = self.frames(frame, q_WB)
        readings = frame.wrench_S if wrench_S is None else wrench_S
        if age is None:
            age = frame.wrench_age if wrench_S is None else 0.0
        wrenches = self.wrench.update(readings, up_S, R_CS, age=age)
        before = self.law.state.copy()
        motion = self.law.step(wrenches, self.x_ref, self.wrench_reference)
        q = self._joints(motion.x)
        inside = np.isfinite(q) & (q >= _LOW) & (q <= _HIGH)
        inside[:, 0] &= q[:, 2] - q[:, 1] >= dim.MIN_CRANK_SPREAD
        bad: Flags = np.logical_not(inside.all(axis=1))
        if bad.any():
            q = np.where(bad[:, None], self._arms, q)
            self.law.stand(bad, before)
        self._arms = q
        targets = np.array(self._targets)
        targets[ARMS] = q.ravel()
        return LoopOutput(JointCommand(targets, frame.stamp), motion, wrenches, bad)

    def _joints(self, x: Array) -> Array:
        """Arm angles (2, 6) of deviations x (2, 6); NaN where out of reach."""
        p = self.p0_B + (self.R_BC @ x[:, :3, None])[..., 0]
        turn = np.stack([exp_so3(self.R_BC[k] @ x[k, 3:]) for k in (0, 1)])
        return arms_ik(p, turn @ self.R0_BG)
