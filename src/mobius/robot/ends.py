"""How the ends of the limbs, grippers and feet, press and slide on the ground."""

from __future__ import annotations

from math import sqrt

import mujoco
import numpy as np
from numpy.typing import NDArray

from mobius.types import LIMBS

Array = NDArray[np.float64]


class LimbEnds:
    """Finds the contacts between limb ends and the floor in a simulator's state."""

    def __init__(self, model: mujoco.MjModel, floors: NDArray[np.int64]) -> None:
        """Args: ``floors`` are the geoms that count as ground."""
        self._model, self._floors = model, frozenset(floors.tolist())
        self._limb_of = [*limb_of_geoms(model).tolist(), -1]  # the last for geom -1
        self._body_of = model.geom_bodyid.tolist()
        self._root = model.body("base_link").id

    def contact(self, data: mujoco.MjData) -> tuple[Array, Array]:
        """Normal force (4,) [N] and sliding speed (4,) [m/s] of each end; order LIMBS.

        The force is summed over an end's contact points; the speed is that of the material at
        these points along the ground, weighted by force, so that a sphere that rolls does not
        slide. Both are 0 in the air.
        """
        contact, force = data.contact, np.zeros(6)
        total, slide = [0.0] * 4, [0.0] * 4
        points, frames = contact.pos.tolist(), contact.frame[:, :3].tolist()
        com = data.subtree_com[self._root].tolist()
        for i, (a, b) in enumerate(contact.geom.tolist()):  # floats: faster than small arrays
            geom = b if a in self._floors else a if b in self._floors else -1
            limb = self._limb_of[geom]
            if limb >= 0:
                mujoco.mj_contactForce(self._model, data, i, force)
                press = float(force[0])
                total[limb] += press
                twist = data.cvel[self._body_of[geom]].tolist()
                slide[limb] += press * sliding_speed(twist, com, points[i], frames[i])
        speed = [s / f if f > 0.0 else 0.0 for s, f in zip(slide, total, strict=True)]
        return np.array(total), np.array(speed)


def limb_of_geoms(model: mujoco.MjModel) -> NDArray[np.int64]:
    """(ngeom,) which of LIMBS ends in this geom, with its gripper or foot; -1 elsewhere."""
    limb_of = np.full(model.nbody, -1, dtype=np.int64)
    for k, limb in enumerate(LIMBS):
        end = "gripper_base" if limb.endswith("arm") else "foot"
        limb_of[model.body(f"{limb}_{end}").id] = k
    for body in range(1, model.nbody):  # parents come first
        if limb_of[body] < 0:
            limb_of[body] = limb_of[model.body_parentid[body]]
    return limb_of[model.geom_bodyid]


def sliding_speed(
    twist: list[float], origin: list[float], point: list[float], normal: list[float]
) -> float:
    """Speed [m/s] along a plane of a body's material at a point.

    Args:
        twist: Angular [rad/s], then linear velocity [m/s] of the body at ``origin``.
        origin: Where the twist is taken [m].
        point: Where the speed is asked for [m].
        normal: Unit normal of the plane.
    """
    wx, wy, wz, vx, vy, vz = twist
    x, y, z = (p - o for p, o in zip(point, origin, strict=True))
    vx, vy, vz = vx + wy * z - wz * y, vy + wz * x - wx * z, vz + wx * y - wy * x
    up = vx * normal[0] + vy * normal[1] + vz * normal[2]
    return sqrt(max(vx * vx + vy * vy + vz * vz - up * up, 0.0))
