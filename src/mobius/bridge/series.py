"""What topics said at other times than those asked for: held, or on the way between."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def latest(times: ArrayLike, at: ArrayLike) -> NDArray[np.int64]:
    """(n,) which of the rising ``times`` [s] was last at each of ``at``; the first before it."""
    return np.maximum(np.searchsorted(times, np.asarray(at) + 1e-9, side="right") - 1, 0)


def held(times: list[float], values: list[Any], at: Array) -> Array | None:
    """(n, ...) the value said last at each time; None where nothing was ever said."""
    return read_only(np.asarray(values, dtype=float)[latest(times, at)]) if times else None


def between(times: list[float], values: ArrayLike, at: Array) -> Array:
    """(n, k) values (m, k) linear between their times, the ends held."""
    columns = np.asarray(values, dtype=float).T
    return read_only(np.stack([np.interp(at, times, column) for column in columns], axis=-1))


def turned_between(times: list[float], q: ArrayLike, at: Array) -> Array:
    """(n, 4) unit quaternions on the shorter way between (m, 4), normalised linear.

    Over the 33 ms between two poses of a log the difference from the exact arc is far below
    the sensors' noise.
    """
    q = np.array(q, dtype=float)
    flips = np.cumprod(np.where(np.sum(q[1:] * q[:-1], axis=-1) < 0, -1.0, 1.0))
    q[1:] *= flips[:, None]
    out = np.array(between(times, q, at))
    return read_only(out / np.linalg.norm(out, axis=-1, keepdims=True))


def read_only(array: Array) -> Array:
    """The array, not to be written to any more."""
    array.setflags(write=False)
    return array
