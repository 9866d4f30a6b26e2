"""The common part of both readings of Table IV: how the robot moves, (7)-(11)."""

from __future__ import annotations

from dataclasses import dataclass, field

from mobius.plan.problem import Problem
from mobius.plan.solvers.common import Cell, Kind, kinds_of
from mobius.plan.solvers.formulation import Formulation, Row
from mobius.types import Mode

__all__ = ["TableIV", "build_motion", "negative"]


@dataclass
class TableIV:
    """A formulation and where its steps are."""

    problem: Problem
    kinds: list[Kind]
    model: Formulation = field(default_factory=Formulation)
    u: list[list[int]] = field(default_factory=list)
    """T lists of the variables u(t, a), in the order of ``kinds``."""
    m: list[dict[Mode, int]] = field(default_factory=list)
    """T tables of the variables m_l(t)."""
    x: list[tuple[int, int]] = field(default_factory=list)
    """T+1 pairs of the variables x(t, axis) [cells]."""

    def path(self, values: list[float]) -> tuple[list[Cell], list[Mode]]:
        """Cells and modes that the values of all variables stand for."""
        cells, modes = [self.problem.start], []
        for row in self.u:
            taken = [kind for kind, v in zip(self.kinds, row, strict=True) if values[v] > 0.5]
            if not taken:
                break
            mode, dx, dy = taken[0]
            cells.append((cells[-1][0] + dx, cells[-1][1] + dy))
            modes.append(mode)
        return cells, modes


def build_motion(problem: Problem) -> TableIV:
    """A table with (7)-(11) and what the modes cost, and nothing else yet."""
    table = TableIV(problem, kinds_of(problem))
    p, f = problem, table.model
    top = [n - 1.0 for n in p.grid.shape]
    for t in range(p.horizon + 1):
        place = [f.continuous(f"x_{t}_{axis}", 0.0, top[axis]) for axis in (0, 1)]
        table.x.append((place[0], place[1]))
    for axis in (0, 1):
        f.equal({table.x[0][axis]: 1.0}, float(p.start[axis]))
    for t in range(p.horizon):
        u = [f.binary(f"u_{t}_{mode}_{dx}_{dy}") for mode, dx, dy in table.kinds]
        m = {mode: f.binary(f"m_{t}_{mode}") for mode in p.modes}
        table.u.append(u)
        table.m.append(m)
        for mode in p.modes:
            chosen = {v: 1.0 for v, k in zip(u, table.kinds, strict=True) if k[0] is mode}
            f.equal({**chosen, m[mode]: -1.0}, 0.0)
            f.earn(m[mode], -p.weights.P[mode])
        go = dict.fromkeys(m.values(), 1.0)
        if not p.early_stop:
            f.equal(go, 1.0)
        else:
            f.at_most(go, 1.0)
            if t > 0:
                f.at_most({**go, **dict.fromkeys(table.m[t - 1].values(), -1.0)}, 0.0)
        for axis in (0, 1):
            d = {v: float(k[1 + axis]) for v, k in zip(u, table.kinds, strict=True) if k[1 + axis]}
            f.equal({table.x[t + 1][axis]: 1.0, table.x[t][axis]: -1.0, **negative(d)}, 0.0)
    return table


def negative(row: Row) -> Row:
    """The row times -1."""
    return {v: -c for v, c in row.items()}
