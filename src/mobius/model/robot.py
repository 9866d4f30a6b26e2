"""Load the robot: MJCF for evaluation or training, addresses, loop-consistent configurations."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Literal

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.errors import InvalidInput, UnknownName
from mobius.model import dimensions as dim
from mobius.model.build import MJCF_DIR, ROBOT_XML, joint_ranges
from mobius.model.dimensions import limb_geometry
from mobius.model.joints import JOINTS
from mobius.model.passive import passive_angles as passive_angles
from mobius.types import LIMBS, NUM_JOINTS

Array = NDArray[np.float64]

MJCF_PATH = ROBOT_XML
"""The robot alone, menagerie form."""
SCENE_PATH = MJCF_DIR / "scene.xml"
"""The robot on a lit floor."""

Collision = Literal["full", "feet"]


def load_spec(collision: Collision = "full") -> mujoco.MjSpec:
    """The robot as an editable ``MjSpec``.

    Args:
        collision: ``"full"`` keeps every collision geom (evaluation, stack); ``"feet"`` keeps
            only what walks: four spheres a foot, one sphere a closed gripper whose fingers
            are welded, no visuals, no wrench and accelerometer (training; one source, cheaper).
    """
    spec = mujoco.MjSpec.from_file(str(ROBOT_XML))
    if collision == "feet":
        _reduce_to_feet(spec)
    elif collision != "full":
        raise UnknownName("collision set", collision, ("full", "feet"))
    return spec


def load_model(collision: Collision = "full", *, floor: bool = True) -> mujoco.MjModel:
    """The compiled robot, on a plane named ``floor`` unless ``floor`` is False."""
    spec = load_spec(collision)
    if floor:
        spec.worldbody.add_geom(name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 0.05])
    return spec.compile()


def _reduce_to_feet(spec: mujoco.MjSpec) -> None:
    for geom in list(spec.geoms):
        spec.delete(geom)
    for limb in LIMBS:
        g = limb_geometry(limb)
        if g.is_arm:
            r = 0.012
            body = spec.body(f"{limb}_gripper_base")
            centers = [(0.0, 0.0, r - g.tip)]
        else:
            r = 0.5 * dim.FOOT_THICK
            body = spec.body(f"{limb}_foot")
            y = 0.5 * dim.FOOT_WIDTH - r
            centers = [
                (x, s * y, r - g.tip)
                for x in (r - dim.FOOT_TOE, dim.FOOT_HEEL - r)
                for s in (1, -1)
            ]
        for i, c in enumerate(centers):
            body.add_geom(
                name=f"{limb}_sole{i}",
                type=mujoco.mjtGeom.mjGEOM_SPHERE,
                size=[r, 0, 0],
                pos=c,
                friction=dim.SOLE_FRICTION,
                priority=1,
                contype=0,
                conaffinity=1,
                mass=0,
            )
    for side in ("left", "right"):
        spec.delete(spec.equality(f"{side}_fingers"))
        spec.delete(spec.actuator(f"{side}_gripper"))
        spec.delete(spec.joint(f"{side}_gripper"))
        spec.delete(spec.joint(f"{side}_finger_b"))
    wrench = [f"{s}_wrist_{k}" for s in ("left", "right") for k in ("force", "torque")]
    for name in (*wrench, "imu_accel"):
        spec.delete(spec.sensor(name))
    for exclude in list(spec.excludes):
        spec.delete(exclude)
    for key in list(spec.keys):
        spec.delete(key)


@dataclass(frozen=True, eq=False)
class Addresses:
    """Where the robot's joints stand in a compiled model's vectors."""

    present: NDArray[np.int64]
    """(k,) which of JOINTS the model has: all 22, 20 where the fingers are welded, or fewer
    where :func:`mobius.model.freeze.freeze` welded more. The order is that of JOINTS."""
    limbs: NDArray[np.int64]
    """(l,) which of LIMBS have a five-bar that moves."""
    qpos: NDArray[np.int64]
    """(k,)."""
    dof: NDArray[np.int64]
    actuator: NDArray[np.int64]
    coupler: NDArray[np.int64]
    """(l,) qpos of the passive coupler joints."""
    distal: NDArray[np.int64]
    finger_b: NDArray[np.int64]
    """(2,) or (0,) qpos of the mimic fingers."""
    base_qpos: int
    base_dof: int


def addresses(model: mujoco.MjModel) -> Addresses:
    """Addresses of JOINTS and of the passive joints in a compiled model."""

    def has(joint: str) -> bool:
        return bool(mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, joint) >= 0)

    names = [j for j in JOINTS if has(j)]
    limbs = [limb for limb in LIMBS if has(f"{limb}_coupler")]

    def qpos(which: list[str]) -> NDArray[np.int64]:
        return np.array([model.joint(n).qposadr[0] for n in which], dtype=np.int64)

    fingers = [f"{s}_finger_b" for s in ("left", "right")] if len(names) == NUM_JOINTS else []
    return Addresses(
        present=np.array([JOINTS.index(j) for j in names], dtype=np.int64),
        limbs=np.array([LIMBS.index(limb) for limb in limbs], dtype=np.int64),
        qpos=qpos(names),
        dof=np.array([model.joint(n).dofadr[0] for n in names], dtype=np.int64),
        actuator=np.array([model.actuator(n).id for n in names], dtype=np.int64),
        coupler=qpos([f"{limb}_coupler" for limb in limbs]),
        distal=qpos([f"{limb}_distal" for limb in limbs]),
        finger_b=qpos(fingers),
        base_qpos=int(model.joint("base").qposadr[0]),
        base_dof=int(model.joint("base").dofadr[0]),
    )


def configuration(
    model: mujoco.MjModel, q: ArrayLike, *, p: ArrayLike = (0, 0, 0), quat: ArrayLike = (1, 0, 0, 0)
) -> Array:
    """A full, loop-consistent ``qpos`` (nq,) from joint angles q (22,) and the trunk pose.

    Raises :class:`InvalidInput` when a five-bar cannot be assembled at q.
    """
    q = np.asarray(q, dtype=float)
    coupler, distal = passive_angles(q)
    if not (np.isfinite(coupler).all() and np.isfinite(distal).all()):
        bad = [
            limb
            for limb, c, d in zip(LIMBS, coupler, distal, strict=True)
            if not np.isfinite(c + d)
        ]
        raise InvalidInput(
            f"the five-bar of {', '.join(bad)} cannot be assembled at these crank angles;"
            " expected q21 - q11 >= 0.70 rad and a point inside the workspace"
        )
    return _fill(model, q, coupler, distal, p, quat)


def configurations(
    model: mujoco.MjModel, q: ArrayLike, *, p: ArrayLike, quat: ArrayLike
) -> tuple[Array, NDArray[np.bool_]]:
    """Many ``qpos`` (n, nq) from joint angles q (n, 22) and trunk poses (n, 3), (n, 4), at once.

    The joint angles stay as they are, to the last bit. Where measured ones are such that a
    five-bar cannot be assembled, its passive joints keep the angles of the row before (of the
    first row that can be, at the beginning; 0 if none can).

    Returns:
        The configurations, and (n,) rows whose loops are closed.
    """
    q = np.asarray(q, dtype=float)
    passive = np.stack(passive_angles(q), axis=1)  # (n, 2, 4)
    good = np.isfinite(passive).all(axis=1)  # (n, 4) by limb
    rows = np.arange(len(q))[:, None]
    last = np.maximum.accumulate(np.where(good, rows, -1), axis=0)
    last = np.where(last < 0, np.argmax(good, axis=0), last)
    filled = np.nan_to_num(np.take_along_axis(passive, last[:, None, :], axis=0))
    return _fill(model, q, filled[:, 0], filled[:, 1], p, quat), np.asarray(np.all(good, axis=1))


def _fill(
    model: mujoco.MjModel,
    q: Array,
    coupler: Array,
    distal: Array,
    p: ArrayLike,
    quat: ArrayLike,
) -> Array:
    """(..., nq) from joints (..., 22), passive angles (..., 4) and trunk poses."""
    at = addresses(model)
    qpos = np.empty((*q.shape[:-1], model.nq))
    qpos[...] = model.qpos0
    qpos[..., at.base_qpos : at.base_qpos + 3] = p
    qpos[..., at.base_qpos + 3 : at.base_qpos + 7] = quat
    qpos[..., at.qpos] = q[..., at.present]
    qpos[..., at.coupler], qpos[..., at.distal] = coupler[..., at.limbs], distal[..., at.limbs]
    if len(at.finger_b):
        qpos[..., at.finger_b] = q[..., 20:22]
    return qpos


@cache
def _alone() -> mujoco.MjModel:
    return load_model("full", floor=False)


def centre_of_mass(q: ArrayLike) -> Array:
    """Centre of mass (3,) [m] in ``base_link`` at joint angles q (22,) [rad]."""
    model = _alone()
    data = mujoco.MjData(model)
    data.qpos[:] = configuration(model, q)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    return np.array(data.subtree_com[model.body("base_link").id])


def compile_scene(xml: str) -> mujoco.MjModel:
    """A model from the MJCF of a scene that holds the robot.

    Raises:
        InvalidInput: It does not compile, or lacks joints of the robot.
    """
    try:
        model = mujoco.MjModel.from_xml_string(xml)
    except ValueError as error:
        raise InvalidInput(f"the scene cannot be built ({' '.join(str(error).split())})") from None
    missing = [j for j in JOINTS if mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, j) < 0]
    if missing:
        raise InvalidInput(f"the scene lacks joints of the robot: {', '.join(missing)}")
    return model


@cache
def joint_limits() -> tuple[Array, Array]:
    """Lower and upper limits (22,) [rad] in the order of JOINTS; read-only."""
    ranges = joint_ranges()
    low, high = np.array([ranges[j] for j in JOINTS]).T
    low.setflags(write=False)
    high.setflags(write=False)
    return low, high


@cache
def keyframe(name: str = "crawl") -> tuple[Array, Array]:
    """Keyframe ``qpos`` (nq,) and ``ctrl`` (22,) of the full model. Raises UnknownName."""
    model = load_model("full", floor=False)
    names = [model.key(i).name for i in range(model.nkey)]
    if name not in names:
        raise UnknownName("keyframe", name, names)
    key = model.key(name)
    return np.array(key.qpos), np.array(key.ctrl)


def keyframe_joints(name: str = "crawl") -> tuple[Array, Array]:
    """Joint angles (22,) and servo targets (22,) [rad] of a keyframe, order JOINTS."""
    qpos, ctrl = keyframe(name)
    at = addresses(load_model("full", floor=False))
    return qpos[at.qpos], ctrl[at.actuator]
