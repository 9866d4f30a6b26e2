"""Eq. (23): the governor on samples, with a KD-tree.

The state is (x, v, W) as measured, the reference (x_ref, W_ref).

As printed the nearest sample is sought over all five coordinates at once, in metres, m/s and
newtons alike, and its references are taken. Nothing keeps x, v and W where they are. Repaired:
coordinates are scaled by the grid's cells; the sample nearest in (x, v, W) is sought first and
must be within half a cell's diagonal, then its admissible reference nearest to the wish; a wish
in the same cell passes unchanged; without a sample near by the last reference is held (to
follow the measured position instead would let the integral action drive the loop away). A grid
has holes between its samples either way: this governor proves nothing.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from mobius.control.governor.interface import Governor, Verdict
from mobius.control.governor.sampled_set import SampledSet

__all__ = ["NearestGovernor", "Nearest"]

Array = NDArray[np.float64]
STATE, REFERENCE = [0, 1, 3], [2, 4]


class Nearest:
    """The look-up of one axis."""

    def __init__(self, samples: SampledSet) -> None:
        """Args: samples, printed or repaired; that decides the look-up."""
        self.samples = samples
        self._points = samples.points
        if not samples.repaired:
            self._tree = cKDTree(self._points)
            return
        steps = samples.grid.steps
        self._cell, self._step = steps[STATE], steps[REFERENCE]
        states, group = np.unique(self._points[:, STATE], axis=0, return_inverse=True)
        self._tree = cKDTree(states / self._cell)
        counts = np.bincount(group)
        order = np.argsort(group, kind="stable")
        place = np.arange(len(order)) - np.repeat(np.cumsum(counts) - counts, counts)
        self._choices = np.full((len(states), counts.max(), 2), np.inf)
        self._choices[group[order], place] = self._points[order][:, REFERENCE] / self._step
        self._near = 0.5 * np.sqrt(len(STATE))

    def choose(self, state: Array, r: Array, last: Array) -> tuple[Array, NDArray[np.bool_]]:
        """References (b, 2) and which of them found no sample near by.

        Args:
            state: (b, 3) x, v, W.
            r: (b, 2) wishes.
            last: (b, 2) references of the last step.
        """
        if not self.samples.repaired:
            o = np.stack([state[:, 0], state[:, 1], r[:, 0], state[:, 2], r[:, 1]], axis=1)
            _, at = self._tree.query(o)
            return self._points[at][:, REFERENCE], np.zeros(len(r), bool)
        away, at = self._tree.query(state / self._cell)
        wish = r / self._step
        choices = self._choices[at]
        off = np.square(choices - wish[:, None]).sum(axis=2)
        pick = off.argmin(axis=1)
        best = choices[np.arange(len(r)), pick]
        same = (np.abs(best - wish) <= 0.5).all(axis=1)
        v = np.where(same[:, None], r, best * self._step)
        lost = away > self._near
        return np.where(lost[:, None], last, v), lost


class NearestGovernor(Governor):
    """Algorithm 3 in the loop, one look-up an axis."""

    def __init__(self, samples: SampledSet | Sequence[SampledSet]) -> None:
        """Args: samples, one set an axis."""
        several = not isinstance(samples, SampledSet)
        each: tuple[SampledSet, ...] = (
            (samples,) if isinstance(samples, SampledSet) else tuple(samples)
        )
        super().__init__(len(each) if several else None, 3, 2)
        same: dict[int, list[int]] = {}
        for a, samples_of_axis in enumerate(each):  # axes that share a set are looked up at once
            same.setdefault(id(samples_of_axis), []).append(a)
        self._look_ups = [(np.array(axes), Nearest(each[axes[0]])) for axes in same.values()]

    def _decide(self, x: Array, r: Array) -> tuple[Array, Verdict]:
        v, lost = np.empty_like(r), np.zeros(len(r), bool)
        for axes, look_up in self._look_ups:
            v[axes], lost[axes] = look_up.choose(x[axes], r[axes], self._v[axes])
        return v, Verdict(np.full(len(v), np.nan), lost, False)
