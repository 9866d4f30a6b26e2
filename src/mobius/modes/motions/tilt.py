"""How the trunk lies to the vertical, in angles that make sense all the way round.

With ``u_B`` the world's up in the trunk frame (x forward, y left, z up):

    pitch_B = atan2(-u_x, u_z)      roll_B = atan2(u_y, u_z)      lean_B = asin(u_y)

``pitch_B`` is the rotation about +y_B that brought a level trunk there, so nose down is
positive (REP-103). Crawling it is 0; upright (nose up, the biped) -pi/2; on the back +-pi; on
the head +pi/2. A backward roll runs 0, -pi/2, -+pi, +pi/2, 0. ``roll_B`` is +-pi on the back
and jumps about where the trunk is upright; ``lean_B`` in [-pi/2, pi/2] does not.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import asin, atan2, pi

from numpy.typing import ArrayLike

from mobius.geometry import quat_conj, rotate

ANGLES = ("pitch_B", "roll_B")
"""Angles a condition may ask for."""


@dataclass(frozen=True)
class Tilt:
    """The trunk's angles to the vertical [rad]."""

    pitch_B: float
    """0 belly down, -pi/2 nose up, +-pi on the back, +pi/2 on the head."""
    roll_B: float
    """0 belly down, +pi/2 on the right side (left side up), +-pi on the back."""
    lean_B: float
    """How far the left side is up, -pi/2 to pi/2; 0 in every posture but on a side."""


def tilt_of(q_OB: ArrayLike) -> Tilt:
    """Angles of a trunk orientation (4,) wxyz."""
    x, y, z = rotate(quat_conj(q_OB), (0.0, 0.0, 1.0)).tolist()
    return Tilt(atan2(-x, z), atan2(y, z), asin(max(-1.0, min(1.0, y))))


def wrapped(angle: float) -> float:
    """An angle [rad] in [-pi, pi)."""
    return (angle + pi) % (2.0 * pi) - pi
