"""Held keys become a twist: a dead man's switch.

The robot moves by hand only while beats say that keys are held *now*. A beat that is older than
:data:`STALE` counts as hands off, whatever it said: a page that hangs with a key down stops the
robot. After a stop keys count once they have all been let go. Where nobody is, nothing that makes
the robot move can be asked either: a click may come after the page that it was made on has gone.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mobius.control.bodies import BODIES
from mobius.errors import InvalidInput
from mobius.types import Mode
from mobius.view.live.nouns import Beat

Array = NDArray[np.float64]

STALE = 0.2
"""A beat counts for so long [s]."""
GONE = 0.3
"""A viewer that has not been heard of for this long [s] is gone."""


class Hands:
    """What the person at the controls does."""

    def __init__(self) -> None:
        self.limit = 1.0
        """Share of the body's greatest speeds that held keys reach."""
        self._beat, self._at = Beat(page=False), -np.inf
        self._armed = self._must_let_go = False

    def take(self, beat: Beat, now: float) -> None:
        """A beat that came at ``now`` [s] on any clock that only goes forward.

        Raises:
            InvalidInput: A share is not a number from -1 to 1.
        """
        share = np.asarray(beat.share, dtype=float)
        if share.shape != (3,) or not (np.abs(share) <= 1.0).all():
            raise InvalidInput(f"Beat.share: expected 3 numbers from -1 to 1, got {beat.share}")
        self._beat, self._at = beat, now
        self._armed |= beat.page and beat.driving
        self._must_let_go &= beat.driving and bool(share.any())

    def touch(self, now: float) -> None:
        """Somebody asked something of the robot: from now on they must stay.

        Raises:
            InvalidInput: Nobody is at the controls.
        """
        if not self._beat.page or now - self._at > GONE:
            raise InvalidInput("not done: nobody is at the controls any more; ask again")
        self._armed = True

    def let_go(self) -> None:
        """Keys that are held now count no more until all have been let go."""
        self._must_let_go = True

    def set_limit(self, share: float) -> None:
        """Bound the speed of held keys to a share (0 to 1] of the body's greatest."""
        if not 0.0 < share <= 1.0:
            raise InvalidInput(f"speed limit: expected a share > 0 and <= 1, got {share}")
        self.limit = share

    def holding(self, now: float) -> bool:
        """Whether a key that moves the robot is held."""
        beat = self._beat
        fresh = now - self._at <= STALE and not self._must_let_go
        return fresh and beat.page and beat.driving and any(v != 0.0 for v in beat.share)

    def twist(self, mode: Mode, now: float) -> Array:
        """(3,) vx, vy [m/s], wz [rad/s] that the keys ask of the body; zeros when none is held."""
        body = BODIES.get(mode.value)
        if body is None or not self.holding(now):
            return np.zeros(3)
        share = self.limit * np.asarray(self._beat.share, dtype=float)
        high, low = np.array(body.command_high), -np.array(body.command_low)
        return np.where(share >= 0.0, share * high, share * low)

    def lost(self, now: float) -> str:
        """Why there is nobody at the controls any more; empty while there is.

        Only of somebody who has asked something of the robot or driven it, and once; who comes
        back has to release the stop.
        """
        beat, fresh = self._beat, now - self._at <= GONE
        if not self._armed or (beat.page and fresh):
            return ""
        self._armed = False
        return "the page is gone" if fresh else "the viewer is gone"
