"""Why the back rails are as they are: what they lift the centre of mass by.

``python -m mobius.reproduce.rails``. The paper gives rails, but no shape (Sec. III-B6). Ours are
two arcs of one circle in the trunk's x-z plane. Lying on its back the robot is a rocker: while it
rolls on the arcs the circle's centre stays level and the centre of mass swings below it like a
pendulum's bob; beyond the arc's end it turns about that end.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.headless import import_mujoco
from mobius.model import dimensions as dim
from mobius.reproduce.common import as_text

__all__ = ["Rocker", "com_of", "rocker"]

Array = NDArray[np.float64]

TUBE = 0.009
"""Radius of the rails' tube [m]."""
OTHER = (0.20, 0.25, 0.30, 0.40, 0.60)
"""Radii to compare [m]."""


@dataclass(frozen=True)
class Rocker:
    """The robot on its rails, its joints held [m, rad]."""

    below: float
    """Centre of mass below the arcs' centre as it lies on its back; above 0 it rests there."""
    end_angle: float
    """Turn from the middle of the arcs to their head end."""
    rest: float
    """Height of the centre of mass where it rests."""
    at_end: float
    """Its height where it has rolled to the arcs' head end."""
    top: float
    """Its greatest height, over that end on the way to the head."""

    @property
    def climb(self) -> float:
        """Height to be won from rest to the top."""
        return max(self.top - self.rest, 0.0)

    @property
    def climb_over_end(self) -> float:
        """Height to be won once on the end."""
        return max(self.top - self.at_end, 0.0)


def rocker(com_B: ArrayLike, radius: float = dim.RAIL_RADIUS) -> Rocker:
    """Heights while the robot rocks on its rails.

    Args:
        com_B: (3,) centre of mass in ``base_link`` [m].
        radius: Of the arcs, as high and as long as ours [m].
    """
    x, _, z = np.asarray(com_B, dtype=float)
    centre = dim.RAIL_TOP - radius
    away = np.array([x, z - centre])  # from the circle's centre, in the plane x, z of B
    angle = float(np.arcsin(dim.RAIL_HALF_LENGTH / radius))
    outer = radius + TUBE

    def height(turn: float) -> float:
        """On the arcs, turned towards the head by ``turn``: +z_B points down at 0."""
        return outer - float(away @ [np.sin(turn), np.cos(turn)])

    rest = float(np.clip(np.arctan2(away[0], away[1]), -angle, angle))
    end = radius * np.array([np.sin(angle), np.cos(angle)])
    reach = float(np.linalg.norm(away - end))
    return Rocker(float(away[1]), angle, height(rest), height(angle), reach + TUBE)


def com_of(keyframe: str) -> Array:
    """Centre of mass (3,) [m] in ``base_link`` with the joints of a keyframe."""
    from mobius.assemble import flat_model
    from mobius.geometry import quat_conj, rotate
    from mobius.robot.sim import SimRobot

    robot = SimRobot(flat_model(), keyframe=keyframe)
    trunk = robot.model.body("base_link").id
    truth = robot.truth()
    return rotate(quat_conj(truth.q_OB), robot.data.subtree_com[trunk] - truth.p_OB)


def row_of(joints: str, com: Array, radius: float) -> dict[str, Any]:
    """One line of the table."""
    r = rocker(com, radius)
    return {
        "R m": radius,
        "joints as": joints,
        "com x m": round(float(com[0]), 3),
        "com z m": round(float(com[2]), 3),
        "below centre m": round(r.below, 3),
        "end deg": round(float(np.degrees(r.end_angle)), 1),
        "at rest m": round(r.rest, 3),
        "on the end m": round(r.at_end, 3),
        "top m": round(r.top, 3),
        "rest to top m": round(r.climb, 3),
        "end to top m": round(r.climb_over_end, 3),
    }


def main() -> None:
    """Print the heights for joints as in several keyframes, and for other radii."""
    import_mujoco()
    coms = {name: com_of(name) for name in ("supine", "crawl", "stand")}
    print(as_text([row_of(name, com, dim.RAIL_RADIUS) for name, com in coms.items()]))
    print()
    print(as_text([row_of("supine", coms["supine"], R) for R in OTHER]))


if __name__ == "__main__":
    main()
