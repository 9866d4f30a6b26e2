"""The robot as URDF text, for rviz, Foxglove, Pinocchio: serial, from the same links as the MJCF.

A URDF is a tree, so the five-bars are open at the coupler's far end. Their two passive joints
follow the cranks, but not linearly: a mimic joint would put the links centimetres off. They are
ordinary moving joints here, and whoever publishes ``/joint_states`` publishes them as well, from
:func:`mobius.model.passive.passive_joints`. The second finger of a gripper mirrors the first
exactly and is a mimic joint.

``base_link`` is an empty link that carries the trunk, as ROS likes its roots. Capsules, which
URDF lacks, are a cylinder and two spheres. Nothing refers to a file.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from mobius.geometry import quat_to_rpy, rpy_to_quat
from mobius.model.build import MATERIALS, add
from mobius.model.cameras import CAMERAS, HEAD_PITCH
from mobius.model.dimensions import limb_geometry
from mobius.model.joints import JOINTS
from mobius.model.links import Link, limb_links, trunk_collision, trunk_parts
from mobius.model.parts import Part, composite_inertia
from mobius.model.servo import servo_of
from mobius.types import LIMBS

Array = NDArray[np.float64]
Triple = tuple[float, float, float]

__all__ = ["TRUNK", "Fixed", "build_urdf", "fixed_frames"]

TRUNK = "trunk"
"""Link that holds what the MJCF's body ``base_link`` holds."""
_SAME = np.array([1.0, 0.0, 0.0, 0.0])


@dataclass(frozen=True, eq=False)
class Fixed:
    """A frame that never moves in its parent."""

    name: str
    parent: str
    p: Triple
    """[m]."""
    q: Array
    """(4,) wxyz."""


@cache
def fixed_frames() -> tuple[Fixed, ...]:
    """Every fixed joint of the URDF: trunk, IMU, gaze, cameras, wrist sensors, grippers, soles."""
    head, vio = CAMERAS["head"], CAMERAS["vio"]
    frames = [
        Fixed(TRUNK, "base_link", (0.0, 0.0, 0.0), _SAME),
        Fixed("imu", "base_link", (0.0, 0.0, 0.0), _SAME),
        Fixed("gaze", "base_link", head.pos, rpy_to_quat(0.0, HEAD_PITCH, 0.0)),
        Fixed("camera_color_optical_frame", "base_link", head.pos, head.optical),
        Fixed("vio_optical_frame", "base_link", vio.pos, vio.optical),
    ]
    for limb in LIMBS:
        side, g = limb.split("_")[0], limb_geometry(limb)
        tip, sites = (0.0, 0.0, -g.tip), _sites(limb_links(g))
        if g.is_arm:
            hand = f"{limb}_gripper_base"
            frames.append(Fixed(f"{side[0]}_wrist_ft", hand, sites[f"{side}_wrist_ft"], _SAME))
            frames.append(Fixed(f"{side[0]}_gripper", hand, tip, _SAME))
        else:
            frames.append(Fixed(f"{side[0]}_sole", f"{limb}_foot", tip, _SAME))
    return tuple(frames)


def _sites(link: Link) -> dict[str, Triple]:
    """Sites of a link and all below it, each in its own link."""
    return {**link.sites, **{k: v for c in link.children for k, v in _sites(c).items()}}


def build_urdf() -> str:
    """The robot's URDF as text."""
    root = ET.Element("robot", name="mobius")
    for name, rgba in MATERIALS.items():
        add(add(root, "material", name=name), "color", rgba=_numbers(rgba))
    add(root, "link", name="base_link")
    _link(root, TRUNK, trunk_parts(), trunk_collision())
    for limb in LIMBS:
        _branch(root, TRUNK, limb_links(limb_geometry(limb)))
    for frame in fixed_frames():
        if frame.name != TRUNK:
            add(root, "link", name=frame.name)
        joint = add(root, "joint", name=f"{frame.name}_fixed", type="fixed")
        _placed(joint, frame.parent, frame.name, frame.p, frame.q)
    ET.indent(root, space="  ")
    return ET.tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def _branch(root: ET.Element, parent: str, link: Link) -> None:
    """A link, the joint to its parent, and all below."""
    _link(root, link.name, link.parts, [part for part, _ in link.collision])
    _joint(root, parent, link)
    for child in link.children:
        _branch(root, link.name, child)


def _joint(root: ET.Element, parent: str, link: Link) -> None:
    assert link.joint is not None  # every link of a limb hangs on a hinge
    finger = link.joint.endswith("finger_b")
    driven = link.joint in JOINTS
    kind = "revolute" if driven or finger else "continuous"
    joint = add(root, "joint", name=link.joint, type=kind)
    q = _SAME if link.quat is None else np.array(link.quat)
    _placed(joint, parent, link.name, link.pos, q)
    add(joint, "axis", xyz=_numbers(link.axis))
    twin = f"{link.joint.split('_')[0]}_gripper"
    if driven or finger:
        servo = servo_of(link.joint if driven else twin)
        low, high = link.range or (0.0, 0.0)
        add(
            joint,
            "limit",
            lower=_numbers([low]),
            upper=_numbers([high]),
            effort=_numbers([servo.stall_torque]),
            velocity=_numbers([servo.motor.no_load_speed]),
        )
    if finger:
        add(joint, "mimic", joint=twin, multiplier="1", offset="0")


def _placed(joint: ET.Element, parent: str, child: str, p: Triple, q: Array) -> None:
    add(joint, "origin", xyz=_numbers(p), rpy=_numbers(quat_to_rpy(q)))
    add(joint, "parent", link=parent)
    add(joint, "child", link=child)


def _link(root: ET.Element, name: str, parts: Sequence[Part], solid: Sequence[Part]) -> None:
    """A link with its mass, its looks, and what it touches with."""
    link = add(root, "link", name=name)
    mass, com, inertia = composite_inertia([p for p in parts if p.mass > 0])
    inertial = add(link, "inertial")
    add(inertial, "origin", xyz=_numbers(com), rpy="0 0 0")
    add(inertial, "mass", value=_numbers([mass]))
    pairs = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2)}
    pairs["izz"] = (2, 2)
    add(inertial, "inertia", **{k: _numbers([inertia[at]]) for k, at in pairs.items()})
    for part in parts:
        for piece in _pieces(part):
            add(_shape(link, "visual", piece), "material", name=part.material)
    for part in solid:
        for piece in _pieces(part):
            _shape(link, "collision", piece)


def _pieces(part: Part) -> list[Part]:
    """The part, or what a capsule is made of."""
    if part.shape != "capsule":
        return [part]
    radius, half = part.size
    axis = half * part.rotation[:, 2]
    ends = [_moved(part.pos, sign * axis) for sign in (1.0, -1.0)]
    rod = Part("cylinder", part.size, part.pos, part.euler, material=part.material)
    return [rod, *(Part("sphere", (radius,), end, material=part.material) for end in ends)]


def _moved(p: Triple, by: Array) -> Triple:
    x, y, z = (float(v) for v in np.asarray(p) + by)
    return x, y, z


def _shape(link: ET.Element, what: str, part: Part) -> ET.Element:
    element = add(link, what)
    add(element, "origin", xyz=_numbers(part.pos), rpy=_numbers(part.euler))
    geometry = add(element, "geometry")
    if part.shape == "box":
        add(geometry, "box", size=_numbers([2 * s for s in part.size]))
    elif part.shape == "sphere":
        add(geometry, "sphere", radius=_numbers(part.size[:1]))
    else:
        radius, half = part.size
        add(geometry, "cylinder", radius=_numbers([radius]), length=_numbers([2 * half]))
    return element


def _numbers(values: Iterable[float]) -> str:
    """Numbers with nine significant digits, no negative zero."""
    return " ".join(f"{v + 0.0:.9g}" if abs(v) > 1e-12 else "0" for v in values)
