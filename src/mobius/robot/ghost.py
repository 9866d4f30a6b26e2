"""A kinematic stand-in without physics: joints follow their targets, the trunk follows a twist.

For trying planner, follower, recorder and user interfaces fast. The joints lag by 50 ms; the
trunk goes where it is driven whatever the legs do; torques and wrenches are zero, and the IMU
feels gravity and the yaw rate alone.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.geometry import rpy_to_quat
from mobius.robot.interface import TICK, Simulated
from mobius.robot.limits import limit_targets
from mobius.types import LIMBS, NUM_JOINTS, JointCommand, Pose, SensorFrame, StateEstimate

Array = NDArray[np.float64]
SERVO_LAG = 0.05
"""Time constant of the joints [s]."""


class GhostRobot(Simulated):
    """Robot without mass or forces; :meth:`drive` moves its trunk."""

    def __init__(
        self, q: ArrayLike, *, height: float = 0.275, xy: ArrayLike = (0.0, 0.0), yaw: float = 0.0
    ) -> None:
        """Args: joints q (22,) [rad], trunk ``height`` [m], start ``xy`` [m], ``yaw`` [rad]."""
        self.q: Array = np.array(q, dtype=float)
        self.dq = np.zeros(NUM_JOINTS)
        self._target = self.q.copy()
        self.p = np.array([*np.asarray(xy, dtype=float), height])
        self.yaw, self.tick = float(yaw), 0
        self._twist = np.zeros(3)
        self._vio: Pose | None = self._pose()

    def drive(self, twist_H: ArrayLike) -> None:
        """The trunk moves at vx, vy [m/s], wz [rad/s] from now on."""
        self._twist = np.array(twist_H, dtype=float)

    def _pose(self) -> Pose:
        return Pose(p=self.p, q=rpy_to_quat(0.0, 0.0, self.yaw))

    def read(self) -> SensorFrame:
        """Perfect readings."""
        vio, self._vio = self._vio, None
        return SensorFrame(
            stamp=self.tick * TICK,
            q=self.q,
            dq=self.dq,
            torque=np.zeros(NUM_JOINTS),
            wrench_S=np.zeros((2, 6)),
            gyro_I=np.array([0.0, 0.0, self._twist[2]]),
            accel_I=np.array([0.0, 0.0, 9.81]),
            vio=vio,
        )

    def write(self, command: JointCommand) -> JointCommand:
        """Take targets; returns them as the joint limits let them through."""
        sent = limit_targets(command)
        self._target = np.array(sent.q)
        return sent

    def wait(self) -> None:
        """One tick of kinematics."""
        self.dq = (self._target - self.q) / SERVO_LAG
        self.q = self.q + TICK * self.dq
        c, s = np.cos(self.yaw), np.sin(self.yaw)
        vx, vy, wz = self._twist
        self.p[:2] += TICK * np.array([c * vx - s * vy, s * vx + c * vy])
        self.yaw += TICK * wz
        self.tick += 1
        if self.tick % 3 == 0:
            self._vio = self._pose()

    def truth(self) -> StateEstimate:
        """True trunk state, all limbs in contact."""
        pose = self._pose()
        return StateEstimate(
            stamp=self.tick * TICK,
            p_OB=pose.p,
            q_OB=pose.q,
            v_B=np.array([self._twist[0], self._twist[1], 0.0]),
            w_B=np.array([0.0, 0.0, self._twist[2]]),
            contact=np.ones(len(LIMBS)),
        )
