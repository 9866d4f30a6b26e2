"""How a trial of a motion begins: robot, floor and configuration drawn from the seed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mobius.assemble import Start, flat_model
from mobius.errors import InvalidInput
from mobius.geometry import quat_mul, rotate
from mobius.model.dimensions import MIN_CRANK_SPREAD
from mobius.model.joints import LIMB_JOINTS
from mobius.model.poses import lowest_point, overlap
from mobius.model.robot import (
    configuration,
    joint_limits,
    keyframe,
    keyframe_joints,
    passive_angles,
)
from mobius.robot.variation import Variation

Array = NDArray[np.float64]

JOINT_NOISE = 0.05
"""Spread of the joint angles at the start [rad]."""
FLOOR_TILT = float(np.radians(2.0))
"""Steepest floor [rad]."""
DROP = 0.4
"""Height a random fall begins at, lowest point over the floor [m]."""
DEEP = 1e-3
"""Links may touch at the start, but not overlap by more than this [m]."""
DRAWS = 500
"""Attempts at a configuration without overlap."""


@dataclass(frozen=True, eq=False)
class TrialStart:
    """One drawn robot on its floor."""

    model: Any
    """Compiled scene."""
    start: Start
    normal: Array
    """(3,) unit normal of the floor, which goes through the origin."""

    def height(self, p: Array) -> float:
        """Of a point (3,) [m] over the floor [m]."""
        return float(self.normal @ p)


def draw_start(pose: str, body: str, seed: int, *, joints: Array | None = None) -> TrialStart:
    """Robot, floor and configuration of one seed.

    Friction 0.5-1.2 of all surfaces, trunk +-1 kg, servos +-10 %, delay 0-20 ms
    (:meth:`Variation.sample`), joint noise 0.05 rad, floor tilted by up to 2 deg anywhere.

    Args:
        pose: A keyframe, or ``fall``: any orientation and any joint angles, 0.4 m up.
        body: Body of the mode it is to end in.
        seed: Of all draws.
        joints: (22,) joint angles [rad] instead of the keyframe's.
    """
    rng = np.random.default_rng([seed, 515])
    variation = replace(Variation.sample(np.random.default_rng(seed)), everywhere=True)
    model = flat_model()
    tilt = tilted(rng)
    floor = model.geom("floor").id
    model.geom_quat[floor] = tilt
    model.geom_sameframe[floor] = 0  # else its quaternion is not looked at
    if pose == "fall":
        qpos = _falling(model, rng)
    else:
        qpos = _standing(model, pose, rng, tilt, joints)
    start = Start(body=body, qpos=qpos, seed=seed, variation=variation)
    return TrialStart(model, start, rotate(tilt, np.array([0.0, 0.0, 1.0])))


def tilted(rng: np.random.Generator) -> Array:
    """Rotation (4,) of a floor that falls by up to 2 deg in a random direction."""
    angle, towards = rng.uniform(0.0, FLOOR_TILT), rng.uniform(0.0, 2 * np.pi)
    axis = np.array([np.cos(towards), np.sin(towards), 0.0])
    return np.array([np.cos(angle / 2), *(np.sin(angle / 2) * axis)])


def assembled(q: Array) -> bool:
    """Whether all five-bars can be closed at joint angles q (22,) on their usual branch."""
    cranks = [(q[s.start + 1], q[s.start + 2]) for s in LIMB_JOINTS.values()]
    apart = all(b - a >= MIN_CRANK_SPREAD for a, b in cranks)
    return apart and bool(np.isfinite(passive_angles(q)).all())


def _standing(
    model: Any, pose: str, rng: np.random.Generator, tilt: Array, joints: Array | None
) -> Array:
    """A keyframe, or its trunk with other joints, with noise on them, on the tilted floor."""
    q, base = keyframe_joints(pose)[0] if joints is None else joints, keyframe(pose)[0][:7]
    low, high = joint_limits()
    for _ in range(DRAWS):
        noisy = np.clip(q + JOINT_NOISE * rng.standard_normal(len(q)), low, high)
        if assembled(noisy):
            qpos = configuration(model, noisy, p=(0, 0, 2.0), quat=quat_mul(tilt, base[3:]))
            return _over_floor(model, qpos, 1e-3)
    raise InvalidInput(f"no noisy configuration around keyframe '{pose}' in {DRAWS} draws")


def _falling(model: Any, rng: np.random.Generator) -> Array:
    """Any orientation, any joint angles whose links do not overlap."""
    low, high = joint_limits()
    for _ in range(DRAWS):
        q = rng.uniform(low, high)
        quat = rng.standard_normal(4)
        if assembled(q):
            qpos = configuration(model, q, p=(0, 0, 2.0), quat=quat / np.linalg.norm(quat))
            if overlap(model, qpos) < DEEP:
                return _over_floor(model, qpos, DROP)
    raise InvalidInput(f"no random configuration without overlap in {DRAWS} draws")


def _over_floor(model: Any, qpos: Array, clearance: float) -> Array:
    qpos[2] -= lowest_point(model, qpos) - clearance
    return qpos
