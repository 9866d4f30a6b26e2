"""Batched physics behind a small seam: what the environment needs of a simulator.

The CPU back end is ``mujoco.batch``. A GPU back end would offer the same few names.
"""

from __future__ import annotations

import mujoco
import numpy as np
from mujoco import batch as mjbatch
from numpy.typing import NDArray

from mobius.control.bodies import Body
from mobius.model import robot
from mobius.types import LIMBS

Array = NDArray[np.float64]
_VEL = mujoco.mjtStage.mjSTAGE_VEL.value


def build_training_model(timestep: float, iterations: int) -> mujoco.MjModel:
    """The robot with feet-only contacts on a floor, sensors for the soles, no dry friction.

    Dry friction of the servos (0.03-0.08 N m) costs one constraint row a joint in
    training; the evaluation model has it.
    """
    spec = robot.load_spec("feet")
    spec.worldbody.add_geom(
        name="floor",
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[0, 0, 0.05],
        contype=1,
        conaffinity=0,
    )
    for limb in LIMBS:
        for kind, type_ in (
            ("pos", mujoco.mjtSensor.mjSENS_FRAMEPOS),
            ("vel", mujoco.mjtSensor.mjSENS_FRAMELINVEL),
        ):
            spec.add_sensor(
                name=f"{limb}_tip_{kind}",
                type=type_,
                objtype=mujoco.mjtObj.mjOBJ_SITE,
                objname=f"{limb}_tip",
            )
    spec.option.timestep = timestep
    spec.option.iterations = iterations
    spec.option.ls_iterations = 5
    model = spec.compile()
    model.dof_frictionloss[:] = 0.0
    return model


class CpuBatch:
    """n robots on the CPU threads."""

    def __init__(self, model: mujoco.MjModel, body: Body, n: int, nthread: int = 0) -> None:
        self.model, self.n = model, n
        self.at = robot.addresses(model)
        self._batch = mjbatch.Batch(model, n, nthread=nthread, persistent=True)
        self.qpos, self.qvel, self.ctrl = self._batch.qpos, self._batch.qvel, self._batch.ctrl
        self._force = self._batch.bind("actuator_force")
        feet = body.feet
        sensor = self._batch.sensor
        self._contact = [sensor(f"{limb}_contact") for limb in feet]
        self._position = [sensor(f"{limb}_tip_pos") for limb in feet]
        self._velocity = [sensor(f"{limb}_tip_vel") for limb in feet]
        self.friction = self._batch.expand("geom_friction")
        self.gain = self._batch.expand("actuator_gainprm")
        self.bias = self._batch.expand("actuator_biasprm")
        self.mass = self._batch.expand("body_mass")
        self.ipos = self._batch.expand("body_ipos")
        self.inertia = self._batch.expand("body_inertia")

    def step(self, substeps: int) -> None:
        """Advance all robots; kinematics and sensors are fresh afterwards."""
        self._batch.step(nstep=substeps, stage=_VEL)

    def place(self, ids: NDArray[np.int64], qpos: Array, qvel: Array, ctrl: Array) -> None:
        """Put some robots (m,) into states (m, nq), (m, nv) with targets (m, nu)."""
        self._batch.reset(ids=ids, stage=mujoco.mjtStage.mjSTAGE_NONE.value)
        self.qpos[ids], self.qvel[ids], self.ctrl[ids] = qpos, qvel, ctrl
        self._batch.forward(ids=ids)

    def constants_changed(self, ids: NDArray[np.int64]) -> None:
        """Recompute what depends on masses of some robots."""
        self._batch.set_const(ids)

    @property
    def torque(self) -> Array:
        """(n, nu) servo torque at the output: drive minus back-EMF [N m]."""
        dof = self.at.dof
        return self._force[:, self.at.actuator] - self.model.dof_damping[dof] * self.qvel[:, dof]

    @property
    def contact(self) -> Array:
        """(n, f) 1 where a sole touches."""
        return np.stack([c.data[:, 0] > 0 for c in self._contact], axis=1).astype(float)

    @property
    def foot_position(self) -> Array:
        """(n, f, 3) sole points in the world [m]."""
        return np.stack([p.data for p in self._position], axis=1)

    @property
    def foot_velocity(self) -> Array:
        """(n, f, 3) [m/s]."""
        return np.stack([v.data for v in self._velocity], axis=1)
