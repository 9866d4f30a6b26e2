"""Both simulated arms on a fixed trunk, with springs, walls and outside forces at the hands.

The robot of the stack without its legs: servos with their torque-speed lines and dry friction,
five-bars, link inertia, tool weight, noise and drift of the wrists; physics at 1/600 s, two steps
a tick of the force loop. Contacts are forces at the fingertips, so that the stiffness is known.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import mujoco
import numpy as np
from numpy.typing import NDArray

from mobius import paper
from mobius.geometry import cross
from mobius.model.joints import JOINTS
from mobius.model.passive import passive_angles
from mobius.model.robot import keyframe_joints, load_spec
from mobius.sense.noise import WrenchNoise
from mobius.types import NUM_JOINTS, SensorFrame

__all__ = ["LEVEL", "ArmRig", "Contacts", "Moment"]

Array = NDArray[np.float64]

LEVEL = np.array([1.0, 0.0, 0.0, 0.0])
"""Attitude of the trunk, wxyz."""
POSE = np.array([-0.58, -0.15, 2.27, -0.41, 0.21, -0.26])
"""Left arm [rad]; from here the hand reaches 0.09 m both ways along x, y and z, one at a time and
12 mm beside it, and nearly all of 0.12 m. The workspace is a shell: a random search found no pose
with a cube of 0.2 m around it."""
MIRROR = np.array([-1.0, 1.0, 1.0, 1.0, -1.0, -1.0])
"""Signs of the right arm's joints in the mirror."""
STEPS = 2
"""Physics steps a tick."""
GRIPPERS = ("left_gripper", "right_gripper")
GRIPPER_AT = [JOINTS.index(j) for j in GRIPPERS]
SETTLE_S = 1.5
"""The arms sag and come to rest first."""


@dataclass(frozen=True, eq=False)
class Contacts:
    """What pushes on each hand along each axis during a tick; (2, 3) each."""

    k_env: Array
    """Stiffness [N/m]."""
    wall: Array
    """0: a spring at rest at 0, both ways; else the sign is the side of a wall that only pushes,
    and it is touched beyond \\|wall\\| [m]."""
    force: Array
    """Outside force [N]."""

    def wrench(self, x: Array) -> Array:
        """Force (2, 3) on hands at x (2, 3) [m]."""
        deep = np.sign(self.wall) * np.maximum(np.sign(self.wall) * x - np.abs(self.wall), 0.0)
        return self.force - self.k_env * np.where(self.wall == 0.0, x, deep)


@dataclass(frozen=True, eq=False)
class Moment:
    """The truth at the physics steps of a tick; (steps, 2, 3) each, trunk axes."""

    x: Array
    """Hands from where they settled [m]."""
    v: Array
    """[m/s]."""
    wrench: Array
    """By the environment on the hands [N]."""


class ArmRig:
    """The simulated arms."""

    def __init__(self, seed: int) -> None:
        """Build and let settle.

        Args:
            seed: Of the wrists' noise, bias and drift.
        """
        self.model, self.targets = _model()
        self.data = mujoco.MjData(self.model)
        self._noise = WrenchNoise(np.random.default_rng([seed, 20]))
        joints = [self.model.joint(j) for j in JOINTS[:12]]
        self._q = [int(j.qposadr[0]) for j in joints]
        self._dof = [int(j.dofadr[0]) for j in joints]
        self._motor = [self.model.actuator(j).id for j in JOINTS[:12]]
        sides = ("left", "right")
        self._tip = [self.model.site(f"{s}_arm_tip").id for s in sides]
        self._hand = [self.model.body(f"{s}_arm_gripper_base").id for s in sides]
        self._wrist = [int(self.model.sensor(f"{s}_wrist_force").adr[0]) for s in sides]
        self.ticks = 0
        self.data.qpos[:] = _assembled(self.model, self.targets)
        grippers = [self.model.actuator(j).id for j in GRIPPERS]
        self.data.ctrl[self._motor] = self.targets[:12]
        self.data.ctrl[grippers] = self.targets[GRIPPER_AT]
        for _ in range(round(SETTLE_S / self.model.opt.timestep)):
            mujoco.mj_step(self.model, self.data)
        self._home = self.data.site_xpos[self._tip].copy()

    def tick(self, q: Array, contacts: Contacts) -> Moment:
        """1/300 s with servo targets q (22,) [rad]."""
        self.data.ctrl[self._motor] = q[:12]
        seen = [self._step(contacts) for _ in range(STEPS)]
        self.ticks += 1
        x, v, wrench = (np.stack(part) for part in zip(*seen, strict=True))
        return Moment(x, v, wrench)

    def _step(self, contacts: Contacts) -> tuple[Array, Array, Array]:
        tip = self.data.site_xpos[self._tip]
        x = tip - self._home
        push = contacts.wrench(x)
        self.data.xfrc_applied[self._hand, :3] = push
        self.data.xfrc_applied[self._hand, 3:] = cross(tip - self.data.xipos[self._hand], push)
        mujoco.mj_step(self.model, self.data)
        v = (self.data.site_xpos[self._tip] - self._home - x) / self.model.opt.timestep
        return x, v, push

    def frame(self) -> SensorFrame:
        """What the devices say."""
        wrench = np.array([self.data.sensordata[a : a + 6] for a in self._wrist])
        q, dq, still = np.array(self.targets), np.zeros(NUM_JOINTS), np.zeros(NUM_JOINTS)
        q[:12], dq[:12] = self.data.qpos[self._q], self.data.qvel[self._dof]
        return SensorFrame(
            stamp=self.ticks / paper.RATES.admittance,
            q=q,
            dq=dq,
            torque=still,
            wrench_S=self._noise.corrupt(wrench, 1.0 / paper.RATES.admittance),
            gyro_I=np.zeros(3),
            accel_I=np.array([0.0, 0.0, 9.81]),
        )


@cache
def _model() -> tuple[mujoco.MjModel, Array]:
    """Trunk and arms, nothing collides; joint targets (22,) of the pose."""
    spec = load_spec("full")
    for key in list(spec.keys):
        spec.delete(key)
    spec.delete(spec.joint("base"))
    for side in ("left", "right"):
        spec.delete(spec.equality(f"{side}_leg_loop"))
        spec.delete(spec.body(f"{side}_leg_hip"))
    for geom in spec.geoms:
        geom.contype = geom.conaffinity = 0
    model = spec.compile()
    model.opt.timestep = 1.0 / (STEPS * paper.RATES.admittance)
    _, targets = keyframe_joints("crawl")
    targets[:12] = np.concatenate([POSE, MIRROR * POSE])
    targets.setflags(write=False)
    return model, targets


def _assembled(model: mujoco.MjModel, q: Array) -> Array:
    """Configuration (nq,) with the five-bars closed."""
    coupler, distal = passive_angles(q)
    qpos = np.array(model.qpos0)
    named = dict(zip(JOINTS, q, strict=True))
    for k, side in enumerate(("left", "right")):
        named[f"{side}_arm_coupler"], named[f"{side}_arm_distal"] = coupler[k], distal[k]
        named[f"{side}_finger_b"] = named[f"{side}_gripper"]
    for i in range(model.njnt):
        qpos[model.jnt_qposadr[i]] = named[model.joint(i).name]
    return qpos
