"""Table IV on whole cells, linear; see :mod:`mobius.plan.solvers.table_iv`."""

from __future__ import annotations

from collections.abc import Mapping

from mobius.plan.solvers.common import Cell, free_cells, looks_of, steps_of
from mobius.plan.solvers.motion import TableIV, negative
from mobius.types import Mode

__all__ = ["add_repaired"]


def add_repaired(table: TableIV) -> None:
    """Add cells, ground, obstacles and the objective to a table that has its motion."""
    p, f = table.problem, table.model
    cells = free_cells(p)
    z = [{c: f.binary(f"z_{t}_{c[0]}_{c[1]}") for c in cells} for t in range(p.horizon + 1)]
    seen = {c: f.binary(f"V_{c[0]}_{c[1]}") for c in cells}
    for t, row in enumerate(z):
        f.equal(dict.fromkeys(row.values(), 1.0), 1.0)
        for axis in (0, 1):
            place = {v: float(c[axis]) for c, v in row.items() if c[axis]}
            f.equal({table.x[t][axis]: 1.0, **negative(place)}, 0.0)
    for c, v in z[p.horizon].items():
        d2 = (c[0] - p.goal[0]) ** 2 + (c[1] - p.goal[1]) ** 2
        f.earn(v, -p.weights.W_goal * d2)
        if p.must_reach and d2:
            f.equal({v: 1.0}, 0.0)
    credit: dict[Cell, list[int]] = {c: [] for c in cells}
    looks = looks_of(p)
    for t, row in enumerate(z):
        for c, v in _counted(table, row, t).items():
            for cell in looks[c]:
                credit[cell].append(v)
    _steps(table, z, credit, looks)
    if p.switch_cost is not None:
        _changes(table, p.switch_cost)
    for c, V in seen.items():
        f.earn(V, p.weights.W_exp)
        f.at_most({V: 1.0, **dict.fromkeys(credit[c], -1.0)}, 0.0)


def _counted(table: TableIV, z: dict[Cell, int], t: int) -> dict[Cell, int]:
    """Variables that say whether the cell of time t counts where the robot is."""
    p, f = table.problem, table.model
    if p.count_terminal:
        return z
    if t == p.horizon:
        return {}
    if not p.early_stop:
        return z
    left = {c: f.continuous(f"left_{t}_{c[0]}_{c[1]}", 0.0, 1.0) for c in z}
    for c, v in left.items():
        f.at_most({v: 1.0, z[c]: -1.0}, 0.0)
    going = dict.fromkeys(table.m[t].values(), -1.0)
    f.at_most({**dict.fromkeys(left.values(), 1.0), **going}, 0.0)
    return left


def _changes(table: TableIV, cost: Mapping[tuple[Mode, Mode], float]) -> None:
    """What changes of mode cost: w >= m_a(t-1) + m_b(t) - 1 for each change from a to b."""
    p, f = table.problem, table.model
    for t, now in enumerate(table.m):
        for (a, b), points in cost.items():
            if b not in now or points == 0:
                continue
            if t == 0:
                if a is p.last_mode:
                    f.earn(now[b], -points)
            elif a in now:
                w = f.continuous(f"w_{t}_{a}_{b}", 0.0, 1.0)
                f.at_most({table.m[t - 1][a]: 1.0, now[b]: 1.0, w: -1.0}, 1.0)
                f.earn(w, -points)


def _steps(
    table: TableIV,
    z: list[dict[Cell, int]],
    credit: dict[Cell, list[int]],
    looks: dict[Cell, frozenset[Cell]],
) -> None:
    """Which step may be taken where, and what it sees and costs on the way."""
    p, f = table.problem, table.model
    steps = {c: {s.kind: s for s in ways} for c, ways in steps_of(p).items()}
    for a, kind in enumerate(table.kinds):
        legal = {c: ways[kind] for c, ways in steps.items() if kind in ways}
        forbidden = [c for c in steps if c not in legal]
        price = p.weights.P[kind[0]]
        rich = {c: s for c, s in legal.items() if s.seen - looks[c] or abs(s.cost - price) > 1e-12}
        for t in range(p.horizon):
            u = table.u[t][a]
            f.at_most({u: 1.0, **{z[t][c]: 1.0 for c in forbidden}}, 1.0)
            for c, s in rich.items():
                y = f.continuous(f"y_{t}_{a}_{c[0]}_{c[1]}", 0.0, 1.0)
                f.at_most({y: 1.0, z[t][c]: -1.0}, 0.0)
                f.at_most({y: 1.0, u: -1.0}, 0.0)
                f.at_most({z[t][c]: 1.0, u: 1.0, y: -1.0}, 1.0)
                f.earn(y, price - s.cost)
                for between in s.seen - looks[c]:
                    credit[between].append(y)
