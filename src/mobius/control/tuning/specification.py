"""What a well-tuned loop is, as numbers that should all be zero.

For gains theta the last window is played again: the very law of :mod:`mobius.control
.admittance.law`, servo lag and wrench filter, against the contact as estimated, with the
disturbance that explains what was measured. That gives

0. force error, root mean square over the window / ``force_scale``
1. position error the same way / ``position_scale``
2. excess over the grasp's limit surface, sum (f_i / f_limit_i)^2 <= margin^2
3. lack of manipulability below ``manipulability_min``, relative
4. lack of damping of the slowest-decaying oscillation below ``damping_min`` over the interval
   of stiffnesses and lags
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mobius.control.admittance.law import batch_steps
from mobius.control.admittance.stability import Interval, Loop, damping
from mobius.errors import InvalidInput

__all__ = ["Specification", "Window", "measured", "predicted"]

Array = NDArray[np.float64]

SIZE = 5
"""Numbers in the specification."""


@dataclass(frozen=True, eq=False)
class Specification:
    """Scales: what counts as 1."""

    force_scale: float = 1.0
    """[N]."""
    position_scale: float = np.inf
    """[m]; infinite where force is all that counts."""
    force_limits: Array | None = None
    """(n,) semi-axes of the grasp's limit surface [N]; none if not given."""
    slip_margin: float = 0.8
    """Share of the limit surface that may be used."""
    manipulability: Callable[[Array], Array] | None = None
    """Deviations (..., n) [m] -> measure (...), in batches: for example
    :func:`mobius.model.force_ellipsoid.strength` at the places they lead to."""
    manipulability_min: float = 0.0
    damping_min: float = 0.4
    """Wished damping ratio of every pole."""
    weights: Array = field(default_factory=lambda: np.array([1.0, 1.0, 5.0, 5.0, 10.0]))
    """(5,) factors on the numbers above."""

    def __post_init__(self) -> None:
        for name in ("force_scale", "position_scale"):
            if not getattr(self, name) > 0:
                raise InvalidInput(f"Specification.{name}: expected a number > 0")
        if np.shape(self.weights) != (SIZE,) or (np.asarray(self.weights) < 0).any():
            raise InvalidInput(f"Specification.weights: expected {SIZE} numbers >= 0")

    def of_series(self, f: Array, w: Array, x: Array, x_ref: Array) -> Array:
        """The first four numbers (..., 4) of series (..., t, n)."""
        out = np.zeros((*f.shape[:-2], 4))
        out[..., 0] = _rms(f - w) / self.force_scale
        out[..., 1] = _rms(x - x_ref) / self.position_scale
        if self.force_limits is not None:
            use = np.sqrt(np.sum((f / self.force_limits) ** 2, axis=-1, keepdims=True))
            out[..., 2] = _rms(np.maximum(use - self.slip_margin, 0.0))
        if self.manipulability is not None and self.manipulability_min > 0:
            ends = np.stack([x.min(axis=-2), x.max(axis=-2)], axis=-2)
            worst = self.manipulability(ends).min(axis=-1)
            out[..., 3] = np.maximum(1.0 - worst / self.manipulability_min, 0.0)
        return out * self.weights[:4]


def _rms(e: Array) -> Array:
    """Over ticks and axes (..., t, n)."""
    value: Array = np.sqrt(np.mean(np.square(e), axis=(-2, -1)))
    return value


@dataclass(frozen=True, eq=False)
class Window:
    """What was seen of n axes over t ticks."""

    f: Array
    """(t, n) wrench as read, before the filter [N]."""
    w: Array
    """(t, n) wished wrench [N]."""
    x: Array
    """(t, n) commanded position [m]."""
    x_ref: Array
    """(t, n) [m]."""
    y: Array
    """(t, n) position of the servo, by the nominal lag [m]."""
    start: Array
    """(n, 6) state at the first tick: x, v, z, y, filtered wrench, x before."""


def measured(spec: Specification, window: Window) -> Array:
    """(4,) the specification's first numbers as they were."""
    return spec.of_series(window.f, window.w, window.x, window.x_ref)


def predicted(
    gains: Array, spec: Specification, window: Window, K: Array, interval: Interval, loop: Loop
) -> Array:
    """(k, 5) the specification for gains (k, 6) that all n axes share.

    Args:
        gains: M, D, K, K_f, K_fi, K_pi.
        spec: Scales.
        window: What was seen.
        K: (n, n) contact stiffness [N/m].
        interval: Stiffnesses and lags of the damping.
        loop: Nominal lag, filter, delay.
    """
    f, x = replay(gains, window, K, loop)
    out = np.empty((len(gains), SIZE))
    out[:, :4] = spec.of_series(f, window.w, x, window.x_ref)
    lack = np.maximum(spec.damping_min - damping(gains, interval, loop), 0.0)
    out[:, 4] = spec.weights[4] * lack
    return out


def replay(gains: Array, window: Window, K: Array, loop: Loop) -> tuple[Array, Array]:
    """Wrench as read and command (k, t, n) had these gains run over the window."""
    k, (t, n), a = len(gains), window.f.shape, loop.filter_coefficient
    A, B, E = batch_steps(gains, loop.tau, loop.dt)
    keep = float(np.exp(-loop.dt / loop.tau)) if loop.tau > 0 else 0.0
    d = window.f + window.y @ K  # what the reading would be with the servo at rest (K symmetric)
    # One matrix per gains over all axes. Order: x, v, z, y, w, x before; each n long.
    eye, M = np.eye(n), np.zeros((k, 6 * n, 6 * n))
    block = M.reshape(k, 6, n, 6, n)
    block[:, :4, :, :4, :] = A[:, :, None, :, None] * eye[:, None, :]
    if loop.delay:
        block[:, 3] = 0.0
        block[:, 3, :, 3], block[:, 3, :, 5] = keep * eye, (1 - keep) * eye
        E = E.copy()
        B = B.copy()
        E[:, 3], B[:, 3] = 0.0, 0.0
    filtered = np.zeros((n, 6, n))
    filtered[:, 3], filtered[:, 4] = -a * K, (1 - a) * eye
    block[:, :4] += E[:, :, 0, None, None, None] * filtered
    block[:, 4] = filtered
    block[:, 5, :, 0] = eye
    u = np.zeros((k, t, 6, n))
    u[:, :, :4] = (
        B[:, None, :, :1] * window.x_ref[None, :, None]
        + B[:, None, :, 1:] * window.w[None, :, None]
        + a * E[:, None] * d[None, :, None]
    )
    u[:, :, 4] = a * d
    return _run(M, u.reshape(k, t, 6 * n), window.start.T.reshape(-1), d, K)


def _run(M: Array, u: Array, start: Array, d: Array, K: Array) -> tuple[Array, Array]:
    k, t, _ = u.shape
    n = d.shape[1]
    s = np.tile(start, (k, 1))[:, :, None]
    x, y = np.empty((k, t, n)), np.empty((k, t, n))
    for i in range(t):
        x[:, i], y[:, i] = s[:, :n, 0], s[:, 3 * n : 4 * n, 0]
        s = M @ s + u[:, i, :, None]
    s_max = 1e6
    x, y = np.clip(x, -s_max, s_max), np.clip(y, -s_max, s_max)
    return d - y @ K, x
