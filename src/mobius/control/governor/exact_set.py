"""The maximal output admissible set as a polytope (Gilbert and Tan), robust and pruned.

    O_inf = {(x, v): H y(k) <= h for all k >= 0, v held}

Row k of it is ``H C A^k x + H (C sum_{j<k} A^j B + D) v <= h - sum_{j<k} max_w H C A^j E w``.
Three things make it finite and small, and each only makes the set smaller, never unsafe:

- the steady state is held ``epsilon`` inside its limits, so that late rows are implied;
- the disturbance is subtracted row by row (Kolmanovsky and Gilbert);
- rows that others imply up to ``tolerance`` are left out and all others moved in by as much.

Integrators are states of A. The held reference is the one mode with eigenvalue 1; its rows are
the steady state's.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mobius.control.governor.admissible import AdmissibleSet
from mobius.control.governor.redundancy import Bound, Pruner
from mobius.control.governor.system import Constraints, Disturbance, LinearSystem
from mobius.errors import InvalidInput, MobiusError

__all__ = ["EmptySet", "exact_set"]

Array = NDArray[np.float64]

STRIDE = 8
"""Steps between the rows that are looked at one by one; those between are interpolated, and
the error of that is bounded over the whole set."""


class EmptySet(InvalidInput):
    """No state is admissible: the disturbance alone breaks a limit."""


def exact_set(
    system: LinearSystem,
    constraints: Constraints,
    *,
    disturbance: Disturbance | None = None,
    epsilon: float = 0.02,
    tolerance: float = 0.005,
    max_steps: int = 20_000,
) -> AdmissibleSet:
    """The largest set of states and held references from which no limit is ever broken.

    Args:
        system: The loop.
        constraints: Of the outputs.
        disturbance: What w may be at every step; nothing if left out.
        epsilon: Share of each limit that the steady state keeps free, 0 < epsilon < 1.
        tolerance: Relative size that may be lost for fewer rows; 0 keeps every row that matters.
        max_steps: Give up if the set is not determined by then.

    Raises:
        InvalidInput: Sizes do not fit, a number is out of range, or the set is unbounded.
        EmptySet: The disturbance alone breaks a limit.
        MobiusError: Not determined within ``max_steps``.
    """
    check(system, constraints, disturbance, epsilon, tolerance)
    n = len(system.A)
    steps, stride = min(64, max_steps), STRIDE if tolerance > 0 else 1
    while True:
        rows, steady = _rows(system, constraints, disturbance, epsilon, steps + 1)
        pruner, step_of = _coarse(rows, steady, steps, stride, tolerance)
        if all(pruner.implies(p) for p in rows[steps + 1] if p.any()):
            break
        if steps >= max_steps:
            raise MobiusError(
                f"the admissible set is not determined after {steps} steps; raise epsilon"
                f" (now {epsilon:g}) or max_steps, or make the slowest mode of the loop faster"
            )
        steps = min(2 * steps, max_steps)
    size = Bound(pruner.rows)
    if not size.finite:
        raise InvalidInput(
            "the admissible set is unbounded: some combination of state and reference is never"
            " seen by a limit; limit one more output, for instance the reference itself"
        )
    missed = _between(rows, pruner, size, steps, stride, tolerance, step_of)
    inner = pruner.rows * (1.0 + tolerance + missed)
    return AdmissibleSet(
        G_x=inner[:, :n], G_v=inner[:, n:], horizon=steps, last_step=max(step_of),
        loss=tolerance + missed, epsilon=epsilon,
    )  # fmt: skip


def _coarse(
    rows: Array, steady: Array, steps: int, stride: int, tolerance: float
) -> tuple[Pruner, list[int]]:
    """Prune the steady rows and every ``stride``-th step; also the step of every row kept."""
    _, q, width = rows.shape
    scale = np.abs(rows).reshape(-1, width).max(axis=0)
    scale[scale == 0.0] = 1.0
    pruner = Pruner(scale, tolerance)
    times = np.arange(0, steps + 1, stride)
    candidates = np.vstack([steady, rows[times].reshape(-1, width)])
    when = np.concatenate([np.zeros(len(steady), int), np.repeat(times, q)])
    useful = np.abs(candidates).max(axis=1) > 0
    taken = pruner.add(candidates[useful])
    return pruner, when[useful][taken].tolist()


def _between(
    rows: Array, pruner: Pruner, size: Bound, steps: int, stride: int, tolerance: float,
    step_of: list[int],
) -> float:  # fmt: skip
    """Bound what the steps between the strides miss; add those that miss too much."""
    missed_most = 0.0
    for offset in range(1, stride):
        t = np.arange(offset, steps + 1 - stride + offset, stride)
        share = offset / stride
        near = (1 - share) * rows[t - offset] + share * rows[t - offset + stride]
        missed = size(rows[t] - near)
        wanting = missed > tolerance / 2
        if wanting.any():
            when = np.broadcast_to(t[:, None], missed.shape)[wanting]
            step_of += when[pruner.add(rows[t][wanting])].tolist()
        missed_most = max(missed_most, float(missed[~wanting].max(initial=0.0)))
    return missed_most


def _rows(
    system: LinearSystem,
    constraints: Constraints,
    disturbance: Disturbance | None,
    epsilon: float,
    steps: int,
) -> tuple[Array, Array]:
    """Rows (steps + 1, q, n + m) and the steady state's (q, n + m), scaled to one."""
    n, m = system.B.shape
    on_x, on_v = constraints.H @ system.C, constraints.H @ system.D
    HC, HD, room = on_x, on_v, constraints.h.copy()
    if disturbance is not None:
        room = room - disturbance.support(constraints.H @ system.F)
    rows = np.empty((steps + 1, len(room), n + m))
    for k in range(steps + 1):
        require_room(room, constraints, k)
        rows[k] = np.hstack([on_x, on_v]) / room[:, None]
        if disturbance is not None:
            room = room - disturbance.support(on_x @ system.E)
        on_v = on_v + on_x @ system.B
        on_x = on_x @ system.A
    final = final_room(room, on_x, system, disturbance, constraints)
    rest = (HC @ system.steady_state + HD) / ((1.0 - epsilon) * final[:, None])
    return rows, np.hstack([np.zeros((len(rest), n)), rest])


def final_room(
    room: Array,
    on_x: Array,
    system: LinearSystem,
    disturbance: Disturbance | None,
    constraints: Constraints,
) -> Array:
    """What the disturbance leaves of the room (q,) of rows (q, n) in the end."""
    if disturbance is None:
        return room
    for k in range(200_000):
        step = disturbance.support(on_x @ system.E)
        room = room - step
        require_room(room, constraints, k)
        if (step < 1e-12 * constraints.h).all():
            break
        on_x = on_x @ system.A
    return room


def require_room(room: Array, constraints: Constraints, step: int) -> None:
    """Raise :class:`EmptySet` where a limit has no room (q,) left."""
    if (room > 0).all():
        return
    q = int(np.argmin(room / constraints.h))
    raise EmptySet(
        f"no state is admissible: after {step} steps the disturbance alone breaks limit {q}"
        f" ({constraints.h[q]:g} for the output combination {constraints.H[q].tolist()});"
        " assume a smaller disturbance or widen that limit"
    )


def check(
    system: LinearSystem,
    constraints: Constraints,
    disturbance: Disturbance | None,
    epsilon: float,
    tolerance: float,
) -> None:
    """Raise :class:`InvalidInput` where sizes do not fit or a number is out of range."""
    sizes = system.sizes
    if constraints.H.shape[1] != sizes[2]:
        raise InvalidInput(
            f"constraints: expected H with {sizes[2]} columns, one per output,"
            f" got {constraints.H.shape[1]}"
        )
    if disturbance is not None and disturbance.vertices.shape[1] != sizes[3]:
        raise InvalidInput(
            f"disturbance: expected {sizes[3]} numbers, one per column of E and F,"
            f" got {disturbance.vertices.shape[1]}"
        )
    if not 0 < epsilon < 1:
        raise InvalidInput(f"epsilon: expected 0 < epsilon < 1, got {epsilon}")
    if not 0 <= tolerance < 0.5:
        raise InvalidInput(f"tolerance: expected 0 <= tolerance < 0.5, got {tolerance}")
