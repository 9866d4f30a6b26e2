"""One hand of the robot alone, on the crosshead of a pulling machine: small and fast."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import mujoco

from mobius.errors import UnknownName
from mobius.model.build import ROBOT_XML, add, fmt

CROSSHEAD_MASS = 1.0
"""[kg] [A]."""
CROSSHEAD_STIFFNESS, CROSSHEAD_DAMPING = 5e4, 400.0
"""Of each of the three slides [N/m, N s/m] [A]: 124 N bend the machine by 2.5 mm."""
AXES = {"pull_x": (1, 0, 0), "pull_y": (0, 1, 0), "pull_z": (0, 0, 1)}


def load_hand(side: str = "left") -> mujoco.MjSpec:
    """The hand, fingers up, on three slides ``pull_x``, ``pull_y``, ``pull_z`` with servos.

    It is the robot's own, cut from its MJCF: bodies, inertias, finger servo, wrist sensors. World
    x is the hand's x (along a bar it grasps), world z is minus the hand's z: pulled down, it is
    pulled across the groove. The slides do not turn. The wrist centre starts at the origin.

    Raises:
        UnknownName: Neither ``left`` nor ``right``.
    """
    if side not in ("left", "right"):
        raise UnknownName("hand", side, ("left", "right"))
    return mujoco.MjSpec.from_string(hand_xml(side))


def hand_xml(side: str) -> str:
    """The MJCF of :func:`load_hand`."""
    root = ET.fromstring(ROBOT_XML.read_text())
    root.set("model", f"{side}_hand")
    world = _part(root, "worldbody")
    hand = next(b for b in world.iter("body") if b.get("name") == f"{side}_arm_gripper_base")
    for joint in hand.findall("joint"):
        hand.remove(joint)
    world.clear()
    head = add(world, "body", name="crosshead", quat="0 1 0 0", childclass="mobius")
    add(head, "inertial", pos="0 0 0", mass=fmt(CROSSHEAD_MASS), diaginertia="0.001 0.001 0.001")
    for name, axis in AXES.items():
        # the crosshead is turned by half a turn about x; its slides run along the world's axes
        local = (axis[0], -axis[1], -axis[2])
        add(head, "joint", name=name, type="slide", axis=fmt(local))
    hand.set("pos", "0 0 0")
    head.append(hand)
    _keep(root, "equality", f"{side}_fingers")
    _keep(root, "actuator", f"{side}_gripper")
    _keep(root, "sensor", f"{side}_wrist_force", f"{side}_wrist_torque")
    for tag in ("contact", "keyframe"):
        root.remove(_part(root, tag))
    for name in AXES:
        kp, kv = fmt(CROSSHEAD_STIFFNESS), fmt(CROSSHEAD_DAMPING)
        add(_part(root, "actuator"), "position", name=name, joint=name, kp=kp, kv=kv)
    return ET.tostring(root, encoding="unicode")


def _part(root: ET.Element, tag: str) -> ET.Element:
    part = root.find(tag)
    if part is None:
        raise RuntimeError(f"{ROBOT_XML} has no <{tag}>")
    return part


def _keep(root: ET.Element, tag: str, *names: str) -> None:
    """Drop all children of a section but those named."""
    section = _part(root, tag)
    for child in list(section):
        if child.get("name") not in names:
            section.remove(child)
