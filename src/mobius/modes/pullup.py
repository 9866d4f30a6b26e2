r"""The pull-up as a script: which pose and which hand wrenches at which moment.

A way of twelve poses leads from the dead hang to the head above the bar. It was found by a
minimax search over bar position and lean (smallest share of stall torque, centre of mass under
the bar, upper arms clear of it); the hands' inner forces along it were chosen by a linear
program. The phases::

    hang -> tuck -> pull -> hold -> lower -> untuck -> done
                      \\____ abort: lower, untuck, let go

``hold`` lasts until :meth:`PullUpScript.ask_down`, or for ``hold_s``.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from mobius.errors import InvalidInput
from mobius.modes.motions.player import smooth_step
from mobius.modes.motions.way import Way
from mobius.types import frozen_array

__all__ = ["WAY", "Phase", "PullUpGoal", "PullUpScript", "PullUpTimes"]

Array = NDArray[np.float64]

WAY = np.array(
    [
        # x_B    z_B     lean  along torsion ahead
        [0.3720, -0.3180, 36.0, 5.5, -0.5, 0.005],
        [0.3334, -0.3180, 38.1, 5.5, -0.8, 0.011],
        [0.2949, -0.3180, 41.0, 5.5, -0.6, 0.014],
        [0.2563, -0.3171, 44.4, 5.0, -0.5, 0.016],
        [0.2184, -0.3092, 47.3, 4.0, -0.6, 0.018],
        [0.1853, -0.2900, 49.1, 1.5, -0.3, 0.020],
        [0.1555, -0.2653, 50.1, 0.0, 0.0, 0.022],
        [0.1283, -0.2379, 50.5, 0.0, 0.0, 0.024],
        [0.1037, -0.2082, 50.5, -0.5, -0.8, 0.024],
        [0.0840, -0.1730, 47.8, -1.5, -1.2, 0.023],
        [0.0640, -0.1360, 44.0, -2.0, -1.4, 0.020],
        [0.0475, -0.1040, 39.8, -4.5, -1.6, 0.016],
    ]
)
"""(12, 6) bar in the trunk's frame x_B, z_B [m] and lean [deg]; force along the bar [N] and
torsion about the pinch normal [N m] on each hand; bar ahead of the centre of mass [m]."""
WAY.setflags(write=False)
PINCH = 0.25
"""Moment about the hand's own axis, throughout [N m]."""


class Phase(StrEnum):
    """Where in the pull-up the robot is."""

    HANG = "hang"
    TUCK = "tuck"
    PULL = "pull"
    HOLD = "hold"
    LOWER = "lower"
    UNTUCK = "untuck"
    DONE = "done"
    ABORT = "abort"


_ENDS = {
    Phase.TUCK: (0.0, 1.0),
    Phase.PULL: (1.0, 1.0),
    Phase.LOWER: (0.0, 1.0),
    Phase.UNTUCK: (0.0, 0.0),
    Phase.ABORT: (0.0, 0.0),
}
"""Share of the way and legs at the end of a phase that moves."""


@dataclass(frozen=True)
class PullUpTimes:
    """How long each phase lasts [s]."""

    hang_s: float = 1.2
    """Dead hang on straight arms; the robot weighs itself in its second half."""
    tuck_s: float = 1.2
    """Legs forward, so that the centre of mass is under the bar."""
    pull_s: float = 4.5
    hold_s: float = 3.0
    lower_s: float = 4.0
    untuck_s: float = 1.0
    abort_s: float = 1.5
    """To the dead hang when a hand has lost its load."""

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not (np.isfinite(value) and value > 0):
                raise InvalidInput(f"PullUpTimes.{name}: expected seconds > 0, got {value}")


@dataclass(frozen=True, eq=False)
class PullUpGoal:
    """What is wished at one moment; hand wrenches are by the bar on the left hand, hand axes."""

    phase: Phase
    share: float
    """Of the way, 0 dead hang, 1 head above the bar."""
    x_B: float
    z_B: float
    """Bar in the trunk's frame [m]."""
    lean: float
    """[rad]."""
    along: float
    """Inner force along the bar [N]."""
    moments: Array
    """(3,) per unit of half the weight in N about the bar [m]; torsion, own axis [N m]."""
    legs: float
    """0 hanging, 1 drawn up."""
    grip: bool
    """Whether the hands hold on."""

    def __post_init__(self) -> None:
        frozen_array(self, "moments", self.moments, (3,))


class PullUpScript:
    """Walks through the phases by the clock; holds until asked down where ``wait`` is set."""

    def __init__(self, times: PullUpTimes | None = None, *, wait: bool = False) -> None:
        """Times of the phases; with ``wait`` the hold lasts until :meth:`ask_down`."""
        self.times, self.wait = times or PullUpTimes(), wait
        nodes = WAY.copy()
        nodes[:, 2] = np.radians(nodes[:, 2])
        self._way = Way(nodes)
        self.reset()

    def reset(self) -> None:
        """Back to the dead hang."""
        self.phase, self.reason = Phase.HANG, ""
        self._began: float | None = None
        self._from, self._legs_from = 0.0, 0.0
        self._share, self._legs, self._down = 0.0, 0.0, False

    def ask_down(self) -> None:
        """End the hold at the next step."""
        self._down = True

    def abort(self, reason: str) -> None:
        """Go down at once and let go; says why."""
        if self.phase not in (Phase.ABORT, Phase.DONE):
            self.phase, self.reason = Phase.ABORT, reason
            self._began, self._from, self._legs_from = None, self._share, self._legs

    def step(self, now: float) -> PullUpGoal:
        """The goal at time ``now`` [s]; times must not go back."""
        if self._began is None:
            self._began = now
        spent = now - self._began
        if spent >= self._length() - 1e-9 and self.phase not in (Phase.DONE, Phase.ABORT):
            self._next(now)
            spent = 0.0
        self._place(spent)
        return self.goal()

    def goal(self) -> PullUpGoal:
        """The goal as of the last step."""
        x, z, lean, along, torsion, ahead = self._way.at(self._share)
        over = self.phase is Phase.ABORT and self._share <= 0.0 and self._legs <= 0.0
        return PullUpGoal(
            self.phase,
            self._share,
            float(x),
            float(z),
            float(lean),
            float(along),
            np.array([ahead, torsion, PINCH]),
            self._legs,
            not over,
        )

    def at(self, share: float) -> PullUpGoal:
        """The goal at a share of the way, 0 to 1, with the legs drawn up."""
        if not 0.0 <= share <= 1.0:
            raise InvalidInput(f"PullUpScript.at: expected a share of 0 to 1, got {share}")
        self._share, self._legs = share, 1.0
        return self.goal()

    # -- inside ----------------------------------------------------------------------------

    def _length(self) -> float:
        if self.phase is Phase.HOLD:
            held = self._down or not self.wait
            return 0.0 if self._down else self.times.hold_s if held else np.inf
        return float(getattr(self.times, f"{self.phase.value}_s", np.inf))

    def _next(self, now: float) -> None:
        order = [Phase.HANG, Phase.TUCK, Phase.PULL, Phase.HOLD, Phase.LOWER, Phase.UNTUCK]
        self._share, self._legs = _ENDS.get(self.phase, (self._share, self._legs))
        at = order.index(self.phase) + 1
        self.phase = order[at] if at < len(order) else Phase.DONE
        self._began, self._from, self._legs_from = now, self._share, self._legs

    def _place(self, spent: float) -> None:
        """Share of the way and legs, ``spent`` [s] into the phase."""
        if self.phase not in _ENDS:
            return
        share, legs = _ENDS[self.phase]
        u = smooth_step(spent / self._length())
        self._share = self._from + u * (share - self._from)
        self._legs = self._legs_from + u * (legs - self._legs_from)
        if spent >= self._length():
            self._share, self._legs = share, legs
