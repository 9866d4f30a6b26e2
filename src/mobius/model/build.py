"""The MJCF of the robot, built from :mod:`mobius.model.dimensions`; pure, text in memory.

``python -m mobius.model.build`` rewrites ``mjcf/mobius.xml``; a test holds the two equal.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from mobius.model import dimensions as dim
from mobius.model.cameras import CAMERAS
from mobius.model.dimensions import LimbGeometry, limb_geometry
from mobius.model.joints import JOINTS
from mobius.model.links import (
    Link,
    collision_of_limb,
    limb_links,
    trunk_collision,
    trunk_parts,
)
from mobius.model.parts import Part, composite_inertia
from mobius.model.servo import SERVOS, servo_of
from mobius.types import LIMBS

MJCF_DIR = Path(__file__).parent / "mjcf"
ROBOT_XML = MJCF_DIR / "mobius.xml"

MATERIALS = {
    "metal": (0.72, 0.74, 0.77, 1),
    "carbon": (0.10, 0.10, 0.11, 1),
    "servo": (0.17, 0.18, 0.20, 1),
    "horn": (0.55, 0.57, 0.60, 1),
    "battery": (0.13, 0.30, 0.55, 1),
    "computer": (0.22, 0.50, 0.36, 1),
    "shell": (0.93, 0.93, 0.90, 1),
    "rail": (0.93, 0.45, 0.10, 1),
    "rubber": (0.06, 0.06, 0.06, 1),
    "spine": (0.80, 0.62, 0.25, 1),
    "lens": (0.02, 0.05, 0.12, 1),
}


def fmt(values: float | Iterable[float]) -> str:
    """Numbers as MJCF text, six significant digits, no negative zero."""
    if isinstance(values, float | int):
        values = [values]
    return " ".join(f"{v + 0.0:.6g}" if abs(v) > 1e-9 else "0" for v in values)


def add(parent: ET.Element, tag: str, **attributes: str) -> ET.Element:
    """Append an element; a trailing underscore lets ``class_`` be said."""
    return ET.SubElement(parent, tag, {k.rstrip("_"): v for k, v in attributes.items()})


def _geom(parent: ET.Element, part: Part, **extra: str) -> None:
    attributes = dict(type=part.shape, size=fmt(part.size), pos=fmt(part.pos))
    if any(part.euler):
        attributes["euler"] = fmt(part.euler)
    add(parent, "geom", **attributes, **extra)


def _solid(body: ET.Element, parts: Sequence[Part]) -> None:
    """Inertial and visual geoms of one body."""
    mass, com, inertia = composite_inertia([p for p in parts if p.mass > 0])
    full = [inertia[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    add(body, "inertial", pos=fmt(com), mass=fmt(mass), fullinertia=fmt(full))
    for part in parts:
        _geom(body, part, class_="visual", material=part.material)


def _link(parent: ET.Element, link: Link) -> ET.Element:
    """One moving link: body, joint, inertia, visuals, collisions, sites."""
    body = add(parent, "body", name=link.name, pos=fmt(link.pos))
    if link.quat is not None:
        body.set("quat", fmt(link.quat))
    if link.joint is not None:
        joint = add(body, "joint", name=link.joint, axis=fmt(link.axis))
        joint.set("class", link.joint_class)
        if link.range is not None:
            joint.set("range", fmt(link.range))
    _solid(body, link.parts)
    for i, (part, kind) in enumerate(link.collision):
        _geom(body, part, name=f"{link.name}_{kind}{i}", class_=kind)
    for name, pos in link.sites.items():
        add(body, "site", name=name, pos=fmt(pos), class_="mark")
    for child in link.children:
        _link(body, child)
    return body


def _compiler(root: ET.Element) -> None:
    add(root, "compiler", angle="radian", eulerseq="XYZ", autolimits="true")
    # dense: mujoco 4.0.0 builds a wrong Newton Hessian from a sparse constraint Jacobian
    add(
        root,
        "option",
        timestep="0.00166666666666667",
        integrator="implicitfast",
        jacobian="dense",
        cone="pyramidal",
        impratio="1",
    )


def _defaults(root: ET.Element) -> None:
    default = add(add(root, "default"), "default", class_="mobius")
    add(default, "joint", type="hinge")
    add(default, "equality", solref="0.005 1", solimp="0.99 0.999 0.0005")
    for name, servo in SERVOS.items():
        kind = add(default, "default", class_=name)
        add(
            kind,
            "joint",
            damping=fmt(servo.damping),
            armature=fmt(servo.armature),
            frictionloss=fmt(servo.friction),
        )
        limit = fmt((-servo.stall_torque, servo.stall_torque))
        add(kind, "position", kp=fmt(servo.kp), forcerange=limit)
    passive = add(default, "default", class_="passive")
    add(passive, "joint", damping="0.005", armature="0.0005", limited="false")
    visual = add(default, "default", class_="visual")
    add(visual, "geom", group="2", contype="0", conaffinity="0", mass="0")
    collision = add(default, "default", class_="collision")
    add(
        collision,
        "geom",
        group="3",
        contype="1",
        conaffinity="1",
        mass="0",
        rgba="0.3 0.5 0.9 0.4",
    )
    sole = add(collision, "default", class_="sole")
    add(
        sole,
        "geom",
        friction=fmt(dim.SOLE_FRICTION),
        solimp=fmt(dim.SOLE_SOLIMP),
        priority="1",
        rgba="0.9 0.3 0.2 0.6",
    )
    mark = add(default, "default", class_="mark")
    add(mark, "site", group="4", size="0.006", rgba="0.1 0.8 0.2 0.8")


def _assets(root: ET.Element) -> None:
    asset = add(root, "asset")
    for name, rgba in MATERIALS.items():
        shiny = {"metal": "0.6", "horn": "0.5", "rail": "0.4", "lens": "0.9"}.get(name, "0.15")
        add(asset, "material", name=name, rgba=fmt(rgba), specular=shiny, shininess=shiny)


def _trunk(root: ET.Element) -> None:
    trunk = add(add(root, "worldbody"), "body", name="base_link", pos="0 0 0.3")
    trunk.set("childclass", "mobius")
    add(trunk, "freejoint", name="base")
    _solid(trunk, trunk_parts())
    for i, part in enumerate(trunk_collision()):
        _geom(trunk, part, name=f"base_link_collision{i}", class_="collision")
    add(trunk, "site", name="imu", pos="0 0 0", class_="mark")
    add(trunk, "site", name="gaze", pos=fmt(CAMERAS["head"].pos), class_="mark")
    add(trunk, "site", name="vio", pos="-0.02 0 0.075", class_="mark")
    for name, camera in CAMERAS.items():
        add(
            trunk,
            "camera",
            name=name,
            pos=fmt(camera.pos),
            xyaxes=fmt((*camera.right, *camera.up)),
            fovy=fmt(camera.fovy),
        )
    for name in LIMBS:
        _link(trunk, limb_links(limb_geometry(name)))


def _loops(root: ET.Element) -> None:
    """Close the five-bars; keep the two fingers of a gripper equal."""
    equality = add(root, "equality")
    for limb in LIMBS:
        add(
            equality,
            "connect",
            name=f"{limb}_loop",
            class_="mobius",
            site1=f"{limb}_loop_coupler",
            site2=f"{limb}_loop_distal",
        )
    for side in ("left", "right"):
        add(
            equality,
            "joint",
            name=f"{side}_fingers",
            class_="mobius",
            joint1=f"{side}_finger_b",
            joint2=f"{side}_gripper",
            polycoef="0 1 0 0 0",
        )


def _excludes(root: ET.Element) -> None:
    """The five-bar's links work in parallel planes; neighbours along a limb touch by design."""
    contact = add(root, "contact")
    for limb in LIMBS:
        names = ["base_link", *collision_of_limb(limb)]
        for i, a in enumerate(names):
            for b in names[i + 1 :]:
                if a != "base_link" or b.endswith(("shoulder", "hip", "crank_a", "crank_b")):
                    add(contact, "exclude", body1=a, body2=b)


def _actuators(root: ET.Element) -> None:
    actuator = add(root, "actuator")
    ranges = joint_ranges()
    for name in JOINTS:
        add(
            actuator,
            "position",
            name=name,
            class_=name.split("_", 1)[1],
            joint=name,
            ctrlrange=fmt(ranges[name]),
        )


def _sensors(root: ET.Element) -> None:
    sensor = add(root, "sensor")
    add(sensor, "gyro", name="imu_gyro", site="imu")
    add(sensor, "accelerometer", name="imu_accel", site="imu")
    for side in ("left", "right"):
        add(sensor, "force", name=f"{side}_wrist_force", site=f"{side}_wrist_ft")
        add(sensor, "torque", name=f"{side}_wrist_torque", site=f"{side}_wrist_ft")
    for limb in LIMBS:
        end = f"{limb}_gripper_base" if limb.endswith("arm") else f"{limb}_foot"
        add(
            sensor,
            "contact",
            name=f"{limb}_contact",
            subtree1=end,
            data="found force",
            reduce="netforce",
        )


def joint_ranges() -> dict[str, tuple[float, float]]:
    """Lower and upper limit [rad] of every joint of JOINTS."""
    table: dict[str, tuple[float, float]] = {
        "shoulder_yaw": dim.YAW_RANGE,
        "hip_yaw": dim.YAW_RANGE,
        "shoulder_motor_a": dim.MOTOR_A_RANGE,
        "hip_motor_a": dim.MOTOR_A_RANGE,
        "shoulder_motor_b": dim.MOTOR_B_RANGE,
        "hip_motor_b": dim.MOTOR_B_RANGE,
        "ankle_pitch": dim.ANKLE_RANGE,
        "gripper": dim.GRIPPER_RANGE,
        **dim.WRIST_RANGES,
    }
    return {j: tuple(float(v) for v in table[j.split("_", 1)[1]]) for j in JOINTS}  # type: ignore[misc]


def build_robot(keyframes: dict[str, tuple[np.ndarray, np.ndarray]] | None = None) -> str:
    """The robot's MJCF as text.

    Args:
        keyframes: name -> (qpos, ctrl); made by :mod:`mobius.model.poses`, which needs the
            model without them first.
    """
    root = ET.Element("mujoco", model="mobius")
    _compiler(root)
    _assets(root)
    _defaults(root)
    _trunk(root)
    _excludes(root)
    _loops(root)
    _actuators(root)
    _sensors(root)
    if keyframes:
        frame = add(root, "keyframe")
        for name, (qpos, ctrl) in keyframes.items():
            add(frame, "key", name=name, qpos=fmt(qpos), ctrl=fmt(ctrl))
    ET.indent(root, space="  ")
    return ET.tostring(root, encoding="unicode") + "\n"


__all__ = ["LimbGeometry", "build_robot", "joint_ranges", "servo_of"]
