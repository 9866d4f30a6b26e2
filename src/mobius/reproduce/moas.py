"""What Fig. 18 and ``mobius moas`` share: which states each set admits."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mobius.control.governor import AdmissibleSet, Axis, algorithm_3, axis_set
from mobius.control.governor.nearest import Nearest

__all__ = ["bare", "sampled_contains", "states_of", "volumes"]

Array = NDArray[np.float64]


def states_of(o: Array) -> tuple[Array, Array]:
    """State (b, 4) and reference (b, 2) of the model for samples (b, 5) of Algorithm 3.

    Algorithm 3 knows neither servo nor integrals: the servo is where it was told to be, and the
    integral action is zero.

    Args:
        o: x, v, x_ref, W, W_ref.
    """
    zero = np.zeros(len(o))
    return np.stack([o[:, 0], o[:, 1], zero, o[:, 0]], axis=1), o[:, [2, 4]]


def bare(axis: Axis) -> Axis:
    """The axis under the assumptions of Algorithm 3: in the air, no servo lag, no outside force."""
    return replace(axis, servo_lag=0.0, disturbance=0.0, environment=(0.0, 0.0))


def sampled_contains(look_up: Nearest, o: Array) -> NDArray[np.bool_]:
    """Which of o (b, 5) are within half a cell of a sample that is admissible."""
    v, lost = look_up.choose(o[:, [0, 1, 3]], o[:, [2, 4]], np.full((len(o), 2), np.inf))
    return ~lost & (v == o[:, [2, 4]]).all(axis=1)


def volumes(axis: Axis, rows: AdmissibleSet, count: int, *, seed: int = 0) -> dict[str, Any]:
    """Shares of random (x, v, x_ref) within limits that each set admits; W = W_ref = 0.

    ``exact_share`` is that of the set given. The others are under the assumptions of Algorithm 3
    (:func:`bare`), so that like is compared with like.

    Args:
        axis: Limits.
        rows: Its exact set, with all that is assumed.
        count: Random points.
        seed: Of them.
    """
    rng = np.random.default_rng(seed)
    reach = np.array([axis.position_max, axis.velocity_max, axis.position_max])
    o = np.zeros((count, 5))
    o[:, :3] = rng.uniform(-1.0, 1.0, (count, 3)) * reach
    plain = bare(axis)
    exact = axis_set(plain, tolerance=0.005).contains(*states_of(o))
    look_up = Nearest(algorithm_3(plain, repaired=True))
    sampled = sampled_contains(look_up, o)
    both = float((exact & sampled).sum())
    return {
        "exact_share": float(rows.contains(*states_of(o)).mean()),
        "bare_exact_share": float(exact.mean()),
        "bare_sampled_share": float(sampled.mean()),
        "sampled_over_exact": float(sampled.sum() / max(1, exact.sum())),
        "sampled_unsafe": 1.0 - both / max(1.0, float(sampled.sum())),
    }
