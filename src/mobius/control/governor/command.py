"""The command governor: the admissible reference nearest to the wish, by a small QP."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.control.governor.admissible import AdmissibleSet
from mobius.control.governor.interface import SetGovernor, Verdict
from mobius.errors import InvalidInput, MissingDependency

__all__ = ["CommandGovernor"]

Array = NDArray[np.float64]


class CommandGovernor(SetGovernor):
    """``v = argmin |v - r|_Q`` over all v with (x, v) in the set; the QP is daqp's.

    It may turn where the scalar governor only shortens: with several references it gives up
    less of the wish. It needs the package daqp (extra ``qp``).
    """

    def __init__(
        self, sets: AdmissibleSet | Sequence[AdmissibleSet], *, weights: ArrayLike | None = None
    ) -> None:
        """Args: sets as in :class:`SetGovernor`; weights (m,) of the references, > 0.

        Left out, a weight is one over the square of how far its reference can go at all.

        Raises:
            MissingDependency: daqp is not installed.
            InvalidInput: Sets or weights do not fit.
        """
        super().__init__(sets)
        try:
            import daqp
        except ImportError:
            raise MissingDependency("daqp", "qp", "the command governor") from None
        self._daqp: Any = daqp
        m = self._shape[-1]
        if weights is None:
            scale = np.array([[s.steady_range(e) for e in np.eye(m)] for s in self.sets])
            self._scale = scale
        else:
            given = np.asarray(weights, float)
            if given.shape != (m,) or not np.isfinite(given).all() or (given <= 0).any():
                raise InvalidInput(f"weights: expected {m} numbers > 0, got {given.tolist()}")
            self._scale = np.tile(given**-0.5, (len(self.sets), 1))
        # in units of the scale: H = I, rows G_v * scale
        self._rows = [
            np.ascontiguousarray(s.G_v * c) for s, c in zip(self.sets, self._scale, strict=True)
        ]
        self._eye = np.eye(m)

    def _decide(self, x: Array, r: Array) -> tuple[Array, Verdict]:
        v, kappa = self._v.copy(), np.full(len(r), np.nan)
        outside = np.zeros(len(r), bool)
        for a, (s, rows, scale) in enumerate(zip(self.sets, self._rows, self._scale, strict=True)):
            room = 1.0 - s.G_x @ x[a]
            if (room >= s.G_v @ r[a]).all():
                v[a] = r[a]
                continue
            found = self._nearest(rows, room, r[a] / scale)
            if found is None:  # hold; is it only the rim, or was something not as assumed?
                outside[a] = (room - s.G_v @ v[a]).min() < self._edge[a]
            else:
                v[a] = found * scale
        return v, Verdict(kappa, outside, False)

    def _nearest(self, rows: Array, room: Array, wish: Array) -> Array | None:
        """The point of ``rows u <= room`` nearest to the wish; None where there is none."""
        low = np.full(len(room), -1e30)
        sense = np.zeros(len(room), dtype=np.int32)
        u, _, flag, _ = self._daqp.solve(self._eye, -wish, rows, room, low, sense)
        u = np.asarray(u)
        if flag < 1 or not np.isfinite(u).all() or (rows @ u > room + 1e-7).any():
            return None
        return u
