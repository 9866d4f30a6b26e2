"""Weld joints at given angles: fewer degrees of freedom, several times cheaper physics."""

from __future__ import annotations

from collections.abc import Iterable

import mujoco
from numpy.typing import ArrayLike

from mobius.geometry import quat_conj, quat_mul, rotate
from mobius.model.joints import joint_index
from mobius.model.robot import configuration
from mobius.types import LIMBS


def freeze(spec: mujoco.MjSpec, joints: Iterable[str], q: ArrayLike) -> None:
    """Weld ``joints`` of a robot's spec, in place, at their angles in q (22,) [rad].

    Their servos go too, and the passive joints and the loop constraint of a limb whose two
    crank motors are both welded. Masses and shapes stay.

    Raises:
        UnknownName: A name that is not in JOINTS.
        InvalidInput: A five-bar cannot be assembled at q.
    """
    frozen = list(joints)
    joint_index(*frozen)
    model = spec.copy().compile()
    data = mujoco.MjData(model)
    data.qpos[:] = configuration(model, q)
    mujoco.mj_kinematics(model, data)
    for limb in LIMBS:
        side, kind = limb.split("_")
        root = f"{side}_shoulder" if kind == "arm" else f"{side}_hip"
        if {f"{root}_motor_a", f"{root}_motor_b"} <= set(frozen):
            frozen += [f"{limb}_coupler", f"{limb}_distal"]
            spec.delete(spec.equality(f"{limb}_loop"))
    for name in frozen:
        joint = spec.joint(name)
        body = joint.parent
        i = model.body(body.name).id
        parent = int(model.body_parentid[i])
        back = quat_conj(data.xquat[parent])
        body.pos = rotate(back, data.xpos[i] - data.xpos[parent])
        body.quat = quat_mul(back, data.xquat[i])
        for actuator in list(spec.actuators):
            if actuator.target == name:
                spec.delete(actuator)
        for sensor in list(spec.sensors):
            if sensor.objname == name:
                spec.delete(sensor)
        spec.delete(joint)
