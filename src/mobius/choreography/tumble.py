"""Turning over on the back rails: the roll, and up again from back, head and belly (Fig. 13 A, C).

A roll begins as the robot rears up; then it throws itself back before it stands, lands on the
rails, and goes on over the head. Its four key poses (throw, tuck, over, land) are the same on
both sides, and what starts the next is the trunk's pitch, not the clock.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from mobius.choreography.keys import HIGH, LOW, mirrored, sampled, within_limits
from mobius.choreography.rear import (
    FOOT,
    HAND,
    HEIGHT,
    MIRROR,
    along,
    feet_under,
    rear_up,
    rise,
)
from mobius.choreography.rear import NUMBERS as REAR_NUMBERS
from mobius.model.reach import body_joints
from mobius.model.robot import keyframe_joints
from mobius.modes.motions import Motion, Stage, Until, Window
from mobius.modes.posture import Posture

Array = NDArray[np.float64]
Numbers = Mapping[str, float]
Range = tuple[float, float, float]

ANYHOW = Window()
"""Limbs may be spread, and put to the floor, in whatever heap the robot lies: that is what sorts
it out."""
STRAIGHT = Window(lean=0.9)
"""Guard of everything that turns over: a trunk that leans sideways by more than 52 deg has left
the rails."""
BELLY_DOWN = Window(pitch=0.0, within=1.0, lean=0.8)
"""Guard of pushing up: it lies on its belly, however askew."""
TURN = 100.0
"""A condition on the pitch holds for this much of the turn after it [deg]: the trunk passes that
in 0.1 s and more."""


def _poses(count: int) -> dict[str, Range]:
    return {
        f"p{k}{j}": (float(LOW[j]), float(HIGH[j]), 0.25) for k in range(count) for j in range(8)
    }


ROLL_NUMBERS: dict[str, Range] = {
    **REAR_NUMBERS,
    **_poses(4),
    "d0": (0.2, 0.9, 0.1),
    **{f"d{k}": (0.15, 0.9, 0.1) for k in (1, 2, 3)},
    "a0": (95.0, 150.0, 12.0),
    "a1": (150.0, 240.0, 12.0),
    "a2": (220.0, 330.0, 12.0),
    "h": (0.0, 0.8, 0.1),
}
"""Of the roll: name -> (lowest, highest, first spread). ``p01`` is joint 1 (of FREE) of pose 0,
``d`` times of the moves [s], ``a`` angles turned back at which the next move starts [deg], ``h``
the rest after landing [s]."""

OVER_NUMBERS: dict[str, Range] = {
    **_poses(4),
    "d0": (0.2, 1.2, 0.1),
    "d1": (0.12, 0.9, 0.1),
    "d2": (0.15, 0.9, 0.1),
    "d3": (0.15, 0.9, 0.1),
    "h0": (0.0, 0.8, 0.1),
    "a0": (170.0, 250.0, 12.0),
    "a1": (220.0, 330.0, 12.0),
    "h": (0.0, 0.8, 0.1),
}
"""Of the way from the back over the head, likewise."""


def turned_back(angle: float) -> Until:
    """The trunk has turned nose up and over by ``angle`` [deg], and not TURN more."""

    def pitch(a: float) -> float:
        return float(np.radians((-a + 180.0) % 360.0 - 180.0))

    return Until("pitch_B", above=pitch(angle + TURN), below=pitch(angle))


def _pose(n: Numbers, k: int) -> Array:
    return within_limits(mirrored([n[f"p{k}{j}"] for j in range(8)]))


def _into_stance() -> Stage:
    return Stage(keyframe_joints("crawl")[1], 0.8, hold=0.3, window=BELLY_DOWN)


def roll(n: Numbers) -> Motion:
    """Fig. 13 C: a full turn backward, from the crawl stance to the crawl stance."""
    turn = [
        Stage(_pose(n, k), n[f"d{k}"], until=turned_back(n[f"a{k}"]), timeout=0.5, window=STRAIGHT)
        for k in range(3)
    ]
    land = Stage(_pose(n, 3), n["d3"], hold=n["h"], window=STRAIGHT)
    stages = (*feet_under(n), rear_up(n), *turn, land, _into_stance())
    return Motion("roll", Posture.CRAWLING, Posture.CRAWLING, stages)


def _spread() -> Stage:
    """Limbs out flat: from almost any heap the trunk comes to lie on its back or its belly."""
    return Stage(keyframe_joints("prone")[0], 0.4, hold=0.25, window=ANYHOW)


def _over(n: Numbers) -> tuple[Stage, ...]:
    """From a headstand on arms and rails over to the belly."""
    over = Stage(_pose(n, 2), n["d2"], until=turned_back(n["a1"]), timeout=1.6, window=STRAIGHT)
    return over, Stage(_pose(n, 3), n["d3"], hold=n["h"], window=STRAIGHT)


def _from_back(n: Numbers) -> tuple[Stage, ...]:
    """From the back on the belly: limbs wind up, the rails roll it on its head, and over."""
    return (
        _spread(),
        Stage(_pose(n, 0), n["d0"], hold=n["h0"], window=STRAIGHT),
        Stage(_pose(n, 1), n["d1"], until=turned_back(n["a0"]), timeout=1.2, window=STRAIGHT),
        *_over(n),
    )


def supine_to_crawl(n: Numbers) -> Motion:
    """From the back over the rails and the head to the crawl stance."""
    stages = (*_from_back(n), _into_stance())
    return Motion("supine_to_crawl", Posture.SUPINE, Posture.CRAWLING, stages)


def supine_recovery(n: Numbers) -> Motion:
    """From the back to the stand: over, and pushed up with the feet under the hips at once."""
    crouch = Stage(feet_under(n)[-1].q, 0.7, hold=0.1, window=BELLY_DOWN)
    stages = (*_from_back(n), crouch, rear_up(n), *rise(n))
    return Motion("supine_recovery", Posture.SUPINE, Posture.STANDING, stages)


def head_recovery(n: Numbers) -> Motion:
    """From the head: into the same headstand, over to the belly, up on four limbs."""
    stages = (Stage(_pose(n, 0), n["d0"], hold=n["h0"], window=STRAIGHT), *_over(n), _into_stance())
    return Motion("head_recovery", Posture.ON_HEAD, Posture.CRAWLING, stages)


LOW_HEIGHT = 0.20
"""Trunk lying on its shoulders and hips, a little raised [m]."""
WIDE_HAND, WIDE_FOOT = np.array([0.33, 0.33, 0.0]), np.array([-0.27, 0.32, 0.0])
"""Where hand and foot come down beside the lying trunk [m]."""


def prone_to_crawl() -> Motion:
    """Fig. 13 A: hands and feet to the floor beside the trunk, then push it up evenly."""

    def up(u: float) -> Array:
        hand = WIDE_HAND + (HAND - WIDE_HAND) * u
        foot = WIDE_FOOT + (FOOT - WIDE_FOOT) * u
        p = np.array([0.0, 0.0, LOW_HEIGHT + (HEIGHT - LOW_HEIGHT) * u])
        return body_joints(
            np.eye(3), p, hands_M=(hand, hand * MIRROR), feet_M=(foot, foot * MIRROR)
        )

    stages = (
        Stage(within_limits(up(0.0)), 0.8, hold=0.1, window=ANYHOW),
        along(sampled(up, 6), 1.0, window=BELLY_DOWN),
        Stage(keyframe_joints("crawl")[1], 0.2, hold=0.3, window=BELLY_DOWN),
    )
    return Motion("prone_to_crawl", Posture.PRONE, Posture.CRAWLING, stages)
