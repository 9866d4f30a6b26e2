r"""Upper bounds on the objective, by dynamic programming over the whole grid at once.

The hard part of the problem is that a cell pays only on the first visit. Let every visit
pay, and the best value with k steps to go depends on the cell alone:

    U_0(c) = stop(c),      U_k(c) = max_a [ W (1 + seen_a(c)) - cost_a(c) + U_{k-1}(c + d_a) ]

where cells seen before the plan count 0, and with k steps to go only steps are allowed that
what moves leaves open at that time. A cell is counted when it is left, and the last one by
``stop`` (if the problem counts it). U_T(start) bounds every plan, and a path that attains it
without visiting twice is optimal.

With a footprint a step pays what its places see and its landing does not see again: every
cell is then paid at least at the last place that sees it, so it stays a bound, and one that
does not pay a wide view anew at every step.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mobius.plan.arcs import PAD as PAD
from mobius.plan.arcs import Arcs as Arcs
from mobius.plan.arcs import build_arcs as build_arcs
from mobius.plan.arcs import closed_cells as closed_cells
from mobius.plan.arcs import terminal_value as terminal_value
from mobius.plan.problem import Problem

__all__ = [
    "Arcs",
    "build_arcs",
    "capacity_bound",
    "coverable_cells",
    "dp_bound",
    "mode_bounds",
    "shortest_steps",
    "steps_from",
]

Array = NDArray[np.float64]
SMALL = 2048
"""Padded cells up to which taking all steps at once is faster than one after the other."""
UNREACHED = np.iinfo(np.int64).max // 4


Way = tuple[int, int, tuple[int, ...]]
"""Number of the mode (0 where it does not matter), flat landing offset, touched offsets."""


class Gains:
    """What every step earns and costs if every visit pays; of like steps the best."""

    def __init__(self, problem: Problem, arcs: Arcs, W: float, *, by_mode: bool = False) -> None:
        own = arcs.pays if arcs.sight is None else arcs.sight.own
        self.stop = terminal_value(problem, arcs) + W * (own if problem.count_terminal else 0.0)
        """(N,) value of ending on a cell."""
        self._of_action = [
            problem.modes.index(act.mode) if by_mode else 0 for act in problem.actions
        ]
        self._full = self._best(arcs, W, [own + n for n in arcs.n_seen])
        self._landing = self._full
        self._last_looks = problem.count_terminal
        if arcs.sight is not None and (problem.count_terminal or not problem.early_stop):
            new = [own + n - m for n, m in zip(arcs.n_seen, arcs.sight.again, strict=True)]
            self._landing = self._best(arcs, W, new)

    def _best(self, arcs: Arcs, W: float, counts: list[Array]) -> dict[Way, Array]:
        best: dict[Way, Array] = {}
        for a, count in enumerate(counts):
            if arcs.valid[a].any():
                gain = np.where(arcs.valid[a], W * count - arcs.cost[a], -np.inf)
                gain = gain[arcs.lo : arcs.hi]
                way = (self._of_action[a], arcs.offset[a], arcs.touch[a])
                best[way] = np.maximum(best[way], gain) if way in best else gain
        return best

    def of(self, k: int) -> dict[Way, Array]:
        """Points of each way with k steps to go, for cells lo to hi."""
        return self._landing if k > 1 or self._last_looks else self._full


def dp_bound(
    problem: Problem,
    arcs: Arcs,
    *,
    W_exp: float | None = None,
    stop: Array | None = None,
    window: bool = False,
) -> Array:
    """(T + 1, N) table U: row k bounds what k more steps can earn from each cell [points].

    The cell's own reward is included (paid when it is left, or by ending on it). Cells from
    which no k steps make a plan hold -inf. Changes of mode are free here, see
    :func:`mode_bounds`.

    Args:
        problem: The problem.
        arcs: Its :func:`build_arcs`.
        W_exp: Reward per cell, the problem's own if not given.
        stop: (N,) value of ending on a cell [points], the problem's own if not given.
        window: Leave cells out (-inf) that are too far from the start for T - k steps.
    """
    gains = Gains(problem, arcs, problem.weights.W_exp if W_exp is None else W_exp)
    N, lo, hi = arcs.valid.shape[1], arcs.lo, arcs.hi
    stop = gains.stop if stop is None else stop
    if N <= SMALL and problem.closed is None:
        return _gathered(problem, arcs, gains, stop)
    U = np.full((problem.horizon + 1, N), -np.inf)
    U[0] = stop
    scratch = np.empty(hi - lo)
    here, farthest = arcs.flat(problem.start), PAD * (arcs.stride + 1)
    for k in range(1, problem.horizon + 1):
        reach = farthest * (problem.horizon - k) if window else len(stop)
        i, j = max(lo, here - reach), min(hi, here + reach + 1)
        best, before, candidate = U[k, i:j], U[k - 1], scratch[: j - i]
        if problem.early_stop:
            best[:] = stop[i:j]
        occupied = closed_cells(problem, arcs, k)
        for (_, o, touch), gain in gains.of(k).items():
            np.add(gain[i - lo : j - lo], before[i + o : j + o], out=candidate)
            if occupied is not None:
                for s in touch:
                    candidate[occupied[i + s : j + s]] = -np.inf
            np.maximum(best, candidate, out=best)
    return U


def _gathered(problem: Problem, arcs: Arcs, gains: Gains, stop: Array) -> Array:
    """:func:`dp_bound` of a small map on which nothing moves: all steps of a layer at once."""
    cells = np.flatnonzero(arcs.free)
    U = np.full((problem.horizon + 1, len(stop)), -np.inf)
    U[0] = stop
    ways: dict[Way, Array] | None = None
    gain: Array = np.empty(0)
    to: NDArray[np.int64] = np.empty(0, dtype=np.int64)
    for k in range(1, problem.horizon + 1):
        if gains.of(k) is not ways:
            ways = gains.of(k)
            rows = [row[cells - arcs.lo] for row in ways.values()]
            gain = np.array(rows).reshape(-1, len(cells))
            to = cells + np.array([o for _, o, _ in ways], dtype=np.int64)[:, None]
        best = gain + U[k - 1].take(to, mode="clip")
        U[k, cells] = best.max(axis=0, initial=-np.inf)
        if problem.early_stop:
            np.maximum(U[k], stop, out=U[k])
    return U


def mode_bounds(problem: Problem, arcs: Arcs) -> tuple[Array, float]:
    """The table of :func:`dp_bound` per mode of the step before, changes of mode paid.

    Returns:
        (M, T + 1, N) bounds in the order of ``problem.modes`` [points], and the bound on all
        plans from the start, whose mode before is ``problem.last_mode`` [points].
    """
    gains = Gains(problem, arcs, problem.weights.W_exp, by_mode=True)
    modes, T, lo, hi = problem.modes, problem.horizon, arcs.lo, arcs.hi
    inside, start = slice(lo, hi), arcs.flat(problem.start)
    U = np.full((len(modes), T + 1, arcs.valid.shape[1]), -np.inf)
    U[:, 0] = gains.stop
    root = float(gains.stop[start]) if T == 0 or problem.early_stop else -np.inf
    for k in range(1, T + 1):
        by = np.full((len(modes), hi - lo), -np.inf)
        occupied = closed_cells(problem, arcs, k)
        for (m, o, touch), g in gains.of(k).items():
            candidate = g + U[m, k - 1, lo + o : hi + o]
            if occupied is not None:
                for s in touch:
                    candidate[occupied[lo + s : hi + s]] = -np.inf
            np.maximum(by[m], candidate, out=by[m])
        for m, before in enumerate(modes):
            best = U[m, k, inside]
            if problem.early_stop:
                best[:] = gains.stop[inside]
            for row, mode in zip(by, modes, strict=True):
                np.maximum(best, row - problem.switch_points(before, mode), out=best)
        if k == T:
            first = [problem.switch_points(problem.last_mode, mode) for mode in modes]
            root = max(root, *(by[:, start - lo] - first).tolist())
    return U, root


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


def coverable_cells(problem: Problem, arcs: Arcs) -> NDArray[np.bool_]:
    """(N,) cells that may earn and that some path of at most T steps counts.

    Such a path can still end at the goal, where it must.
    """
    lo, hi, T = arcs.lo, arcs.hi, problem.horizon
    out = steps_from(problem, arcs)
    home = shortest_steps(problem, arcs) if problem.must_reach else np.zeros_like(out)
    places = out + home <= T
    here = slice(lo, hi)
    for a, o in enumerate(arcs.offset):
        if not arcs.seen[a]:
            continue
        in_time = arcs.valid[a, here] & (out[here] + 1 + home[lo + o : hi + o] <= T)
        for s in arcs.seen[a]:
            places[lo + s : hi + s] |= in_time
    if arcs.sight is None:
        return places & arcs.pays
    seen = np.zeros_like(places)
    for o, mask in arcs.sight.masks.items():
        seen |= np.roll(places & mask, o)
    return seen & arcs.pays


def capacity_bound(problem: Problem, arcs: Arcs) -> float:
    """Bound from the number of cells there are: W |coverable| + the best plan's other terms.

    Tight where T is large against the map, or the footprint is [points].
    """
    coverable = coverable_cells(problem, arcs)
    rest = dp_bound(replace(problem, count_terminal=False), arcs, W_exp=0.0)
    return float(
        problem.weights.W_exp * np.count_nonzero(coverable)
        + rest[problem.horizon, arcs.flat(problem.start)]
    )
