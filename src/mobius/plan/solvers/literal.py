"""Table IV as printed: big M, circles, rectangles; see :mod:`mobius.plan.solvers.table_iv`."""

from __future__ import annotations

import numpy as np

from mobius.errors import PlanError
from mobius.plan.problem import Problem
from mobius.plan.solvers.covers import discs_over, rectangles_over
from mobius.plan.solvers.formulation import Quadratic
from mobius.plan.solvers.motion import TableIV, negative

__all__ = ["add_literal", "refuse_for_literal"]


def add_literal(table: TableIV, M: float, epsilon: float) -> None:
    """Add (1)-(6), (12)-(20) and the objective to a table that has its motion.

    Args:
        table: From :func:`mobius.plan.solvers.motion.build_motion`.
        M: The table's M [cells^2].
        epsilon: The table's epsilon, in (0, 1].
    """
    _cells(table, M)
    _terrain(table, M, epsilon)
    _obstacles(table, M, epsilon)
    _goal(table)


def refuse_for_literal(problem: Problem) -> None:
    """Raise if the problem has an option that the print has no words for."""
    wrong = {
        "count='sweep'": problem.count != "endpoint",
        "check='swept'": problem.check != "endpoint",
        "early_stop=True": problem.early_stop,
        "cell_cost": bool(np.any(problem.costs)),
        "seen": problem.seen is not None and bool(np.any(problem.seen)),
        "switch_cost": problem.switch_cost is not None,
        "footprint": problem.footprint is not None,
        "Weights.per_s": problem.weights.per_s != 0,
        "Weights.per_J": problem.weights.per_J != 0,
    }
    said = [name for name, is_wrong in wrong.items() if is_wrong]
    if said:
        raise PlanError(
            f"Table IV as printed cannot state {', '.join(said)}; use reading='repaired' or make"
            " the problem with literal_problem()"
        )


def _counted_times(problem: Problem) -> range:
    """Times whose cell counts."""
    return range(problem.horizon + (1 if problem.count_terminal else 0))


def _cells(table: TableIV, M: float) -> None:
    """(1)-(6) with the missing sides."""
    p, f = table.problem, table.model
    times = _counted_times(p)
    for cell in np.ndindex(*p.grid.shape):
        V = f.binary(f"V_{cell[0]}_{cell[1]}")
        f.earn(V, p.weights.W_exp)
        z = [f.binary(f"z_{t}_{cell[0]}_{cell[1]}") for t in times]
        visits = dict.fromkeys(z, 1.0)
        f.at_most({V: 1.0, **negative(visits)}, 0.0)  # (2) (3)
        f.at_most({**visits, V: -float(max(len(z), 1))}, 0.0)  # (2) (4)
        for t, v in zip(times, z, strict=True):
            for axis in (0, 1):
                x = table.x[t][axis]
                f.at_most({x: -1.0, v: M}, M - cell[axis])  # (5) (6)
                f.at_most({x: 1.0, v: M}, M + cell[axis])


def _terrain(table: TableIV, M: float, epsilon: float) -> None:
    """(12)-(15): discs that leave only some modes open, at every departure."""
    p, f = table.problem, table.model
    far = float(sum(n**2 for n in p.grid.shape))
    every = sum(mode.bit for mode in p.modes)
    open_modes = p.grid.allowed & every
    for bits in sorted(set(open_modes[~p.grid.blocked].tolist()) - {every}):
        same = (open_modes == bits) & ~p.grid.blocked
        for k, (centre, r2) in enumerate(discs_over(same, spare=p.grid.blocked)):
            for t in range(p.horizon):
                name = f"{bits}_{k}_{t}"
                d, b = f.continuous(f"d_{name}", 0.0, far), f.binary(f"b_{name}")
                squares = dict.fromkeys(table.x[t], 1.0)
                row = {x: -2.0 * c for x, c in zip(table.x[t], centre, strict=True)}
                right = -float(centre[0] ** 2 + centre[1] ** 2)
                f.quadratic.append(Quadratic(squares, {**row, d: -1.0}, "==", right))  # (12)
                f.at_most({d: 1.0, b: M}, r2 + M)  # (13)
                f.at_most({d: -1.0, b: -M}, -r2 - epsilon)  # (14)
                fitting = {v: -1.0 for mode, v in table.m[t].items() if mode.bit & bits}
                f.at_most({b: 1.0, **fitting}, 0.0)  # (15)


def _obstacles(table: TableIV, M: float, epsilon: float) -> None:
    """(16)-(20), turned round: at every landing, beyond one side of every rectangle."""
    p, f = table.problem, table.model
    for k, (low, high) in enumerate(rectangles_over(p.grid.blocked)):
        for t in range(1, p.horizon + 1):
            b = [f.binary(f"rect_{k}_{t}_{side}") for side in range(4)]
            for axis in (0, 1):
                x = table.x[t][axis]
                f.at_most({x: 1.0, b[2 * axis]: -M}, low[axis] - epsilon)
                f.at_most({x: -1.0, b[2 * axis + 1]: -M}, -high[axis] - epsilon)
            f.at_most(dict.fromkeys(b, 1.0), 3.0)


def _goal(table: TableIV) -> None:
    """The squared distance, as a variable that it may not exceed."""
    p, f = table.problem, table.model
    last = table.x[p.horizon]
    far = float(sum(n**2 for n in p.grid.shape))
    q = f.continuous("q", 0.0, far)
    f.earn(q, -p.weights.W_goal)
    row = {x: -2.0 * c for x, c in zip(last, p.goal, strict=True)}
    right = -float(p.goal[0] ** 2 + p.goal[1] ** 2)
    f.quadratic.append(Quadratic(dict.fromkeys(last, 1.0), {**row, q: -1.0}, "<=", right))
    for axis in (0, 1) if p.must_reach else ():
        f.equal({last[axis]: 1.0}, float(p.goal[axis]))
