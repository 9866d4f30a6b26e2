"""The admissible set of a loop with an unknown parameter that may jump, e.g. a contact.

A difference inclusion: at every step A, B, C are those of one parameter in an interval. The
common set of all constant parameters is not enough: once the parameter jumps, the state may be
where another parameter breaks a limit. What is sought is a set Q that no parameter leaves:

    S_0     = all outputs within limits, for every parameter
    S_{i+1} = {z in S_i: any parameter, held for any time, stays in S_i}

until nothing changes (Pluymers et al. 2005, with whole spells instead of single steps, which
keeps the rows few at a high rate). Rows are looked at for some parameters (nodes) and times;
what lies between is bounded by second differences over the set. Q is pruned up to a tolerance
t: a spell leads at most to (1 + t) Q. The set returned is Q / (1 + t)^(spells), so it is safe
for that many spells in a row, against a disturbance that was taken larger by as much.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from mobius.control.governor.admissible import AdmissibleSet
from mobius.control.governor.exact_set import EmptySet, check, final_room, require_room
from mobius.control.governor.redundancy import Bound, Pruner, symmetric_half
from mobius.control.governor.system import Constraints, Disturbance, LinearSystem
from mobius.errors import InvalidInput, MobiusError

__all__ = ["family_set"]

Array = NDArray[np.float64]

FINE, COARSER = 8, 12
"""Times that are looked at: every 8th step, later every 12th part of the time gone by."""
AT_ONCE = 4_000_000
"""Numbers held in memory at a time."""
SETTLED = 0.01
"""A spell is followed until its slowest mode has shrunk to this share."""


class _Spells:
    """Where rows come from after 0, 1, ... steps with one parameter held."""

    def __init__(self, system: LinearSystem, steps: int) -> None:
        n, m = system.B.shape
        self.A, self.B = np.empty((steps + 1, n, n)), np.empty((steps + 1, n, m))
        self.A[0], self.B[0] = np.eye(n), 0.0
        for t in range(steps):
            self.B[t + 1] = self.B[t] + self.A[t] @ system.B
            self.A[t + 1] = self.A[t] @ system.A
        self.E = self.A[:-1] @ system.E

    def __call__(self, rows: Array, disturbance: Disturbance | None) -> Array:
        """(steps + 1, r, n + m) what rows (r, n + m) demand before each spell."""
        n = self.A.shape[1]
        on_x, on_v = rows[:, :n], rows[:, n:]
        p = np.concatenate([on_x @ self.A, on_v + on_x @ self.B], axis=2)
        if disturbance is None:
            return p
        eaten = np.zeros((len(self.A), len(rows)))
        eaten[1:] = disturbance.support(on_x @ self.E).cumsum(axis=0)
        if (eaten >= 1.0).any():
            raise _Gone
        return p / (1.0 - eaten)[..., None]


class _Gone(Exception):
    """The disturbance eats all room."""


def family_set(
    family: Callable[[float], LinearSystem],
    interval: tuple[float, float],
    constraints: Constraints,
    *,
    nodes: int = 3,
    disturbance: Disturbance | None = None,
    epsilon: float = 0.02,
    tolerance: float = 0.01,
    spells: int = 3,
    max_rows: int = 3000,
) -> AdmissibleSet:
    """States and references that are safe for every parameter, also one that jumps.

    Args:
        family: The loop for a value of the parameter; smooth in it.
        interval: Of the parameter, low < high.
        constraints: Of the outputs.
        nodes: Parameters that are looked at, ends included, >= 2.
        disturbance: What w may be at every step; nothing if left out.
        epsilon: Share of each limit that steady states keep free, 0 < epsilon < 1.
        tolerance: For pruning, > 0.
        spells: Spells of constant parameter that follow one another before the governor finds
            the state inside again, >= 1.
        max_rows: Give up where more are needed.

    Raises:
        InvalidInput: A number is out of range, sizes do not fit, or the set is unbounded.
        EmptySet: No state is admissible.
        MobiusError: More than ``max_rows`` rows.
    """
    low, high = (float(v) for v in interval)
    if not (np.isfinite([low, high]).all() and low < high):
        raise InvalidInput(f"interval: expected low < high, got {interval}")
    if nodes < 2 or spells < 1 or tolerance <= 0:
        raise InvalidInput(
            "expected nodes >= 2, spells >= 1 and tolerance > 0, got"
            f" {nodes}, {spells} and {tolerance}"
        )
    systems = [family(k) for k in np.linspace(low, high, 2 * nodes - 1)]
    for s in systems:
        check(s, constraints, disturbance, epsilon, tolerance)
        if s.sizes != systems[0].sizes:
            raise InvalidInput(f"family: expected systems of one size, got {s.sizes}")
    moved_in = (1.0 + 2.0 * tolerance) ** spells
    if disturbance is not None:
        disturbance = Disturbance(moved_in * disturbance.vertices, disturbance.is_box)
    half = symmetric_half(constraints.H, constraints.h)
    paired = half is not None and (disturbance is None or disturbance.is_box)
    if paired:
        constraints = Constraints(constraints.H[half], constraints.h[half])
    base, steady = _base(systems, constraints, disturbance, epsilon)
    try:
        pruner, horizon = _closed(systems, base, steady, disturbance, tolerance, max_rows, paired)
    except _Gone:
        raise EmptySet(
            "no state is admissible for every parameter: the disturbance eats all room of a row;"
            " assume a smaller disturbance, widen the limits or narrow the interval"
        ) from None
    n = systems[0].sizes[0]
    inner = pruner.rows * moved_in
    return AdmissibleSet(
        G_x=inner[:, :n], G_v=inner[:, n:], horizon=horizon, last_step=horizon,
        loss=moved_in - 1.0, epsilon=epsilon,
    )  # fmt: skip


def _closed(
    systems: list[LinearSystem], base: Array, steady: Array, disturbance: Disturbance | None,
    tolerance: float, max_rows: int, paired: bool,
) -> tuple[Pruner, int]:  # fmt: skip
    """Rows that no spell breaks any more, and how long spells were followed."""
    slowest = max(s.spectral_radius for s in systems)
    grid = _grid(int(np.ceil(np.log(SETTLED) / np.log(slowest))))
    spells = [_Spells(s, int(grid[-1])) for s in systems]
    ends = np.vstack([steady, base, *(s(base, disturbance)[grid].reshape(-1, base.shape[1])
                                      for s in spells[::2])])  # fmt: skip
    scale = np.abs(ends).max(axis=0)
    scale[scale == 0.0] = 1.0
    pruner = Pruner(scale, tolerance, symmetric=paired)
    pruner.add(_useful(np.vstack([steady, base])))
    at_once = max(1, AT_ONCE // (len(spells) * int(grid[-1] + 1) * base.shape[1]))
    new, done = base, 0
    while len(new):
        for first in range(0, len(new), at_once):
            _look(new[first : first + at_once], spells, grid, pruner, disturbance, tolerance)
        new, done = pruner.shown[done:], len(pruner.shown)
        if done > max_rows:
            raise MobiusError(
                f"the admissible set needs more than {max_rows} rows; raise tolerance (now"
                f" {tolerance:g}) or max_rows, or narrow the interval"
            )
    last = Pruner(scale, 0.0, symmetric=paired)  # without rows that later ones made superfluous
    last.add(pruner.shown)
    return last, int(grid[-1])


def _look(
    rows: Array, spells: list[_Spells], grid: NDArray[np.intp], pruner: Pruner,
    disturbance: Disturbance | None, tolerance: float,
) -> None:  # fmt: skip
    """Add what these rows demand before spells and the pruned rows do not imply."""
    p = np.stack([s(rows, disturbance) for s in spells], axis=1)  # (times, parameters, r, w)
    width = p.shape[-1]
    demands = _useful(p[grid][:, ::2].reshape(-1, width))
    size = Bound(pruner.rows)
    pruner.add(demands[size(demands) > 1.0] if size.finite else demands)
    size = Bound(pruner.rows)
    if not size.finite:
        raise InvalidInput(
            "the admissible set is unbounded: some combination of state and reference is never"
            " seen by a limit; limit one more output, for instance the reference itself"
        )
    for k in range(len(grid) - 1):  # every single step between two times of the grid
        inner = np.arange(grid[k] + 1, grid[k + 1])
        share = ((inner - grid[k]) / (grid[k + 1] - grid[k]))[:, None, None, None]
        near = (1 - share) * p[grid[k], ::2] + share * p[grid[k + 1], ::2]
        between = p[inner][:, ::2]
        pruner.add(between[(size(between - near) > tolerance) & (size(between) > 1.0)])
    at = p[grid]
    between = at[:, 1::2]
    missed = size(between - 0.5 * (at[:, :-1:2] + at[:, 2::2]))
    pruner.add(between[(missed > tolerance) & (size(between) > 1.0)])


def _base(
    systems: list[LinearSystem], constraints: Constraints, disturbance: Disturbance | None,
    epsilon: float,
) -> tuple[Array, Array]:  # fmt: skip
    """Rows of the outputs now (r, n + m), and of the steady states, of all systems."""
    base, steady = [], []
    n = len(systems[0].A)
    for s in systems:
        room = constraints.h.copy()
        HC, HD = constraints.H @ s.C, constraints.H @ s.D
        if disturbance is not None:
            room = room - disturbance.support(constraints.H @ s.F)
        require_room(room, constraints, 0)
        base.append(np.hstack([HC, HD]) / room[:, None])
        final = final_room(room, HC, s, disturbance, constraints)
        rest = (HC @ s.steady_state + HD) / ((1.0 - epsilon) * final[:, None])
        steady.append(np.hstack([np.zeros((len(rest), n)), rest]))
    return np.vstack(base), np.vstack(steady)


def _grid(last: int) -> NDArray[np.intp]:
    """Times whose rows are looked at one by one."""
    times = [0]
    while times[-1] < last:
        times.append(times[-1] + max(FINE, times[-1] // COARSER))
    return np.array(times, dtype=np.intp)


def _useful(rows: Array) -> Array:
    return rows[np.abs(rows).max(axis=1) > 0]
