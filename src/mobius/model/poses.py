"""Keyframes: body poses from closed-form kinematics, servo targets that hold them.

``python -m mobius.model.poses`` rewrites ``mjcf/mobius.xml`` with them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import mujoco
import numpy as np
from numpy.typing import NDArray

from mobius.geometry import rpy_to_quat
from mobius.model import leg, robot
from mobius.model.build import ROBOT_XML, build_robot
from mobius.model.dimensions import LimbGeometry, limb_geometry
from mobius.model.joints import LIMB_JOINTS
from mobius.types import LIMBS, NUM_JOINTS

Array = NDArray[np.float64]

TRUNK_HEIGHT_CRAWL = 0.275
"""Trunk centre above the floor while crawling [m]."""


def _arm(side: int, yaw: float, down: float, out: float, tilt: float = 0.0) -> list[float]:
    """Arm angles with the gripper's approach axis ``tilt`` [rad] outward of -z_B."""
    g = limb_geometry("left_arm")
    a, b = g.fivebar.ik(down, out)
    return [side * yaw, float(a), float(b), tilt - float(g.fivebar.distal_angle(a, b)), 0.0, 0.0]


def _leg(side: int, yaw: float, down: float, out: float, pitch: float = 0.0) -> list[float]:
    """Leg angles with the sole normal at ``pitch`` [rad] outward of -z_B."""
    g = limb_geometry("left_leg")
    a, b = g.fivebar.ik(down, out)
    return [side * yaw, float(a), float(b), pitch - float(g.fivebar.distal_angle(a, b))]


def _body(arm: Callable[[int], list[float]], leg: Callable[[int], list[float]]) -> Array:
    q = np.zeros(NUM_JOINTS)
    for limb in LIMBS:
        side = 1 if limb.startswith("left") else -1
        q[LIMB_JOINTS[limb]] = arm(side) if limb.endswith("arm") else leg(side)
    return q


def crawl_joints() -> Array:
    """(22,) [rad] four limbs out, arms forward, legs backward, soles level."""
    h = TRUNK_HEIGHT_CRAWL
    a, g = limb_geometry("left_arm"), limb_geometry("left_leg")
    arm = (h + a.z_top - a.tip, 0.175)
    leg = (h + g.z_top - g.tip, 0.155)
    return _body(
        lambda s: _arm(s, -np.radians(22.0), *arm), lambda s: _leg(s, np.radians(32.0), *leg)
    )


@dataclass(frozen=True)
class Stance:
    """Where four feet stand, from the yaw axes of shoulders and hips."""

    arm_r: float
    """Distance of a fingertip [m]."""
    arm_turn: float
    """Its direction, forward of straight out [rad]."""
    leg_r: float
    """Distance of a sole [m]."""
    leg_turn: float
    """Its direction, backward of straight out [rad]."""

    def joints(self) -> Array:
        """(22,) [rad] with the trunk as high as in :func:`crawl_joints` and the soles level."""
        h = TRUNK_HEIGHT_CRAWL
        a, g = limb_geometry("left_arm"), limb_geometry("left_leg")
        ahead = float(np.sqrt(self.arm_r**2 - a.lateral**2))
        arm = (h + a.z_top - a.tip, ahead - a.x_off)
        leg = (h + g.z_top - g.tip, self.leg_r - g.x_off)
        yaw = float(np.arctan2(a.lateral, ahead)) - self.arm_turn
        return _body(lambda s: _arm(s, yaw, *arm), lambda s: _leg(s, self.leg_turn, *leg))


@cache
def stance_keyframe(stance: Stance) -> tuple[Array, Array]:
    """``qpos`` (nq,) and servo targets (22,) of a stance that is no keyframe, belly down."""
    model = robot.load_model("full")
    qpos = _placed(model, stance.joints(), rpy_to_quat(0.0, 0.0, 0.0))
    return qpos, holding_targets(model, qpos)


def stand_joints() -> Array:
    """(22,) [rad] trunk upright: legs turned below the trunk, arms tucked in front.

    The centre of mass is above the middle of the feet.
    """
    return _body(
        lambda s: _arm(s, np.radians(20.0), 0.17, 0.10, 0.3),
        lambda s: _leg(s, np.radians(90.0), -0.030, 0.305, np.radians(90.0)),
    )


def prone_joints() -> Array:
    """(22,) [rad] belly down, limbs spread flat."""
    return _body(
        lambda s: _arm(s, -np.radians(35.0), 0.0, 0.27, np.radians(80.0)),
        lambda s: _leg(s, np.radians(35.0), 0.0, 0.28, np.radians(80.0)),
    )


def hang_joints() -> Array:
    """(22,) [rad] arms along +x_B, open grippers, legs hanging along -x_B."""
    q = _body(
        lambda s: _arm(s, -np.radians(90.0), 0.08, 0.27, np.radians(90.0)),
        lambda s: _leg(s, np.radians(90.0), 0.03, 0.32, np.radians(90.0)),
    )
    q[20:] = 0.45
    return q


def lowest_point(model: mujoco.MjModel, qpos: Array) -> float:
    """Height [m] of the lowest collision geometry above z = 0 at a configuration."""
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(model, data)
    floor = model.geom("floor").id
    fromto = np.zeros(6)
    heights = [
        mujoco.mj_geomDistance(model, data, floor, i, 10.0, fromto)
        for i in range(model.ngeom)
        if i != floor and model.geom_contype[i]
    ]
    return float(min(heights))


def overlap(model: mujoco.MjModel, qpos: Array) -> float:
    """Deepest penetration [m] of any two colliding geoms at a configuration; 0 without one."""
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_forward(model, data)
    return float(max(-data.contact.dist.min(), 0.0)) if data.ncon else 0.0


def _placed(model: mujoco.MjModel, q: Array, quat: Array, *, clearance: float = 0.0) -> Array:
    """Configuration with its lowest point ``clearance`` above the floor."""
    qpos = robot.configuration(model, q, p=(0, 0, 2.0), quat=quat)
    qpos[2] -= lowest_point(model, qpos) - clearance
    return qpos


def holding_targets(model: mujoco.MjModel, qpos: Array) -> Array:
    """Servo targets (22,) [rad] whose springs carry the pose at rest on its contacts.

    Lets the robot settle and moves each target by its servo's sag until the joints rest
    where the pose wants them. The clipped targets stay inside the control range.
    """
    at = robot.addresses(model)
    data = mujoco.MjData(model)
    want = qpos[at.qpos]
    ctrl = want.copy()
    low, high = model.actuator_ctrlrange[at.actuator].T
    for _ in range(25):
        mujoco.mj_resetData(model, data)
        data.qpos[:] = qpos
        data.ctrl[at.actuator] = ctrl
        mujoco.mj_step(model, data, 360)
        ctrl = np.clip(ctrl + 0.7 * (want - data.qpos[at.qpos]), low, high)
    return ctrl


def standing_targets(model: mujoco.MjModel, qpos: Array) -> Array:
    """Servo targets (22,) [rad] that carry the trunk on two feet, each half the weight.

    Statics: tau = -J^T F with the ground's force F below the centre of mass; a servo holds
    tau at target = angle + tau / kp. Unlike :func:`holding_targets` nothing may fall here.
    """
    at = robot.addresses(model)
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_forward(model, data)
    q = np.array(qpos[at.qpos])
    R = data.body("base_link").xmat.reshape(3, 3)
    F_B = R.T @ [0.0, 0.0, 0.5 * 9.81 * model.body_subtreemass[model.body("base_link").id]]
    ahead = data.subtree_com[model.body("base_link").id] - data.site("left_sole").xpos
    target = q + data.qfrc_bias[at.dof] / model.actuator_gainprm[at.actuator, 0]
    for name in ("left_leg", "right_leg"):
        g, joints = limb_geometry(name), LIMB_JOINTS[name]
        kp = model.actuator_gainprm[at.actuator[joints], 0]
        J = _pressure_jacobian(g, q[joints], float(ahead[0]))
        target[joints] = q[joints] - J.T @ F_B / kp
    low, high = model.actuator_ctrlrange[at.actuator].T
    return np.clip(target, low, high)


def _pressure_jacobian(g: LimbGeometry, q: Array, ahead: float) -> Array:
    """d(point of the sole ``ahead`` [m] of the ankle towards the toe)/dq (3, 4), in B."""

    def point(q: Array) -> Array:
        angle = leg.foot_pitch(g, q)
        out, _ = leg.limb_axes(g, q[0])
        toe = -np.cos(angle) * out - np.sin(angle) * np.array([0.0, 0.0, 1.0])
        return leg.sole_position(g, q) + ahead * toe

    e = 1e-6 * np.eye(4)
    return np.stack([(point(q + d) - point(q - d)) / 2e-6 for d in e], axis=-1)


def build_keyframes() -> dict[str, tuple[Array, Array]]:
    """Name -> (qpos, ctrl). ``crawl`` is the home keyframe."""
    spec = mujoco.MjSpec.from_string(build_robot())
    spec.worldbody.add_geom(name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 0.05])
    model = spec.compile()
    flat = rpy_to_quat(0.0, 0.0, 0.0)
    upright = rpy_to_quat(0.0, -np.pi / 2, 0.0)
    head_down = rpy_to_quat(0.0, np.pi / 2, 0.0)
    on_back = rpy_to_quat(np.pi, 0.0, 0.0)
    crawl, stand, prone = crawl_joints(), stand_joints(), prone_joints()
    home = _placed(model, crawl, flat)
    frames = {"crawl": (home, holding_targets(model, home)), "home": (home, np.zeros(0))}
    frames["home"] = frames["crawl"]
    for name, q, quat, clearance in (
        ("stand", stand, upright, 0.0),
        ("prone", prone, flat, 0.0),
        ("supine", prone, on_back, 0.0),
        ("on_head", stand, head_down, 0.0),
        ("hang", hang_joints(), upright, 0.35),
    ):
        frames[name] = (_placed(model, q, quat, clearance=clearance), q.copy())
    frames["stand"] = (frames["stand"][0], standing_targets(model, frames["stand"][0]))
    return frames


def main() -> None:
    """Rewrite ``mjcf/mobius.xml``."""
    ROBOT_XML.write_text(build_robot(build_keyframes()))


if __name__ == "__main__":
    main()
