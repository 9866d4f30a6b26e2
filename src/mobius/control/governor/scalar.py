"""The scalar governor: as far towards the wish as the set allows, in closed form."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mobius.control.governor.admissible import AdmissibleSet, fraction_of
from mobius.control.governor.interface import SetGovernor, Verdict

__all__ = ["ScalarGovernor"]

Array = NDArray[np.float64]


class ScalarGovernor(SetGovernor):
    """``v+ = v + kappa (r - v)`` with the largest kappa in [0, 1] that stays in the set.

    kappa is a minimum over the rows, one division each. kappa = 0 is always safe: from a state
    in the set the last reference may be held forever.
    """

    def __init__(self, sets: AdmissibleSet | Sequence[AdmissibleSet]) -> None:
        """Args: sets as in :class:`SetGovernor`."""
        super().__init__(sets)
        both = np.concatenate([self._G_x, self._G_v], axis=2)
        self._G_T = np.ascontiguousarray(both.transpose(0, 2, 1))
        self._n = self._G_x.shape[2]
        self._pair = np.zeros((len(both), 2, both.shape[2]))  # (x, v) and (0, r - v)

    def _decide(self, x: Array, r: Array) -> tuple[Array, Verdict]:
        v, n, pair = self._v, self._n, self._pair
        move = r - v
        pair[:, 0, :n], pair[:, 0, n:], pair[:, 1, n:] = x, v, move
        taken = pair @ self._G_T
        room = 1.0 - taken[:, 0]
        kappa = fraction_of(room, taken[:, 1])
        outside = room.min(axis=1) < self._edge
        # the wish itself, not v + (r - v), where all of the way is admissible
        given = np.where(kappa[:, None] >= 1.0, r, v + kappa[:, None] * move)
        return given, Verdict(kappa, outside, False)
