"""What every governor does: a state and a wish in, a reference that is safe out."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.control.governor.admissible import AdmissibleSet
from mobius.errors import InvalidInput

__all__ = ["Governor", "Verdict"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Verdict:
    """What the last step of a governor decided, per axis."""

    kappa: Array
    """(a,) share of the way from the last reference to the wish; nan where it has no meaning."""
    outside: NDArray[np.bool_]
    """(a,) whether the state is out of the set by more than rounding and pruning explain:
    something happened that was not assumed. The last reference is held."""
    invalid: bool
    """Whether state or wish were not finite; the last reference is held on every axis."""

    @property
    def ok(self) -> bool:
        """Whether everything is as assumed."""
        return not (self.invalid or bool(self.outside.any()))


class Governor(ABC):
    """``step(x, r)`` returns the reference to give to the loop instead of the wish r.

    Of one axis x is (n,), r is (m,); of several (a, n) and (a, m). ``verdict`` says what the
    last step decided. State and wish that are not finite, and states from which nothing is
    known to be safe, hold the last reference.
    """

    def __init__(self, axes: int | None, states: int, references: int) -> None:
        """Args: axes (None: one, without that dimension), n, m."""
        self._state_shape = (states,) if axes is None else (axes, states)
        self._shape = (references,) if axes is None else (axes, references)
        self._count = axes or 1
        self._v = np.zeros((self._count, references))
        self.verdict = Verdict(np.ones(self._count), np.zeros(self._count, bool), False)
        """Of the last step."""

    @property
    def v(self) -> Array:
        """The reference of the last step, shaped like r."""
        return self._v.reshape(self._shape).copy()

    def step(self, x: ArrayLike, r: ArrayLike) -> Array:
        """The reference for now.

        Args:
            x: State as measured.
            r: Reference that is wished for.

        Raises:
            InvalidInput: x or r has the wrong shape.
        """
        state, wish = self._sized("x", x, self._state_shape), self._sized("r", r, self._shape)
        # squares add up to a finite number only if all are; a third of the time of np.isfinite
        if isfinite(np.vdot(state, state) + np.vdot(wish, wish)):
            self._v, self.verdict = self._decide(state, wish)
        else:
            still = np.zeros(self._count)
            self.verdict = Verdict(still, np.zeros(self._count, bool), True)
        return self._v.reshape(self._shape).copy()

    def reset(self, x: ArrayLike, v: ArrayLike | None = None) -> Array:
        """Begin at a state with a reference that is held there; zero if left out.

        Args:
            x: State.
            v: Reference.
        """
        self._sized("x", x, self._state_shape)
        wish = np.zeros(self._shape) if v is None else v
        self._v = self._sized("v", wish, self._shape).copy()
        return self.v

    @abstractmethod
    def _decide(self, x: Array, r: Array) -> tuple[Array, Verdict]:
        """Reference (a, m) and verdict for x (a, n), r (a, m), all finite."""

    def _sized(self, name: str, value: ArrayLike, shape: tuple[int, ...]) -> Array:
        array = np.asarray(value, dtype=float)
        if array.shape != shape:
            raise InvalidInput(
                f"{type(self).__name__}.step: {name}: expected shape {shape}, got {array.shape}"
            )
        return array.reshape(self._count, shape[-1])


class SetGovernor(Governor):
    """A governor with an admissible set an axis behind it."""

    def __init__(self, sets: AdmissibleSet | Sequence[AdmissibleSet]) -> None:
        """Args: sets, one an axis, all with the same numbers of states and references.

        The loop is taken to be at rest at zero; call :meth:`reset` where it is not.
        """
        several = not isinstance(sets, AdmissibleSet)
        self.sets: tuple[AdmissibleSet, ...] = (
            (sets,) if isinstance(sets, AdmissibleSet) else tuple(sets)
        )
        if not self.sets or len({s.sizes[1:] for s in self.sets}) != 1:
            raise InvalidInput(
                "expected at least one set, all with the same numbers of states and references,"
                f" got {[s.sizes[1:] for s in self.sets]}"
            )
        _, n, m = self.sets[0].sizes
        super().__init__(len(self.sets) if several else None, n, m)
        most = max(s.sizes[0] for s in self.sets)
        self._G_x = np.stack([_padded(s.G_x, most) for s in self.sets])
        self._G_v = np.stack([_padded(s.G_v, most) for s in self.sets])
        self._edge = np.array([-s.loss for s in self.sets]) - 1e-6

    def reset(self, x: ArrayLike, v: ArrayLike | None = None) -> Array:
        """Begin at a state with a reference that is held there.

        Args:
            x: State.
            v: Reference; the one that keeps the most room if left out.

        Raises:
            InvalidInput: No reference, or not this one, is admissible from there.
        """
        state = self._sized("x", x, self._state_shape)
        if v is None:
            self._v = np.stack([s.project(x_) for s, x_ in zip(self.sets, state, strict=True)])
        else:
            wish = self._sized("v", v, self._shape)
            for s, x_, v_ in zip(self.sets, state, wish, strict=True):
                if not s.contains(x_, v_):
                    raise InvalidInput(
                        f"reset: the reference {v_.tolist()} is not admissible from the state"
                        f" {x_.tolist()}; leave it out to have one chosen"
                    )
            self._v = wish.copy()
        return self.v


def _padded(rows: Array, count: int) -> Array:
    """Rows with zeros below: 0 <= 1 always holds."""
    return np.vstack([rows, np.zeros((count - len(rows), rows.shape[1]))])
