"""Which posture the robot is in, and whether it has fallen, from belief and encoders alone."""

from __future__ import annotations

from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from mobius.geometry import quat_conj, rotate
from mobius.model.reach import end
from mobius.types import LIMBS, Mode, StateEstimate

Array = NDArray[np.float64]


class Posture(StrEnum):
    """How the robot lies or stands."""

    CRAWLING = "crawling"
    STANDING = "standing"
    PRONE = "prone"
    SUPINE = "supine"
    ON_HEAD = "on_head"
    LEFT_SIDE = "left_side"
    RIGHT_SIDE = "right_side"
    OTHER = "other"


CLEAR = 0.72
"""Share of the vertical along one trunk axis from which a posture has a name (44 deg)."""
STANCE = 0.90
"""And from which the trunk is level or upright enough to crawl or stand (26 deg)."""
CRAWL_DEPTH = 0.215
"""A limb that reaches this far below the trunk's centre carries it while crawling [m]; the
stance is 0.275 m high, a swinging limb reaches 0.237 m."""
STAND_DEPTH = 0.36
"""And while standing [m]; the stance is 0.474 m high."""


def up_in_trunk(belief: StateEstimate) -> Array:
    """(3,) the world's up in the trunk frame."""
    return rotate(quat_conj(belief.q_OB), np.array([0.0, 0.0, 1.0]))


def depths(q: Array, up_B: Array) -> Array:
    """(4,) how far each limb's end is below the trunk's centre [m], order LIMBS.

    Args:
        q: (22,) joint angles [rad].
        up_B: (3,) up in the trunk frame.
    """
    return np.array([depth(limb, q, up_B) for limb in LIMBS])


def depth(limb: str, q: Array, up_B: Array) -> float:
    """How far the end of one limb is below the trunk's centre [m]; as :func:`depths`."""
    return float(-np.nan_to_num(end(limb, q)) @ up_B)


def posture_of(belief: StateEstimate, q: Array) -> Posture:
    """The posture at a belief and joint angles q (22,) [rad].

    The trunk's axis nearest to the vertical decides. Level or upright, the limbs tell a stance
    from lying; an upright trunk that does not stand on both feet is ``other``.
    """
    up = up_in_trunk(belief)
    axis = int(np.argmax(np.abs(up)))
    positive = bool(up[axis] > 0)
    if abs(float(up[axis])) < CLEAR:
        return Posture.OTHER
    if axis == 1:
        return Posture.RIGHT_SIDE if positive else Posture.LEFT_SIDE
    if not positive:
        return Posture.ON_HEAD if axis == 0 else Posture.SUPINE
    steady = float(up[axis]) > STANCE
    if axis == 2:
        carried = int((depths(q, up) > CRAWL_DEPTH).sum()) >= 3
        return Posture.CRAWLING if steady and carried else Posture.PRONE
    on_feet = bool((depths(q, up)[2:] > STAND_DEPTH).all())
    return Posture.STANDING if steady and on_feet else Posture.OTHER


TIPPED = 0.6
"""A trunk with less than this share of the vertical along its proper axis has fallen (53 deg):
no gait leans further, and no stance comes back from there."""
TIPPED_S = 0.08
"""For this long [s]: five samples, so that one strange belief is not a fall."""
SUNK = {Mode.CRAWL: 0.17, Mode.BIPED: 0.34}
"""No limb reaches this far below the trunk's centre: it lies on the floor [m]."""
SUNK_S = 0.35
"""For this long [s]; a jump or a shove may lift the limbs for less."""
LOOK_S = 0.1
"""The limbs are looked at this often [s]; their kinematics cost more than all the rest."""
_AXIS = {Mode.CRAWL: 2, Mode.BIPED: 0}


class FallDetector:
    """Says that the robot has fallen, in crawl and biped mode; sees belief and encoders only."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget what has been seen, as on a change of mode."""
        self._tipped_since, self._sunk_since = np.inf, np.inf
        self._look_at = -np.inf
        self._limbs = list(LIMBS)

    def fallen(self, mode: Mode, belief: StateEstimate, q: Array) -> str:
        """Why it has fallen, or ``""``; call at 60 Hz.

        Args:
            mode: The mode it is in; other modes than crawl and biped never fall.
            belief: Now.
            q: (22,) joint angles [rad].
        """
        if mode not in _AXIS:
            return ""
        now, up = belief.stamp, up_in_trunk(belief)
        tipped = float(up[_AXIS[mode]]) < TIPPED
        self._tipped_since = min(self._tipped_since, now) if tipped else np.inf
        if now >= self._look_at:
            sunk = not self._carried(q, up, SUNK[mode])
            self._sunk_since = min(self._sunk_since, now) if sunk else np.inf
            self._look_at = now + LOOK_S - 1e-9
        if now - self._tipped_since >= TIPPED_S:
            return f"fall: the trunk leans {np.degrees(np.arccos(up[_AXIS[mode]])):.0f} deg"
        if now - self._sunk_since >= SUNK_S:
            return f"fall: no limb carries the trunk at {SUNK[mode]:g} m"
        return ""

    def _carried(self, q: Array, up: Array, reach: float) -> bool:
        """Whether any limb reaches ``reach`` [m] below the trunk's centre; the one that did last
        is asked first, so most looks cost one limb.
        """
        for limb in self._limbs:
            if depth(limb, q, up) >= reach:
                self._limbs.remove(limb)
                self._limbs.insert(0, limb)
                return True
        return False
