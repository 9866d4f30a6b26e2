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
        ones = np.ones((*self._G_x.shape[:2], 1))
        both = np.concatenate([-self._G_x, -self._G_v, ones], axis=2)
        self._G_T = np.ascontiguousarray(both.transpose(0, 2, 1))
        axes, n = len(both), self._G_x.shape[2]
        self._pair = np.zeros((axes, 2, both.shape[2]))  # (x, v, 1) and (0, v - r, 0)
        self._pair[:, 0, -1] = 1.0
        self._at, self._back = self._pair[:, 0, :-1], self._pair[:, 1, n:-1]
        self._out = np.empty((axes, 2, both.shape[1]))
        self._room, self._toward = self._out[:, 0], self._out[:, 1]
        self._work = np.empty((axes, both.shape[1]))

    def _decide(self, x: Array, r: Array) -> tuple[Array, Verdict]:
        v = self._v
        np.concatenate([x, v], axis=1, out=self._at)
        np.subtract(v, r, out=self._back)
        np.matmul(self._pair, self._G_T, out=self._out)
        least = self._room.min(axis=1)
        kappa = fraction_of(self._room, self._toward, least=least, work=self._work)
        verdict = Verdict(kappa, least < self._edge, False)
        # the wish itself, not v + (r - v), where all of the way is admissible
        given = r.copy()
        if kappa.min() < 1.0:
            share = kappa[:, None]
            np.copyto(given, v - share * self._back, where=share < 1.0)
        return given, verdict
