"""Table IV on Gurobi, the solver that the paper names, for those who have a licence.

``pip install gurobipy`` brings a licence for at most 2000 variables and 2000 linear
constraints (200 variables with quadratics), which is too small for 20 x 20 cells: z alone has
8000 variables there at T = 20. With a licence of one's own the same call states all of it.
"""

from __future__ import annotations

import time
from typing import Any

from mobius.errors import MobiusError, PlanError
from mobius.plan.problem import Problem
from mobius.plan.solvers.common import finished, no_plan, refuse_unknown
from mobius.plan.solvers.formulation import Formulation
from mobius.plan.solvers.table_iv import EPSILON, Reading, table_iv
from mobius.types import Plan

__all__ = ["gurobi"]

TOLERANCE = 1e-4
"""How far Gurobi's objective may be off that of its path, relative."""

LICENCE = (
    "the licence that comes with pip stops at 2000 variables, too few for 20 x 20 cells; install"
    " one of your own"
)


def gurobi(
    problem: Problem,
    deadline_s: float | None = None,
    *,
    reading: Reading = "repaired",
    M: float | None = None,
    epsilon: float = EPSILON,
) -> Plan:
    """Solve Table IV with Gurobi on one thread.

    Args:
        problem: As for :func:`mobius.plan.solvers.scip.scip`.
        deadline_s: Wall time [s] for Gurobi itself, ``None`` for none.
        reading: ``repaired`` or ``literal``.
        M: The table's M [cells^2], ``literal`` only.
        epsilon: The table's epsilon, ``literal`` only.

    Raises:
        MobiusError: gurobipy is not installed, or its licence does not do.
        NoPlan: There is none.
        PlanError: The reading cannot state the problem, or no plan was found in time.
    """
    refuse_unknown(problem, "gurobi")
    try:
        import gurobipy
    except ImportError as error:
        raise MobiusError(
            "solver 'gurobi' needs the package 'gurobipy', which no extra of mobius brings. Type:"
            f" pip install gurobipy; {LICENCE}, or use --solver scip"
        ) from error
    began = time.perf_counter()
    table = table_iv(problem, reading, M=M, epsilon=epsilon)
    try:
        model, variables = _stated(gurobipy, table.model)
        if deadline_s is not None:
            model.Params.TimeLimit = deadline_s
        model.optimize()
    except gurobipy.GurobiError as error:
        raise MobiusError(f"solver 'gurobi': {error}; {LICENCE}, or use --solver scip") from error
    if model.Status in (gurobipy.GRB.INFEASIBLE, gurobipy.GRB.INF_OR_UNBD):
        raise no_plan("gurobi")
    if model.SolCount == 0:
        raise PlanError(
            f"solver 'gurobi' found no plan (status {model.Status}); give it more time or use the"
            " solver 'exact'"
        )
    cells, modes = table.path([v.X for v in variables])
    return finished(
        problem,
        cells,
        modes,
        claimed=model.ObjVal,
        tol=TOLERANCE,
        bound=model.ObjBound,
        proven=model.Status == gurobipy.GRB.OPTIMAL,
        began=began,
    )


def _stated(library: Any, formulation: Formulation) -> tuple[Any, list[Any]]:
    """The formulation as a Gurobi model, and its variables in order."""
    GRB = library.GRB
    model = library.Model("Table IV", env=library.Env(params={"OutputFlag": 0}))
    model.Params.Threads = 1
    model.Params.NonConvex = 2
    model.Params.MIPGap = 0.0
    kinds = {"binary": GRB.BINARY, "continuous": GRB.CONTINUOUS}
    v = [
        model.addVar(lb=x.low, ub=x.high, vtype=kinds[x.kind], name=x.name)
        for x in formulation.variables
    ]

    def total(row: dict[int, float]) -> Any:
        return library.LinExpr(list(row.values()), [v[k] for k in row])

    for a in formulation.linear:
        left = total(a.row)
        model.addConstr(left == a.right if a.sense == "==" else left <= a.right)
    for q in formulation.quadratic:
        left = library.QuadExpr(total(q.row))
        for k, c in q.squares.items():
            left.add(v[k] * v[k], c)
        model.addQConstr(left == q.right if q.sense == "==" else left <= q.right)
    model.setObjective(total(formulation.objective) + formulation.constant, GRB.MAXIMIZE)
    return model, v
