"""From sensor frames to belief at 300 Hz: IMU, leg odometry, camera, ground and rest.

Each frame the IMU predicts (:mod:`mobius.estimate.iekf`). Limbs that stand
(:mod:`mobius.estimate.contact`) say how fast the trunk moves over their contact points
(:mod:`mobius.estimate.limbs`): ``v_B = -(w x p + dp)``. A limb that disagrees with the
prediction by more than its share loses weight, one that disagrees much is dropped. How far
the others disagree among themselves tells how much they slip, and how little to trust them.
The camera's pose comes late, drifts, drops out and jumps; :class:`InvariantFilter` carries
its track as a second odometer and re-anchors it after gaps and jumps.
"""

from __future__ import annotations

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from mobius.errors import InvalidInput
from mobius.estimate.config import EstimatorConfig
from mobius.estimate.contact import ContactDetector
from mobius.estimate.iekf import InvariantFilter
from mobius.estimate.limbs import LimbKinematics, LimbState, Vector, cross, dot
from mobius.estimate.rotations import yaw_of
from mobius.geometry import mat_to_quat, quat_to_mat, wrap_angle
from mobius.model import LIMB_JOINTS, limb_geometry
from mobius.types import LIMBS, Pose, SensorFrame, StateEstimate

Array = NDArray[np.float64]
G = 9.81
"""[m/s^2]."""
MAX_STEP = 0.1
"""Longest time between two frames that is integrated [s]."""


class Estimator:
    """Turns :class:`SensorFrame` into :class:`StateEstimate`."""

    def __init__(self, config: EstimatorConfig | None = None) -> None:
        self.config = config or EstimatorConfig()
        self._kinematics = [LimbKinematics(limb_geometry(name)) for name in LIMBS]
        self._joints = [LIMB_JOINTS[name] for name in LIMBS]
        self._filter: InvariantFilter | None = None
        self.slip = [np.nan] * len(LIMBS)
        """Speed of each standing limb's contact point over the ground [m/s], order LIMBS; NaN
        where it swings. With :attr:`height` it tells a false contact (fast, high) from wrong
        kinematics (slow, off the ground for good)."""
        self.height = [0.0] * len(LIMBS)
        """Believed height of each limb's contact point [m], order LIMBS."""

    @property
    def filter(self) -> InvariantFilter:
        """The filter's whole state. Raises :class:`InvalidInput` before :meth:`reset`."""
        if self._filter is None:
            raise InvalidInput("the estimator has no start; call reset(pose, stamp) first")
        return self._filter

    @property
    def contact_force(self) -> list[float]:
        """Vertical ground force on each limb [N], order LIMBS."""
        return list(self._contact.force)

    def reset(self, pose: Pose, stamp: float) -> None:
        """Start at rest at ``pose`` of the trunk in odom, at time ``stamp`` [s]."""
        c = self.config
        self._filter = InvariantFilter(pose.p, pose.q, c.noise)
        self._contact = ContactDetector(c.contact)
        self._stamp, self._frames = float(stamp), 0
        self._gyro = np.zeros(3)
        self.slip, self.height = [np.nan] * len(LIMBS), [0.0] * len(LIMBS)
        self._since, self._resting = 0.0, 0.0
        self._standing, self._spread2 = [0.0] * len(LIMBS), 0.0
        self._pose: tuple[float, Pose] | None = None
        self._camera_p: Array | None = None
        self._camera_stamp, self._refused, self._disowned = float(stamp), 0, 0
        N = np.array([c.camera_tilt, c.camera_tilt, c.camera_yaw, 0.0, 0.0, c.camera_height])
        N[3:5] = c.camera_position
        self._camera_noise = np.diag(N**2)
        self._vio, self._legs, self._ground = True, True, True

    def trust(self, *, vio: bool = True, legs: bool = True, ground: bool = True) -> None:
        """Say which sources to hear from now on; after :meth:`reset` all are.

        A source that comes back is not taken at its old word: the camera's track is put on
        ours anew, and what the filter believes of velocity and height becomes less sure.

        Args:
            vio: The camera.
            legs: Limbs that press on the ground do so with their ends. Without it the robot
                may lie and roll on anything; it is taken to rest when gyroscope, joints and
                the size of the specific force say so.
            ground: The ends of limbs that stand are at height zero.
        """
        belief, c = self.filter, self.config
        if legs and not self._legs:
            belief.doubt_velocity(c.doubt**2)
            self._disowned = 0
        if ground and not self._ground and c.ground is not None:
            belief.doubt_height(c.doubt_height**2)
        self._vio, self._legs, self._ground = vio, legs, ground
        self._lying = 0.0

    def update(self, frame: SensorFrame) -> StateEstimate:
        """Take in one frame and say what is believed now."""
        self.take(frame)
        return self.belief()

    def take(self, frame: SensorFrame) -> None:
        """Take in one frame; frames come in order, at most 0.1 s apart."""
        belief = self.filter
        dt = frame.stamp - self._stamp
        if not 0.0 <= dt <= MAX_STEP:
            raise InvalidInput(
                f"Estimator.update: expected a stamp within {MAX_STEP} s after"
                f" {self._stamp:.4f} s, got {frame.stamp:.4f} s; call reset(pose, stamp)"
                " to start anew"
            )
        self._stamp = frame.stamp
        if dt > 0.0:
            belief.predict(frame.gyro_I, frame.accel_I, dt)
        if frame.vio is not None:
            self._pose = (frame.stamp, frame.vio)
        self._since += dt
        if self._frames % self.config.every == 0:
            self._correct(frame)
            self._since = 0.0
        self._frames += 1
        self._gyro = frame.gyro_I

    def belief(self) -> StateEstimate:
        """What is believed after the newest frame; a third of the cost of an update."""
        belief = self.filter
        return StateEstimate(
            stamp=self._stamp,
            p_OB=belief.p,
            q_OB=mat_to_quat(belief.R),
            v_B=belief.v @ belief.R,
            w_B=self._gyro - belief.gyro_bias,
            contact=np.array(self._standing),
            cov=belief.covariance(),
        )

    def _correct(self, frame: SensorFrame) -> None:
        """Hold the prediction against legs, camera, ground and rest."""
        w_B = frame.gyro_I - self.filter.gyro_bias
        limbs = self._limbs(frame)
        if self._legs:
            self._leg_odometry(limbs, w_B)
        else:
            self._lie(frame, w_B)
        self._camera(w_B)
        self._rest(frame)
        if self._frames % (16 * self.config.every) == 0:
            self.filter.clean()

    # -- the sources ---------------------------------------------------------------------

    def _limbs(self, frame: SensorFrame) -> list[LimbState]:
        """Kinematics of the limbs; their contact probabilities are renewed."""
        x, y, z = self.filter.R[2].tolist()
        up: Vector = (complex(x, y), z)
        q, dq, tau = frame.q.tolist(), frame.dq.tolist(), frame.torque.tolist()
        limbs = [k(q[s], dq[s], up) for k, s in zip(self._kinematics, self._joints, strict=True)]
        cranks = [slice(s.start + 1, s.start + 3) for s in self._joints]
        self._standing = self._contact.update(
            limbs,
            up,
            rates=[dq[s] for s in cranks],
            torques=[tau[s] for s in cranks],
            wrench_S=frame.wrench_S.tolist(),
            dt=self._since,
        )
        z = float(self.filter.p[2])
        self.height = [z + dot(up, limb.contact) for limb in limbs]
        return limbs

    def _leg_odometry(self, limbs: list[LimbState], w_B: Array) -> None:
        """Fuse what the standing limbs say of the trunk's velocity, and of its height."""
        c, belief = self.config, self.filter
        wx, wy, wz = w_B.tolist()
        spin: Vector = (complex(wx, wy), wz)
        vx, vy, vz = (belief.v @ belief.R).tolist()
        unsure = belief.P.item(3, 3) + belief.P.item(4, 4) + belief.P.item(5, 5)
        total, flat, up, square, foot_xy, foot_z = 0.0, 0j, 0.0, 0.0, 0j, 0.0
        heard = 0
        for i, (limb, p) in enumerate(zip(limbs, self._standing, strict=True)):
            if p < 0.5:
                self.slip[i] = np.nan
                continue
            turned = cross(spin, limb.contact)
            xy, z = -(turned[0] + limb.velocity[0]), -(turned[1] + limb.velocity[1])
            slip2 = abs(xy - complex(vx, vy)) ** 2 + (z - vz) ** 2
            self.slip[i] = sqrt(slip2)
            ratio = slip2 / (c.slip_gate**2 + unsure)
            if ratio > c.lost_gate**2:
                continue
            weight = p / max(ratio, 1.0)
            heard, total = heard + 1, total + weight
            flat, up = flat + weight * xy, up + weight * z
            square += weight * (abs(xy) ** 2 + z * z)
            foot_xy, foot_z = foot_xy + weight * limb.contact[0], foot_z + weight * limb.contact[1]
        if not heard:
            self._disowned += max(self._standing) >= 0.5
            if self._disowned >= c.legs_patience:
                belief.doubt_velocity(c.doubt**2)
                self._disowned = 0
            return
        self._disowned = 0
        v_B = np.array([flat.real, flat.imag, up]) / total
        if heard > 1:
            blend = self._since / (c.slip_time + self._since)
            self._spread2 += blend * (max(square / total - float(v_B @ v_B), 0.0) - self._spread2)
        variance = (c.slip**2 + c.slip_spread**2 * self._spread2) / total
        if c.ground is None or not self._ground:
            belief.correct_velocity(v_B, variance)
            return
        point_B = np.array([foot_xy.real, foot_xy.imag, foot_z]) / total
        belief.correct_legs(v_B, variance, point_B, c.ground**2)

    def _camera(self, w_B: Array) -> None:
        """Follow the camera's track; put it back on ours when it was lost or has jumped."""
        if self._pose is None:
            return
        c, belief = self.config, self.filter
        (stamp, pose), self._pose = self._pose, None
        if not self._vio:
            return
        latency = c.camera_latency + self._stamp - stamp
        R_VB = quat_to_mat(pose.q)
        last, self._camera_p = self._camera_p, pose.p
        silence, self._camera_stamp = stamp - self._camera_stamp, stamp
        contradicted = self._refused >= c.camera_patience
        if last is not None and silence <= c.camera_gap and not contradicted:
            belief.move_camera(pose.p - last)
            distance = belief.correct_camera(
                R_VB, w_B, latency, N=self._camera_noise, gate=c.camera_gate
            )
            self._refused = self._refused + 1 if distance > c.camera_gate else 0
            return
        if contradicted:
            belief.doubt_velocity(c.doubt**2)
        heading = yaw_of(belief.R @ R_VB.T)
        turned = abs(float(wrap_angle(heading - belief.rest[9]))) > c.camera_turn
        belief.anchor_camera(
            latency,
            position_variance=c.camera_position**2,
            yaw_variance=c.camera_jump**2,
            yaw=heading if last is None or turned else None,
        )
        self._refused = 0

    def _rest(self, frame: SensorFrame) -> None:
        """A robot that stands still on all limbs does not turn: what the gyro says is bias."""
        c = self.config
        still = (
            self._legs and min(self._standing) > 0.5 and float(np.abs(frame.dq).max()) < c.rest_rate
        )
        self._resting = self._resting + self._since if still else 0.0
        if self._resting > 0.2:
            self.filter.correct_rest(frame.gyro_I, c.rest_gyro**2)

    def _lie(self, frame: SensorFrame, w_B: Array) -> None:
        """A robot that lies still, on whatever, has no velocity and does not turn."""
        c = self.config
        self.slip = [np.nan] * len(LIMBS)
        force = float(np.linalg.norm(frame.accel_I))
        still = (
            float(np.abs(frame.dq).max()) < c.lie_rate
            and float(np.abs(w_B).max()) < c.lie_turn
            and abs(force - G) < c.lie_force
        )
        self._lying = self._lying + self._since if still else 0.0
        if self._lying > c.lie_time:
            self.filter.correct_velocity(np.zeros(3), c.lie_velocity**2)
            self.filter.correct_rest(frame.gyro_I, c.rest_gyro**2)
