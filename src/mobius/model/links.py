"""Links of the robot: what each looks like, weighs and touches, in its own frame.

Limb frame (every limb body at joint angle zero): x outward, z up, y normal to the
five-bar plane; a link at angle zero hangs along -z. Left limbs are turned by +90 deg
about z_B, right limbs by -90 deg, so that angles mirror: yaw, roll change sign, the rest
do not.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field

import numpy as np

from mobius.model import dimensions as dim
from mobius.model.dimensions import LimbGeometry
from mobius.model.parts import Part, between

OUT = (0.0, -1.0, 0.0)
"""Axis of cranks, wrist pitch and ankle: positive turns "down" (-z) towards "out" (+x)."""
BEAM = 0.112
"""Half length of the cross beams [m] [A]: they end where the elbow passes at q21 = 3.1 rad."""
HALF_TURN = float(np.sqrt(0.5))


@dataclass(frozen=True)
class Link:
    """A body with one hinge to its parent."""

    name: str
    pos: tuple[float, float, float]
    joint: str | None
    axis: tuple[float, float, float] = OUT
    joint_class: str = "passive"
    range: tuple[float, float] | None = None
    quat: tuple[float, float, float, float] | None = None
    parts: tuple[Part, ...] = ()
    collision: tuple[tuple[Part, str], ...] = ()
    """(solid, ``"collision"`` or ``"sole"``)."""
    sites: dict[str, tuple[float, float, float]] = field(default_factory=dict)
    children: tuple[Link, ...] = ()


def trunk_parts() -> list[Part]:
    """Frame, battery in front, computer behind, rails and their posts, cameras."""
    m = dim.MASS_TRUNK
    plate, beam = 0.45 * m["frame"], 0.275 * m["frame"]
    parts = [
        Part("box", (0.150, 0.072, 0.004), (0, 0, -0.034), mass=0.5 * plate, material="carbon"),
        Part("box", (0.150, 0.072, 0.004), (0, 0, 0.034), mass=0.5 * plate, material="carbon"),
        Part("box", (0.022, BEAM, 0.016), (dim.HIP_X, 0, 0), mass=beam),
        Part("box", (0.022, BEAM, 0.016), (-dim.HIP_X, 0, 0), mass=beam),
        Part("box", (0.056, 0.062, 0.028), (0.075, 0, 0), mass=m["battery"], material="battery"),
        Part("box", (0.058, 0.062, 0.028), (-0.072, 0, 0), mass=m["computer"], material="computer"),
        Part("box", (0.012, 0.055, 0.020), (0, 0, 0), mass=m["electronics"], material="servo"),
        Part("box", (0.075, 0.050, 0.008), (0.0, 0, 0.046), material="shell"),
        Part(
            "box",
            (0.012, 0.045, 0.0125),
            (0.170, 0, 0.047),
            (0, np.radians(40.0), 0),
            m["head_camera"],
            "shell",
        ),
        Part(
            "box", (0.012, 0.054, 0.007), (-0.02, 0, 0.068), mass=m["vio_camera"], material="shell"
        ),
    ]
    for y in (-0.032, 0.032):
        parts.append(Part("cylinder", (0.011, 0.002), (-0.02, y, 0.075), material="lens"))
        nose = (0.170 + 0.011 * np.cos(np.radians(40.0)), 0.7 * y, 0.040)
        tilt = (0.0, float(np.radians(130.0)), 0.0)
        parts.append(Part("cylinder", (0.008, 0.002), nose, tilt, material="lens"))
    for k in range(4):  # fins of the computer
        x = -0.111 + 0.026 * k
        parts.append(Part("box", (0.003, 0.055, 0.005), (x, 0, -0.041), material="metal"))
    return parts + _rails()


def rail_points() -> list[tuple[float, float]]:
    """(x, z) of the corners of a rail, head to hip [m]."""
    reach = np.arcsin(dim.RAIL_HALF_LENGTH / dim.RAIL_RADIUS)
    angles = np.linspace(reach, -reach, 7)
    center = dim.RAIL_TOP - dim.RAIL_RADIUS
    return [
        (float(dim.RAIL_RADIUS * np.sin(a)), float(center + dim.RAIL_RADIUS * np.cos(a)))
        for a in angles
    ]


def _rails() -> list[Part]:
    points = rail_points()
    each = dim.MASS_TRUNK["rails"] / (2 * (len(points) - 1))
    parts = []
    for y in (-dim.RAIL_Y, dim.RAIL_Y):
        for (xa, za), (xb, zb) in itertools.pairwise(points):
            parts.append(between((xa, y, za), (xb, y, zb), 0.009, mass=each, material="rail"))
        for x, z in (points[0], points[-1], points[3]):
            foot = 0.85 * x
            parts.append(between((x, y, z), (foot, 0.7 * y, 0.034), 0.006, material="metal"))
    return parts


def trunk_collision() -> list[Part]:
    """Trunk box, cross beams, head camera and rails."""
    points = rail_points()
    parts = [
        Part("box", (0.152, 0.074, 0.040), (0, 0, 0)),
        Part("box", (0.022, BEAM, 0.016), (dim.HIP_X, 0, 0)),
        Part("box", (0.022, BEAM, 0.016), (-dim.HIP_X, 0, 0)),
    ]
    for y in (-dim.RAIL_Y, dim.RAIL_Y):
        for (xa, za), (xb, zb) in itertools.pairwise(points):
            parts.append(between((xa, y, za), (xb, y, zb), 0.009, material="rail"))
    return parts


def _servo_block(g: LimbGeometry) -> tuple[list[Part], Part]:
    """The yaw body: yaw servos, five-bar servos, bracket; and its collision box."""
    wide = 0.0335 if not g.is_arm else 0.0285
    total = dim.MASS_ARM["shoulder"] if g.is_arm else dim.MASS_LEG["hip"]
    mid = g.z_top - 0.5 * g.fivebar.w
    pair = 2 if g.is_arm else 1
    yaw = [
        Part("box", (0.017, 0.0143, 0.023), (0.0, 0.016 * k, 0.002), mass=0.082, material="servo")
        for k in (-1, 1)
    ]
    drive: list[Part] = []
    each = 0.082 if g.is_arm else 0.165
    half = (0.023, 0.017, 0.5 * wide - 0.0008) if g.is_arm else (0.029, 0.022, 0.5 * wide - 0.0008)
    rows = (-0.024, 0.024) if g.is_arm else (-0.012, 0.012)
    for z in (g.z_top, g.z_top - g.fivebar.w):
        for y in rows[:pair]:
            drive.append(Part("box", half, (g.x_off - 0.012, y, z), mass=each, material="servo"))
        drive.append(
            Part("cylinder", (0.011, 0.036), (g.x_off, 0, z), (np.pi / 2, 0, 0), material="horn")
        )
    rest = total - sum(p.mass for p in yaw + drive)
    bracket = [
        Part("box", (0.026, 0.046, 0.004), (-0.01, 0, -0.028), mass=0.4 * rest),
        Part("box", (0.004, 0.046, 0.040), (-0.040, 0, mid + 0.018), mass=0.6 * rest),
        Part("cylinder", (0.020, 0.006), (0, 0, 0.030), material="horn"),
    ]
    low = g.z_top - g.fivebar.w - 0.5 * wide
    box = Part("box", (0.030, 0.045, 0.5 * (0.034 - low)), (-0.013, 0, 0.5 * (0.034 + low)))
    return yaw + drive + bracket, box


def _bar(length: float, planes: tuple[float, ...], mass: float, width: float) -> list[Part]:
    """Flat bars of a link along -z with round ends, in planes y [m]."""
    parts = []
    share = mass / len(planes)
    for y in planes:
        body = Part("box", (width, 0.0025, 0.5 * length), (0, y, -0.5 * length), mass=share)
        ends = [
            Part("cylinder", (width + 0.002, 0.003), (0, y, z), (np.pi / 2, 0, 0))
            for z in (0.0, -length)
        ]
        parts += [body, *ends]
    pins = [
        Part(
            "cylinder",
            (0.005, max(abs(p) for p in planes) + 0.004),
            (0, 0, z),
            (np.pi / 2, 0, 0),
            material="horn",
        )
        for z in (0.0, -length)
    ]
    return parts + pins


def _capsule(length: float, radius: float) -> Part:
    return between((0, 0, 0), (0, 0, -length), radius, material="metal")


def limb_links(g: LimbGeometry) -> Link:
    """The tree of one limb, from the yaw body to fingers or foot."""
    masses = dim.MASS_ARM if g.is_arm else dim.MASS_LEG
    root = "shoulder" if g.is_arm else "hip"
    side = g.name.split("_")[0]
    fb = g.fivebar
    block, box = _servo_block(g)
    C = (fb.distal_joint * np.sin(-fb.offset), 0.0, -fb.distal_joint * np.cos(-fb.offset))
    coupler = Link(
        f"{g.name}_coupler",
        (0, 0, -fb.L1),
        f"{g.name}_coupler",
        parts=tuple(_bar(fb.coupler, (0.0,), masses["coupler"], 0.008)),
        sites={f"{g.name}_loop_coupler": (0, 0, -fb.coupler)},
    )
    crank_a = Link(
        f"{g.name}_crank_a",
        (g.x_off, 0, g.z_top),
        f"{side}_{root}_motor_a",
        joint_class=f"{root}_motor_a",
        range=dim.MOTOR_A_RANGE,
        parts=tuple(_bar(fb.L1, (-0.030, 0.030), masses["crank_a"], 0.009)),
        collision=((_capsule(fb.L1, 0.012), "collision"),),
        children=(coupler,),
    )
    end = _arm_end(g) if g.is_arm else _leg_end(g)
    crank_b = Link(
        f"{g.name}_crank_b",
        (g.x_off, 0, g.z_top - fb.w),
        f"{side}_{root}_motor_b",
        joint_class=f"{root}_motor_b",
        range=dim.MOTOR_B_RANGE,
        parts=tuple(_bar(fb.L1, (-0.020, 0.020), masses["crank_b"], 0.010)),
        collision=((_capsule(fb.L1, 0.012), "collision"),),
        children=(_distal(g, C, end),),
    )
    return Link(
        f"{g.name}_{root}",
        g.hip_B,
        f"{side}_{root}_yaw",
        axis=(0, 0, 1),
        joint_class=f"{root}_yaw",
        range=dim.YAW_RANGE,
        quat=(HALF_TURN, 0, 0, g.side * HALF_TURN),
        parts=tuple(block),
        collision=((box, "collision"),),
        children=(crank_a, crank_b),
    )


def _distal(g: LimbGeometry, C: tuple[float, float, float], end: Link) -> Link:
    """The shank or forearm: crank pin E at the origin, wrist or ankle at -z."""
    masses = dim.MASS_ARM if g.is_arm else dim.MASS_LEG
    length = g.fivebar.distal
    parts = [
        between((0, y, 0), (0, y, -length), 0.0065, mass=0.5 * masses["distal"], material="carbon")
        for y in (-0.009, 0.009)
    ]
    parts += [
        between((0, 0, -0.02), C, 0.005, material="metal"),
        between(C, (0, 0, -0.19), 0.005, material="metal"),
        Part("cylinder", (0.009, 0.014), C, (np.pi / 2, 0, 0), material="horn"),
        Part("cylinder", (0.011, 0.024), (0, 0, 0), (np.pi / 2, 0, 0), material="horn"),
    ]
    if g.is_arm:
        reach = end.pos[1]
        parts += [
            between((0, 0, -length + 0.012), (0, reach, -length + 0.012), 0.009, material="metal"),
            Part("box", (0.014, 0.012, 0.014), (0, 0, -length + 0.012), material="metal"),
        ]
    else:
        parts.append(
            Part(
                "box",
                (0.017, 0.022, 0.029),
                (0.020, 0, -length + 0.022),
                mass=masses["ankle_servo"],
                material="servo",
            )
        )
    collision = [(between((0, 0, 0), (0, 0, -length), 0.014, material="metal"), "collision")]
    if g.is_arm:
        pin = between((0, 0, -length), (0, end.pos[1], -length), 0.012, material="metal")
        collision.append((pin, "collision"))
    return Link(
        f"{g.name}_distal",
        (0, 0, -g.fivebar.L1),
        f"{g.name}_distal",
        parts=tuple(parts),
        collision=tuple(collision),
        sites={f"{g.name}_loop_distal": C},
        children=(end,),
    )


def _arm_end(g: LimbGeometry) -> Link:
    """Wrist pitch, roll, yaw; F/T sensor; GOAT gripper with two finger cells."""
    m = dim.MASS_ARM
    side = g.name.split("_")[0]
    _py, pz = dim.FINGER_PIVOT
    fingers = tuple(_finger(g, k) for k in ("a", "b"))
    palm = [
        Part("cylinder", (0.028, 0.009), (0, 0, -0.024), mass=m["ft_sensor"], material="metal"),
        Part("box", (0.020, 0.026, 0.009), (0, 0, -0.042), mass=m["palm"], material="shell"),
        Part("cylinder", (0.007, 0.030), (0.024, 0, -0.020), material="horn"),
    ]
    yaw = Link(
        f"{g.name}_gripper_base",
        (0, 0, 0),
        f"{side}_wrist_yaw",
        axis=(0, 0, 1),
        joint_class="wrist_yaw",
        range=dim.WRIST_RANGES["wrist_yaw"],
        parts=(
            Part(
                "box", (0.014, 0.023, 0.012), (0, 0, -0.004), mass=m["wrist_yaw"], material="servo"
            ),
            *palm,
        ),
        collision=((between((0, 0, -0.01), (0, 0, -0.04), 0.027, material="metal"), "collision"),),
        sites={
            f"{side}_wrist_ft": (0, 0, -0.024),
            f"{side}_gripper_site": (0, 0, -pz),
            f"{g.name}_tip": (0, 0, -g.tip),
        },
        children=fingers,
    )
    roll = Link(
        f"{g.name}_wrist_roll",
        (0, 0, 0),
        f"{side}_wrist_roll",
        axis=(1, 0, 0),
        joint_class="wrist_roll",
        range=dim.WRIST_RANGES["wrist_roll"],
        parts=(
            Part("box", (0.023, 0.014, 0.014), (0.0, 0, 0), mass=m["wrist_roll"], material="servo"),
        ),
        children=(yaw,),
    )
    return Link(
        f"{g.name}_wrist_pitch",
        (0, g.lateral * -g.side, -g.fivebar.distal),
        f"{side}_wrist_pitch",
        joint_class="wrist_pitch",
        range=dim.WRIST_RANGES["wrist_pitch"],
        parts=(
            Part(
                "cylinder", (0.017, 0.026), (0, 0, 0), (np.pi / 2, 0, 0), m["wrist_pitch"], "servo"
            ),
        ),
        children=(roll,),
    )


def _finger(g: LimbGeometry, which: str) -> Link:
    """One finger: proximal and distal cell, spines inside, rubber sole at the tip."""
    sign = 1 if which == "a" else -1
    side = g.name.split("_")[0]
    py, pz = dim.FINGER_PIVOT
    knee = (0.0, sign * dim.FINGER_KNEE[0], -dim.FINGER_KNEE[1])
    tip = (0.0, sign * dim.FINGER_TIP[0], -dim.FINGER_TIP[1])
    r = dim.FINGER_RADIUS
    parts = [
        between((0, 0, 0), knee, 0.007, mass=0.5 * dim.MASS_ARM["finger"], material="metal"),
        between(knee, tip, 0.0075, mass=0.5 * dim.MASS_ARM["finger"], material="carbon"),
        Part("sphere", (r,), tip, material="rubber"),
    ]
    for k in (0.35, 0.6, 0.85):
        at = tuple((1 - k) * a + k * b for a, b in zip(knee, tip, strict=True))
        parts.append(
            Part(
                "box", (0.009, 0.002, 0.002), (at[0], at[1] - sign * 0.007, at[2]), material="spine"
            )
        )
    return Link(
        f"{g.name}_finger_{which}",
        (0, sign * py, -pz),
        f"{side}_gripper" if which == "a" else f"{side}_finger_b",
        axis=(sign, 0, 0),
        joint_class="gripper" if which == "a" else "passive",
        range=dim.GRIPPER_RANGE,
        parts=tuple(parts),
        collision=(
            (between((0, 0, 0), knee, 0.008, material="metal"), "collision"),
            (between(knee, tip, r, material="rubber"), "sole"),
        ),
    )


def _leg_end(g: LimbGeometry) -> Link:
    """Flat narrow foot; toe towards -x, the belly side."""
    side = g.name.split("_")[0]
    length = dim.FOOT_TOE + dim.FOOT_HEEL
    x = 0.5 * (dim.FOOT_HEEL - dim.FOOT_TOE)
    half = (0.5 * length, 0.5 * dim.FOOT_WIDTH, 0.5 * dim.FOOT_THICK)
    z = -g.tip + 0.5 * dim.FOOT_THICK
    sole = Part("box", half, (x, 0, z))
    return Link(
        f"{g.name}_foot",
        (0, 0, -g.fivebar.distal),
        f"{side}_ankle_pitch",
        joint_class="ankle_pitch",
        range=dim.ANKLE_RANGE,
        parts=(
            Part("box", (half[0], half[1], 0.003), (x, 0, z + 0.002), mass=0.085, material="metal"),
            Part("box", (half[0], half[1], 0.002), (x, 0, z - 0.003), material="rubber"),
            Part("cylinder", (0.015, 0.020), (0, 0, 0), (np.pi / 2, 0, 0), material="horn"),
            between((0, 0, 0), (0.03, 0, z), 0.006, material="metal"),
            between((0, 0, 0), (-0.04, 0, z), 0.006, material="metal"),
        ),
        collision=((sole, "sole"),),
        sites={
            f"{side}_sole": (0, 0, -g.tip),
            f"{g.name}_tip": (0, 0, -g.tip),
        },
    )


def collision_of_limb(limb: str) -> list[str]:
    """Bodies of a limb that have collision geometry, root first."""
    if limb.endswith("arm"):
        names = ["shoulder", "crank_a", "crank_b", "distal", "gripper_base", "finger_a", "finger_b"]
    else:
        names = ["hip", "crank_a", "crank_b", "distal", "foot"]
    return [f"{limb}_{n}" for n in names]
