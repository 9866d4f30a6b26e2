"""A first plan for a large problem, stretch by stretch.

A search over the whole horizon has to carry every cell seen on the way, which is slow on a
large map. And where the bound table is not attained (it has no memory, so it is content to go
to and fro) a narrow beam ends in the first pocket. So look ``LENGTH`` steps ahead on a cut-out
of the map, with what was seen so far taken as seen and the table of the whole problem as the
value of where the stretch ends; keep the first steps; look again.
"""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mobius.plan.bounds import PAD, Arcs, build_arcs, dp_bound
from mobius.plan.check import cells_seen
from mobius.plan.problem import Problem
from mobius.plan.search import Budget, Found, Space, beam, path_of
from mobius.types import GridMap, Mode

__all__ = ["roll_out"]

Cell = tuple[int, int]

LENGTH = 30
"""Steps looked ahead."""
KEEP = 10
"""Steps of them that are kept; all of them once time is short."""
WIDTH = 8
"""Width of the beam."""
MARGIN = 20
"""Cells around the way the table would go that a stretch may use."""


def roll_out(
    problem: Problem, arcs: Arcs, U: NDArray[np.float64], *, deadline_s: float | None = None
) -> tuple[list[Cell], list[Mode]] | None:
    """A plan of all T steps of a problem that has one.

    Args:
        problem: The problem.
        arcs: Its arcs.
        U: Its :func:`mobius.plan.bounds.dp_bound`, with a plan from the start on.
        deadline_s: Wall time [s] after which the rest is done the quick way.

    Returns:
        Cells and modes; ``None`` where a stretch cannot be filled (``early_stop`` may do that).
    """
    end = None if deadline_s is None else time.perf_counter() + deadline_s
    cells, modes = [problem.start], list[Mode]()
    T = problem.horizon
    underway = replace(problem, count_terminal=False)
    while len(modes) < T:
        t = len(modes)
        steps = min(LENGTH, T - t)
        seen = np.zeros(problem.grid.shape, bool) if problem.seen is None else problem.seen.copy()
        for c in cells_seen(underway, cells, modes):
            seen[c] = True
        late = end is not None and time.perf_counter() > end
        ahead = _stretch(problem, arcs, U, cells[-1], seen, t, steps, 1 if late else WIDTH)
        if ahead is None:
            return None
        kept = steps if late or t + steps == T else KEEP
        cells += ahead[0][1 : kept + 1]
        modes += ahead[1][:kept]
    return cells, modes


def _stretch(
    problem: Problem,
    arcs: Arcs,
    U: NDArray[np.float64],
    at: Cell,
    seen: NDArray[np.bool_],
    t: int,
    steps: int,
    width: int,
) -> tuple[list[Cell], list[Mode]] | None:
    """The next steps from a cell at time t, the table being what comes after them."""
    nx, ny = problem.grid.shape
    way = np.array([arcs.cell(c) for c in _way(problem, arcs, U, at, t, steps)])
    low = np.maximum(way.min(axis=0) - MARGIN, 0)
    high = np.minimum(way.max(axis=0) + MARGIN + 1, (nx, ny))
    box = (slice(low[0], high[0]), slice(low[1], high[1]))
    grid, closed = problem.grid, problem.closed
    part = replace(
        problem,
        grid=GridMap(grid.name, grid.cell, np.zeros(3), grid.blocked[box], grid.allowed[box]),
        start=(at[0] - low[0], at[1] - low[1]),
        goal=(at[0] - low[0], at[1] - low[1]),
        horizon=steps,
        must_reach=False,
        early_stop=False,
        count_terminal=False,
        cell_cost=problem.costs[box],
        seen=seen[box],
        closed=None if closed is None else closed[min(t, len(closed) - 1) :, *box],
    )
    after = U[problem.horizon - t - steps].reshape(nx + 2 * PAD, ny + 2 * PAD)[PAD:-PAD, PAD:-PAD]
    end = np.pad(after[box] - problem.weights.W_exp * seen[box], PAD, constant_values=-np.inf)
    local = build_arcs(part)
    space = Space(part, local, dp_bound(part, local, stop=end.ravel()), end=end.ravel())
    found, _ = beam(space, width, Found(-np.inf, None), Budget(2**62, None))
    if found.link is None:
        return None
    flat, actions = path_of(found.link)
    cells = [local.cell(f) for f in flat]
    return (
        [(int(i + low[0]), int(j + low[1])) for i, j in cells],
        [part.actions[a].mode for a in actions],
    )


def _way(
    problem: Problem, arcs: Arcs, U: NDArray[np.float64], at: Cell, t: int, steps: int
) -> list[int]:
    """Flat cells of the way the table takes, which may see cells twice."""
    W, cell = problem.weights.W_exp, arcs.flat(at)
    way = [cell]
    offset = np.array(arcs.offset)
    for k in range(problem.horizon - t - 1, problem.horizon - t - steps - 1, -1):
        gain = W * arcs.n_seen[:, cell] - arcs.cost[:, cell] + U[k, cell + offset]
        cell += arcs.offset[int(np.argmax(np.where(arcs.valid[:, cell], gain, -np.inf)))]
        way.append(cell)
    return way
