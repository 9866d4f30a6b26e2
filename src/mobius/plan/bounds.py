r"""Upper bounds on the objective, by dynamic programming over the whole grid at once.

The hard part of the problem is that a cell pays only on the first visit. Let every visit
pay, and the best value with k steps to go depends on the cell alone:

    U_0(c) = stop(c),      U_k(c) = max_a [ W (1 + seen_a(c)) - cost_a(c) + U_{k-1}(c + d_a) ]

where cells seen before the plan count 0, and with k steps to go only steps are allowed that
what moves leaves open at that time. A cell is counted when it is left, and the last one by
``stop`` (if the problem counts it). U_T(start) bounds every plan, and a path that attains it
without visiting twice is optimal.

Cells are numbered row by row in a frame three cells wider on every side, so that a step is
one fixed offset in the flat index and nothing wraps round.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mobius.plan.problem import Problem
from mobius.types import Mode

__all__ = ["Arcs", "build_arcs", "capacity_bound", "dp_bound", "shortest_steps", "steps_from"]

Array = NDArray[np.float64]
PAD = 3
"""Longest step per axis."""
UNREACHED = np.iinfo(np.int64).max // 4


@dataclass(frozen=True, eq=False)
class Arcs:
    """Every legal step of a problem. N padded cells, A actions, flat indices."""

    stride: int
    lo: int
    """First flat index of a free cell; a step from it stays within the frame."""
    hi: int
    """One past the last flat index of a free cell."""
    offset: tuple[int, ...]
    """A flat landing offsets."""
    seen: tuple[tuple[int, ...], ...]
    """A tuples of flat offsets of cells counted between departure and landing."""
    valid: NDArray[np.bool_]
    """(A, N) whether the step is legal from the cell."""
    n_seen: Array
    """(A, N) cells that may earn between departure and landing (a blocked one never does)."""
    cost: Array
    """(A, N) P[mode] plus the cell costs entered [points]."""
    free: NDArray[np.bool_]
    """(N,)."""
    pays: NDArray[np.bool_]
    """(N,) free cells that were not seen before."""
    touch: tuple[tuple[int, ...], ...]
    """A tuples of flat offsets of cells that must be open while the step is made."""

    def flat(self, cell: tuple[int, int]) -> int:
        """Flat index of a cell."""
        return (cell[0] + PAD) * self.stride + cell[1] + PAD

    def cell(self, flat: int) -> tuple[int, int]:
        """Cell of a flat index."""
        return flat // self.stride - PAD, flat % self.stride - PAD


def build_arcs(problem: Problem) -> Arcs:
    """Legality, reward and cost of every action from every cell."""
    grid = problem.grid
    stride = grid.shape[1] + 2 * PAD

    def pad(a: NDArray, fill: float | bool) -> NDArray:
        return np.pad(a, PAD, constant_values=fill).ravel()

    free, pays = pad(~grid.blocked, False), pad(problem.pays, False)
    N = len(free)
    lo, hi = int(np.argmax(free)), N - int(np.argmax(free[::-1]))
    inside = slice(lo, hi)
    allowed = {m: free & pad((grid.allowed & m.bit) > 0, False) for m in problem.modes}
    costs = pad(problem.costs, 0.0)
    costly = bool(costs.any())
    actions = problem.actions
    offset, seen, touch = [], [], []
    valid = np.zeros((len(actions), N), dtype=bool)
    n_seen, cost = np.zeros((len(actions), N)), np.zeros((len(actions), N))
    for a, act in enumerate(actions):
        ok = allowed[act.mode]
        between = [i * stride + j for i, j in act.crossed]
        corners = [i * stride + j for i, j in act.touched]
        to = act.d[0] * stride + act.d[1]
        legal = ok[inside].copy()
        if problem.check == "swept":
            for o in (*between, *corners, to):
                legal &= ok[lo + o : hi + o]
        else:
            legal &= free[lo + to : hi + to]
        counted = between if problem.count == "sweep" and act.mode is not Mode.ROLL else []
        for o in counted:
            n_seen[a, inside] += pays[lo + o : hi + o]
        cost[a] = problem.weights.P[act.mode]
        for o in (*between, to) if costly and act.d != (0, 0) else ():
            cost[a, inside] += costs[lo + o : hi + o]
        valid[a, inside] = legal
        offset.append(to)
        seen.append(tuple(counted))
        touch.append((*between, *corners, to) if problem.check == "swept" else (to,))
    return Arcs(
        stride, lo, hi, tuple(offset), tuple(seen), valid, n_seen, cost, free, pays, tuple(touch)
    )


def closed_cells(problem: Problem, arcs: Arcs, k: int) -> NDArray[np.bool_] | None:
    """(N,) cells that the step with ``k`` steps to go may not enter, or ``None``."""
    occupied = problem.closed_between(problem.horizon - k)
    return None if occupied is None else np.pad(occupied, PAD).ravel()


def terminal_value(problem: Problem, arcs: Arcs) -> Array:
    """(N,) value of ending on a cell, without its own reward [points]."""
    nx, ny = problem.grid.shape
    i, j = np.indices((nx + 2 * PAD, ny + 2 * PAD)) - PAD
    d2 = (i - problem.goal[0]) ** 2 + (j - problem.goal[1]) ** 2
    value = -problem.weights.W_goal * d2.ravel().astype(float)
    if problem.must_reach:
        value[d2.ravel() > 0] = -np.inf
    value[~arcs.free] = -np.inf
    return value


def dp_bound(problem: Problem, arcs: Arcs, *, W_exp: float | None = None) -> Array:
    """(T + 1, N) table U: row k bounds what k more steps can earn from each cell [points].

    The cell's own reward is included (paid when it is left, or by ending on it). Cells from
    which no k steps make a plan hold -inf.

    Args:
        problem: The problem.
        arcs: Its :func:`build_arcs`.
        W_exp: Reward per cell, the problem's own if not given.
    """
    W = problem.weights.W_exp if W_exp is None else W_exp
    N, lo, hi = arcs.valid.shape[1], arcs.lo, arcs.hi
    inside = slice(lo, hi)
    stop = terminal_value(problem, arcs) + W * (arcs.pays if problem.count_terminal else 0.0)
    U = np.full((problem.horizon + 1, N), -np.inf)
    U[0] = stop
    used = [a for a in range(len(arcs.offset)) if arcs.valid[a].any()]
    gain = [
        np.where(arcs.valid[a], W * (arcs.pays + arcs.n_seen[a]) - arcs.cost[a], -np.inf)[inside]
        for a in used
    ]
    candidate = np.empty(hi - lo)
    for k in range(1, problem.horizon + 1):
        best = U[k, inside]
        if problem.early_stop:
            best[:] = stop[inside]
        occupied = closed_cells(problem, arcs, k)
        for a, g in zip(used, gain, strict=True):
            o = arcs.offset[a]
            np.add(g, U[k - 1, lo + o : hi + o], out=candidate)
            if occupied is not None:
                for s in arcs.touch[a]:
                    candidate[occupied[lo + s : hi + s]] = -np.inf
            np.maximum(best, candidate, out=best)
    return U


def _waves(arcs: Arcs, seed: int, *, backward: bool) -> NDArray[np.int64]:
    """(N,) fewest steps between ``seed`` and each cell, by breadth-first waves."""
    N, lo, hi = arcs.valid.shape[1], arcs.lo, arcs.hi
    steps = np.full(N, UNREACHED)
    steps[seed] = 0
    front = np.zeros(N, dtype=bool)
    front[seed] = True
    t = 0
    while front.any():
        t += 1
        new = np.zeros(N, dtype=bool)
        for a, o in enumerate(arcs.offset):
            here, there = slice(lo, hi), slice(lo + o, hi + o)
            if backward:
                new[here] |= arcs.valid[a, here] & front[there]
            else:
                new[there] |= arcs.valid[a, here] & front[here]
        front = new & (steps == UNREACHED)
        steps[front] = t
    return steps


def shortest_steps(problem: Problem, arcs: Arcs) -> NDArray[np.int64]:
    """(N,) fewest steps from each cell to the goal; :data:`UNREACHED` where there is no way."""
    return _waves(arcs, arcs.flat(problem.goal), backward=True)


def steps_from(problem: Problem, arcs: Arcs) -> NDArray[np.int64]:
    """(N,) fewest steps from the start to each cell; :data:`UNREACHED` where no way leads."""
    return _waves(arcs, arcs.flat(problem.start), backward=False)


def capacity_bound(problem: Problem, arcs: Arcs) -> float:
    """Bound from the number of cells there are: W |coverable| + the best plan's other terms.

    Coverable is a cell that some path of at most T steps counts (and that can still end at
    the goal, where it must). Tight where T is large against the map [points].
    """
    lo, hi, T = arcs.lo, arcs.hi, problem.horizon
    out = steps_from(problem, arcs)
    home = shortest_steps(problem, arcs) if problem.must_reach else np.zeros_like(out)
    coverable = out + home <= T
    here = slice(lo, hi)
    for a, o in enumerate(arcs.offset):
        if not arcs.seen[a]:
            continue
        in_time = arcs.valid[a, here] & (out[here] + 1 + home[lo + o : hi + o] <= T)
        for s in arcs.seen[a]:
            coverable[lo + s : hi + s] |= in_time
    coverable &= arcs.pays
    rest = dp_bound(replace(problem, count_terminal=False), arcs, W_exp=0.0)
    return float(
        problem.weights.W_exp * np.count_nonzero(coverable)
        + rest[problem.horizon, arcs.flat(problem.start)]
    )
