"""Motions with exact kinematics: a trunk that moves, feet that stay where they stand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from mobius.estimate.contact import GRIPPER_MASS, TorqueForce
from mobius.estimate.limbs import LimbKinematics
from mobius.geometry import quat_conj, quat_mul, quat_to_mat, rotate, rpy_to_quat
from mobius.model import LIMB_JOINTS, limb_geometry
from mobius.model import dimensions as dim
from mobius.model.arm import gripper_ik, gripper_pose
from mobius.model.leg import sole_ik, sole_position
from mobius.model.robot import keyframe_joints
from mobius.types import LIMBS, Pose, SensorFrame, StateEstimate

DT = 1 / 300
HEIGHT = 0.275
GEOMETRY = [limb_geometry(name) for name in LIMBS]
STANCE = keyframe_joints("crawl")[0]
FOOT_MIDDLE = 0.5 * (dim.FOOT_HEEL - dim.FOOT_TOE)


@dataclass(frozen=True)
class Motion:
    """Level crawl at a constant twist, with sway; or arms only, with tilt."""

    seconds: float = 3.5
    twist: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """vx, vy [m/s], wz [rad/s]; the trunk starts and walks smoothly."""
    sway: float = 0.01
    """[m] in y and z."""
    tilt: float = 0.0
    """[rad]; with tilt only the arms stand: their wrists keep the grippers upright."""
    step_hz: float = 2.0
    start: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """x, y [m], yaw [rad]."""
    latency: float = 0.0
    """Of the camera [s]."""

    def pose(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """p_OB (n, 3), q_OB (n, 4)."""
        vx, vy, wz = self.twist
        ramp = np.where(t < 1.0, 0.5 * t**2, t - 0.5) * (t > 0)
        yaw = wz * ramp
        wave = 2 * np.pi * 0.8 * t
        ease = np.clip(t, 0.0, 1.0) ** 2 * (3 - 2 * np.clip(t, 0.0, 1.0))
        ahead, aside = (np.sin(yaw) / wz, (1 - np.cos(yaw)) / wz) if wz else (ramp, 0.0 * ramp)
        x, y = vx * ahead - vy * aside, vx * aside + vy * ahead
        sway = self.sway * ease * np.sin(wave)
        p = np.stack([x, y + sway, HEIGHT + 0.5 * sway], axis=-1)
        q = rpy_to_quat(self.tilt * ease * np.sin(wave), self.tilt * ease * np.cos(wave), yaw)
        x0, y0, yaw0 = self.start
        q0 = rpy_to_quat(0.0, 0.0, yaw0)
        return rotate(q0, p) + np.array([x0, y0, 0.0]), quat_mul(q0, q)

    def foot(self, limb: int, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Ground points (n, 3) in O and whether they stand (n,); a diagonal trot, 60 % down."""
        g = GEOMETRY[limb]
        nominal = _contact_of(g, STANCE[LIMB_JOINTS[g.name]])
        if not any(self.twist):
            return np.broadcast_to(self._place(nominal, np.zeros(1)), (len(t), 3)), t > -1
        phase = t * self.step_hz + (0.0, 0.5, 0.5, 0.0)[limb]
        step, part = np.floor(phase), phase % 1.0
        now = self._place(nominal, (step + 0.3 - (phase - t * self.step_hz)) / self.step_hz)
        then = self._place(nominal, (step + 1.3 - (phase - t * self.step_hz)) / self.step_hz)
        u = np.clip((part - 0.6) / 0.4, 0.0, 1.0)[:, None]
        smooth = u**3 * (10 - 15 * u + 6 * u**2)
        at = now + smooth * (then - now)
        at[:, 2:] += 0.04 * np.sin(np.pi * u) ** 2
        return at, (part > 0.02) & (part < 0.58)

    def _place(self, nominal: np.ndarray, t: np.ndarray) -> np.ndarray:
        p, q = self.pose(t)
        at = p + rotate(q, np.broadcast_to(nominal, p.shape))
        at[:, 2] = 0.0
        return at

    def joints(self, t: np.ndarray) -> np.ndarray:
        """Encoder angles (n, 22)."""
        p, quat = self.pose(t)
        out = np.tile(STANCE, (len(t), 1))
        for i, g in enumerate(GEOMETRY):
            if self.tilt and not g.is_arm:
                continue
            foot = rotate(quat_conj(quat), self.foot(i, t)[0] - p)
            if g.is_arm:
                upright = gripper_pose(g, STANCE[LIMB_JOINTS[g.name]])[1]
                R_BG = np.swapaxes(quat_to_mat(quat), -1, -2) @ upright
                out[:, LIMB_JOINTS[g.name]] = gripper_ik(g, foot, R_BG)
            else:
                away = foot - g.hip_B
                away[:, 2] = 0.0
                away /= np.linalg.norm(away, axis=1, keepdims=True)
                out[:, LIMB_JOINTS[g.name]] = sole_ik(g, foot - FOOT_MIDDLE * away)
        return out


@dataclass(frozen=True)
class Run:
    """Frames and truth of one motion."""

    frames: list[SensorFrame]
    p: np.ndarray
    q: np.ndarray
    v_B: np.ndarray
    w_B: np.ndarray
    standing: np.ndarray

    def start(self) -> Pose:
        return Pose(p=self.p[0], q=self.q[0])


def _contact_of(g, q: np.ndarray) -> np.ndarray:
    return gripper_pose(g, q)[0] if g.is_arm else sole_position(g, q)


def _imu(p: np.ndarray, q: np.ndarray, h: float) -> tuple[np.ndarray, ...]:
    """Velocity, rate and specific force of a path sampled at t - h, t, t + h (3, n, .)."""
    v = (p[2] - p[0]) / (2 * h)
    a = (p[2] - 2 * p[1] + p[0]) / h**2
    turn = quat_mul(quat_conj(q[0]), q[2])
    w = turn[:, 1:] * np.sign(turn[:, :1]) / h
    back = quat_conj(q[1])
    return rotate(back, v), w, rotate(back, a + np.array([0.0, 0.0, 9.81]))


def _pushed(
    frames: list[SensorFrame], q_OB: np.ndarray, standing: np.ndarray, force: float
) -> list[SensorFrame]:
    """The frames with the torques and wrenches of ``force`` [N] under every standing limb."""
    n = len(frames)
    torque, wrench = np.zeros((n, 22)), np.zeros((n, 2, 6))
    up_B = quat_to_mat(q_OB)[:, 2]
    for i, g in enumerate(GEOMETRY):
        s, kinematics, mass = LIMB_JOINTS[g.name], LimbKinematics(g), TorqueForce(g.name, 1.0)
        cranks = slice(s.start + 1, s.start + 3)
        momentum = np.zeros((n, 2))
        for k, (frame, (x, y, z)) in enumerate(zip(frames, up_B.tolist(), strict=True)):
            limb = kinematics(frame.q[s].tolist(), frame.dq[s].tolist(), (complex(x, y), z))
            lift = complex(-z, (limb.out.conjugate() * complex(x, y)).real)
            weight, (m_aa, m_ab, m_bb) = mass._weight_and_inertia(limb, lift)
            momentum[k] = np.array([[m_aa, m_ab], [m_ab, m_bb]]) @ frame.dq[cranks]
            ground = [(lift.conjugate() * drive).real * force for drive in limb.contact_drive]
            torque[k, cranks] = weight - standing[k, i] * np.array(ground)
            if g.is_arm:
                up_G = [(a.conjugate() * complex(x, y)).real + b * z for a, b in limb.axes]
                wrench[k, i, :3] = up_G
                wrench[k, i, :3] *= 9.81 * GRIPPER_MASS - standing[k, i] * force
        torque[:, cranks] += np.gradient(momentum, DT, axis=0)
    return [replace(frame, torque=torque[k], wrench_S=wrench[k]) for k, frame in enumerate(frames)]


def make_run(motion: Motion) -> Run:
    """Perfect readings of a motion at 300 Hz, the camera in two frames of three."""
    t = np.arange(round(motion.seconds / DT)) * DT
    h = 1e-4
    around = [motion.pose(t + d) for d in (-h, 0.0, h)]
    v_B, w_B, accel = _imu(np.array([a[0] for a in around]), np.array([a[1] for a in around]), h)
    p, q = around[1]
    joints = motion.joints(t)
    rates = (motion.joints(t + h) - motion.joints(t - h)) / (2 * h)
    standing = np.stack([motion.foot(i, t)[1] for i in range(4)], axis=1)
    if motion.tilt:
        standing[:, 2:] = False
    seen_p, seen_q = motion.pose(np.maximum(t - motion.latency, 0.0))
    frames = []
    for k in range(len(t)):
        frame = SensorFrame(
            stamp=t[k],
            q=joints[k],
            dq=rates[k],
            torque=np.zeros(22),
            wrench_S=np.zeros((2, 6)),
            gyro_I=w_B[k],
            accel_I=accel[k],
            vio=Pose(p=seen_p[k], q=seen_q[k]) if k % 3 != 1 else None,
        )
        frames.append(frame)
    return Run(_pushed(frames, q, standing, 30.0), p, q, v_B, w_B, standing)


@pytest.fixture(scope="session")
def motion() -> Callable[..., Run]:
    """Readings and truth of a :class:`Motion`, made once for equal arguments."""
    made: dict[Motion, Run] = {}

    def get(**options) -> Run:
        key = Motion(**options)
        if key not in made:
            made[key] = make_run(key)
        return made[key]

    return get


@pytest.fixture(scope="session")
def without_camera() -> Callable[[list[SensorFrame]], list[SensorFrame]]:
    return lambda frames: [replace(f, vio=None) for f in frames]


@pytest.fixture(scope="session")
def errors() -> Callable[..., dict[str, np.ndarray]]:
    """Believed minus true: p (n, 3) [m], v (n, 3) [m/s], turn (n, 3) [rad], axes of O."""

    def get(beliefs: list[StateEstimate], run: Run) -> dict[str, np.ndarray]:
        n = len(beliefs)
        turn = quat_mul(np.array([b.q_OB for b in beliefs]), quat_conj(run.q[:n]))
        return {
            "p": np.array([b.p_OB for b in beliefs]) - run.p[:n],
            "v": np.array([b.v_B for b in beliefs]) - run.v_B[:n],
            "turn": 2 * turn[:, 1:] * np.sign(turn[:, :1]),
        }

    return get
