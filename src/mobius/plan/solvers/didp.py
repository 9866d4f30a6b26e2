"""An independent exact engine: domain-independent dynamic programming (package didppy).

State: time, cell, set of cells counted so far, and the mode of the last step where changes of
mode cost. A step from a cell counts the cells that the
checker counts for it, and the last cell by the value of ending. Complete anytime beam search
on one thread; fewer cells counted is never worse for what follows, so a state with a subset
of another's cells and no lower score makes the other superfluous.

The bound is the memoryless one: every visit pays, changes of mode are free. It is worked out
here from this module's own tables, so that an error in :mod:`mobius.plan.bounds` does not show
up on both sides.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mobius.errors import MissingDependency, PlanError
from mobius.plan.problem import Problem
from mobius.plan.solvers.common import (
    Cell,
    Kind,
    finished,
    looks_of,
    no_plan,
    refuse_unknown,
    steps_of,
)
from mobius.types import Mode, Plan

__all__ = ["didp"]

STOP = "stop"
"""Name of the transition that ends a plan early."""


@dataclass(frozen=True, eq=False)
class _Tables:
    """The problem per kind of step and flat cell i * ny + j; K kinds, N cells."""

    kinds: list[Kind]
    legal: NDArray[np.bool_]
    """(K, N)."""
    to: NDArray[np.int64]
    """(K, N) landing, 0 where not legal."""
    seen: list[list[list[int]]]
    """K x N lists of flat cells that the step counts."""
    cost: NDArray[np.float64]
    """(K, N) [points]."""
    look: list[list[int]]
    """N lists of flat cells that a place counts by itself."""
    end: NDArray[np.float64]
    """(N,) value of ending on a cell, its own reward left out; -inf where it may not be."""


def didp(problem: Problem, deadline_s: float | None = None) -> Plan:
    """Solve with didppy's complete anytime beam search.

    Args:
        problem: Any problem.
        deadline_s: Wall time [s] for the search, ``None`` for none.

    Raises:
        MissingDependency: didppy is not installed.
        NoPlan: There is none.
        PlanError: No plan was found within the deadline.
    """
    refuse_unknown(problem, "didp")
    try:
        import didppy
    except ImportError as error:
        raise MissingDependency("didppy", "exact", "solver 'didp'") from error
    began = time.perf_counter()
    tables = _tables(problem)
    U = _bound_table(problem, tables)
    root = float(U[problem.horizon, _flat(problem, problem.start)])
    model = _model(didppy, problem, tables, U)
    left = None if deadline_s is None else max(0.0, deadline_s - (time.perf_counter() - began))
    found = didppy.CABS(model, time_limit=left, quiet=True, threads=1).search()
    if found.is_infeasible:
        raise no_plan("didp")
    if found.cost is None:
        raise PlanError(f"solver 'didp' found no plan within {deadline_s:g} s; give it more time")
    cells, modes = _path(problem, tables, [t.name for t in found.transitions])
    bound = root if found.best_bound is None else min(root, float(found.best_bound))
    return finished(
        problem,
        cells,
        modes,
        claimed=float(found.cost),
        bound=bound,
        proven=bool(found.is_optimal),
        began=began,
    )


def _flat(problem: Problem, cell: Cell) -> int:
    return cell[0] * problem.grid.shape[1] + cell[1]


def _tables(problem: Problem) -> _Tables:
    """The steps of every cell, sorted by kind; kinds that nothing allows are left out."""
    steps = steps_of(problem)
    kinds = list(dict.fromkeys(s.kind for a in steps for s in steps[a]))
    number = {kind: k for k, kind in enumerate(kinds)}
    nx, ny = problem.grid.shape
    shape = (len(kinds), nx * ny)
    legal, to, cost = np.zeros(shape, bool), np.zeros(shape, np.int64), np.zeros(shape)
    seen: list[list[list[int]]] = [[[] for _ in range(nx * ny)] for _ in kinds]
    for a, ways in steps.items():
        for step in ways:
            at = number[step.kind], _flat(problem, a)
            legal[at], to[at], cost[at] = True, _flat(problem, step.to), step.cost
            seen[at[0]][at[1]] = sorted(_flat(problem, c) for c in step.seen)
    i, j = np.indices((nx, ny))
    d2 = (i - problem.goal[0]) ** 2 + (j - problem.goal[1]) ** 2
    end = -problem.weights.W_goal * d2.astype(float)
    end[problem.grid.blocked | (problem.must_reach & (d2 > 0))] = -np.inf
    look: list[list[int]] = [[] for _ in range(nx * ny)]
    for c, cells in looks_of(problem).items():
        look[_flat(problem, c)] = sorted(_flat(problem, d) for d in cells)
    return _Tables(kinds, legal, to, seen, cost, look, end.ravel())


def _bound_table(problem: Problem, tables: _Tables) -> NDArray[np.float64]:
    """(T+1, N) most that k further steps can earn if every visit pays; -inf: dead end."""
    W = problem.weights.W_exp
    own = np.array([len(cells) for cells in tables.look], dtype=float)
    stop = tables.end + (W * own if problem.count_terminal else 0.0)
    number = np.array([[len(cells) for cells in row] for row in tables.seen], dtype=float)
    gain = np.where(tables.legal, W * number.reshape(tables.cost.shape) - tables.cost, -np.inf)
    U = np.full((problem.horizon + 1, len(stop)), -np.inf)
    U[0] = stop
    for k in range(1, len(U)):
        if problem.early_stop:
            U[k] = stop
        if len(gain):
            U[k] = np.maximum(U[k], (gain + U[k - 1][tables.to]).max(axis=0))
    return U


def _model(dp: Any, problem: Problem, tables: _Tables, U: NDArray[np.float64]) -> Any:
    """The problem in didppy's words; whole numbers stay integers."""
    T, W = problem.horizon, problem.weights.W_exp
    switches = _switches(problem, tables)
    numbers = np.concatenate([[W, problem.weights.W_goal], tables.cost.ravel(), switches.ravel()])
    whole = bool(np.all(numbers == np.round(numbers)))
    number = int if whole else float
    model = dp.Model(maximize=True, float_cost=not whole)
    cell_type = model.add_object_type(number=len(tables.end))
    time_type = model.add_object_type(number=T + 1)
    here = model.add_element_var(object_type=cell_type, target=_flat(problem, problem.start))
    t = model.add_element_var(object_type=time_type, target=0)
    seen = model.add_set_resource_var(object_type=cell_type, target=[], less_is_better=True)
    mode_type = model.add_object_type(number=len(switches))
    changing = problem.switch_cost is not None
    last = model.add_element_var(object_type=mode_type, target=len(switches) - 1)

    def table(values: NDArray[np.float64]) -> Any:
        rows = np.where(np.isfinite(values), values, 0.0).tolist()
        if values.ndim == 1:
            rows = [number(v) for v in rows]
        else:
            rows = [[number(v) for v in row] for row in rows]
        return model.add_int_table(rows) if whole else model.add_float_table(rows)

    later = dp.IntExpr.state_cost() if whole else dp.FloatExpr.state_cost()
    for k, kind in enumerate(tables.kinds):
        counted = model.add_set_table(tables.seen[k], object_type=cell_type)[here]
        cost = table(tables.cost[k])[here]
        effects = [
            (seen, seen | counted),
            (here, model.add_element_table(tables.to[k].tolist())[here]),
            (t, t + 1),
        ]
        if changing:
            cost += table(switches[:, k])[last]
            effects.append((last, problem.modes.index(kind[0])))
        step = dp.Transition(
            name=str(k),
            cost=(counted - seen).len() * number(W) - cost + later,
            effects=effects,
            preconditions=[t < T, model.add_bool_table(tables.legal[k].tolist())[here]],
        )
        model.add_transition(step)
    may_end = model.add_bool_table(np.isfinite(tables.end).tolist())[here]
    if problem.early_stop:
        stop = dp.Transition(
            name=STOP, cost=later, effects=[(t, T)], preconditions=[t < T, may_end]
        )
        model.add_transition(stop)
    look = model.add_set_table(tables.look, object_type=cell_type)[here]
    looked = (look - seen).len() * number(W) if problem.count_terminal else 0
    model.add_base_case([t == T, may_end], cost=table(tables.end)[here] + looked)
    model.add_state_constr(model.add_bool_table(np.isfinite(U[::-1]).tolist())[t, here])
    model.add_dual_bound(table(U[::-1])[t, here])
    return model


def _switches(problem: Problem, tables: _Tables) -> NDArray[np.float64]:
    """(M + 1, K) points of each kind after each mode; last row: after the mode before."""
    befores = (*problem.modes, problem.last_mode)
    if problem.switch_cost is None:
        return np.zeros((len(befores), len(tables.kinds)))
    table = [[_change(problem, b, kind[0]) for kind in tables.kinds] for b in befores]
    return np.array(table, dtype=float).reshape(len(befores), len(tables.kinds))


def _change(problem: Problem, before: Mode | None, mode: Mode) -> float:
    if before is None or before is mode or problem.switch_cost is None:
        return 0.0
    return problem.switch_cost.get((before, mode), 0.0)


def _path(problem: Problem, tables: _Tables, names: list[str]) -> tuple[list[Cell], list[Mode]]:
    """Cells and modes of a list of transitions."""
    cells, modes = [problem.start], []
    for name in names:
        if name == STOP:
            break
        mode, dx, dy = tables.kinds[int(name)]
        cells.append((cells[-1][0] + dx, cells[-1][1] + dy))
        modes.append(mode)
    return cells, modes
