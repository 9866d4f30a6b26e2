"""Batched physics behind a small seam: what the environment needs of a simulator.

The CPU back end is ``mujoco.batch``. A GPU back end would offer the same few names.
"""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
from mujoco import batch as mjbatch
from numpy.typing import NDArray

from mobius.control.bodies import Body
from mobius.model import robot
from mobius.model.freeze import freeze
from mobius.model.joints import JOINTS
from mobius.types import LIMBS
from mobius.world.ground import Ground, add_ground

Array = NDArray[np.float64]
_BLOWN_UP = [
    mujoco.mjtWarning.mjWARN_BADQPOS.value,
    mujoco.mjtWarning.mjWARN_BADQVEL.value,
    mujoco.mjtWarning.mjWARN_BADQACC.value,
]
_VEL = mujoco.mjtStage.mjSTAGE_VEL.value


def build_training_model(
    body: Body,
    timestep: float,
    iterations: int,
    *,
    ls_iterations: int = 5,
    weld: bool = False,
    posture: Array | None = None,
    ground: Ground | None = None,
) -> mujoco.MjModel:
    """The robot with feet-only contacts on a floor, sensors for the soles, no dry friction.

    Dry friction of the servos (0.03-0.08 N m) costs one constraint row a joint in
    training; the evaluation model has it.

    Args:
        body: Whose feet touch the floor.
        timestep: [s].
        iterations: Newton iterations at most.
        ls_iterations: Line search iterations at most.
        weld: Weld the joints that the body's policy does not move at its stance: a third
            (crawl) to a half (biped) of the time. Contacts of limbs that are no feet go too.
        posture: (22,) angles [rad] to weld at; those of the body's keyframe if not given.
        ground: A height map instead of the plane.
    """
    spec = robot.load_spec("feet")
    if weld:
        passive = [j for j in JOINTS[:20] if j not in body.joints]
        freeze(
            spec, passive, robot.keyframe_joints(body.keyframe)[0] if posture is None else posture
        )
        for limb in set(LIMBS) - set(body.feet):
            for geom in [g for g in spec.geoms if g.name.startswith(f"{limb}_sole")]:
                spec.delete(geom)
            spec.delete(spec.sensor(f"{limb}_contact"))
    if ground is None:
        plane = mujoco.mjtGeom.mjGEOM_PLANE
        spec.worldbody.add_geom(
            name="floor", type=plane, size=[0, 0, 0.05], contype=1, conaffinity=0
        )
    else:
        add_ground(spec, ground, conaffinity=0)
    for limb in body.feet:
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
        if limb.endswith("leg"):
            spec.add_sensor(
                name=f"{limb}_foot_up",
                type=mujoco.mjtSensor.mjSENS_FRAMEZAXIS,
                objtype=mujoco.mjtObj.mjOBJ_XBODY,
                objname=f"{limb}_foot",
            )
    spec.option.timestep = timestep
    spec.option.iterations = iterations
    spec.option.ls_iterations = ls_iterations
    model = spec.compile()
    model.dof_frictionloss[:] = 0.0
    return model


_FIELDS = {
    "friction": "geom_friction",
    "solref": "geom_solref",
    "gain": "actuator_gainprm",
    "bias": "actuator_biasprm",
    "force": "actuator_forcerange",
    "mass": "body_mass",
    "ipos": "body_ipos",
    "inertia": "body_inertia",
}


class CpuBatch:
    """n robots on the CPU threads."""

    def __init__(self, model: mujoco.MjModel, body: Body, n: int, nthread: int = 0) -> None:
        self.model, self.n = model, n
        self.at = robot.addresses(model)
        self._batch = mjbatch.Batch(model, n, nthread=nthread, persistent=True)
        self.qpos, self.qvel, self.ctrl = self._batch.qpos, self._batch.qvel, self._batch.ctrl
        self._force = self._batch.bind("actuator_force")
        feet = body.feet
        self._sensor = self._batch.bind("sensordata")
        first = {model.sensor(i).name: int(model.sensor_adr[i]) for i in range(model.nsensor)}
        self._contact = np.array([first[f"{limb}_contact"] for limb in feet])
        self._position = np.array(
            [[first[f"{limb}_tip_pos"] + i for i in range(3)] for limb in feet]
        )
        self._velocity = np.array(
            [[first[f"{limb}_tip_vel"] + i for i in range(3)] for limb in feet]
        )
        self._up = {i: first[f"{x}_foot_up"] for i, x in enumerate(feet) if x.endswith("leg")}
        self.fields = {k: self._batch.expand(v) for k, v in _FIELDS.items()}
        """Model fields of each robot, (n, ...); live."""
        names = [model.geom(i).name for i in range(model.ngeom)]
        soles = [[i for i, k in enumerate(names) if k.startswith(f"{x}_sole")] for x in feet]
        self.soles = np.array([(own + [-1] * 4)[:4] for own in soles], dtype=np.int64)
        """(f, 4) sole geoms of each foot, -1 where it has fewer."""

    def step(self, substeps: int) -> None:
        """Advance all robots; kinematics and sensors are fresh afterwards."""
        self._batch.step(nstep=substeps, stage=_VEL)

    def step_watched(self, substeps: int) -> Array:
        """Advance all robots like :meth:`step`, to the same bits, with an eye on their soles.

        Returns:
            (substeps, n, f) :attr:`contact` after every physics step.
        """
        seen = np.zeros((substeps, self.n, len(self._contact)))
        for i in range(substeps):
            self._batch.step(nstep=1, stage=_VEL)  # a persistent batch goes on from this stage
            seen[i] = self.contact
        return seen

    def place(self, ids: NDArray[np.int64], qpos: Array, qvel: Array, ctrl: Array) -> None:
        """Put some robots (m,) into states (m, nq), (m, nv) with targets (m, nu)."""
        self._batch.reset(ids=ids, stage=mujoco.mjtStage.mjSTAGE_NONE.value)
        self.qpos[ids], self.qvel[ids], self.ctrl[ids] = qpos, qvel, ctrl
        self._batch.forward(ids=ids)

    def constants_changed(self, ids: NDArray[np.int64]) -> None:
        """Recompute what depends on masses of some robots."""
        self._batch.set_const(ids)

    def state(self) -> dict[str, Any]:
        """What :meth:`load_state` needs to go on bit for bit."""
        return {
            "state": self._batch.state.copy(),
            **{k: np.array(v) for k, v in self.fields.items()},
        }

    def load_state(self, state: dict[str, Any]) -> None:
        """Go on from :meth:`state`."""
        for name, field in self.fields.items():
            field[:] = state[name]
        ids = np.arange(self.n)
        self._batch.set_const(ids)
        self._batch.reset(ids=ids, stage=mujoco.mjtStage.mjSTAGE_NONE.value)
        self._batch.state[:] = state["state"]
        self._batch.forward(ids=ids)  # refreshes what is derived, and the warm start with it
        self._batch.state[:] = state["state"]

    @property
    def blown_up(self) -> NDArray[np.bool_]:
        """(n,) whether MuJoCo had to reset a simulation since its robot was last placed."""
        return np.asarray(self._batch.warning[:, _BLOWN_UP, 1].any(axis=1))

    @property
    def torque(self) -> Array:
        """(n, nu) servo torque at the output: drive minus back-EMF [N m]."""
        dof = self.at.dof
        return self._force[:, self.at.actuator] - self.model.dof_damping[dof] * self.qvel[:, dof]

    @property
    def contact(self) -> Array:
        """(n, f) 1 where a sole touches."""
        return (self._sensor[:, self._contact] > 0).astype(float)

    @property
    def foot_tilt(self) -> Array:
        """(n, f) squared sine of the angle between a sole and the horizontal; 0 for grippers."""
        tilt = np.zeros((self.n, len(self._contact)))
        for i, at in self._up.items():
            tilt[:, i] = self._sensor[:, at] ** 2 + self._sensor[:, at + 1] ** 2
        return tilt

    @property
    def foot_position(self) -> Array:
        """(n, f, 3) sole points in the world [m]."""
        return np.asarray(self._sensor[:, self._position])

    @property
    def foot_velocity(self) -> Array:
        """(n, f, 3) [m/s]."""
        return np.asarray(self._sensor[:, self._velocity])
