"""Table IV on SCIP (package pyscipopt): a free solver that takes the table's quadratics.

A baseline and a witness, not a planner: it is slow from some 10 x 10 cells on. Both readings
and every repair are told in :mod:`mobius.plan.solvers.table_iv`.
"""

from __future__ import annotations

import time
from typing import Any

from mobius.errors import MissingDependency, PlanError
from mobius.plan.problem import Problem
from mobius.plan.solvers.common import finished, no_plan, refuse_unknown
from mobius.plan.solvers.formulation import Formulation
from mobius.plan.solvers.table_iv import EPSILON, Reading, table_iv
from mobius.types import Plan

__all__ = ["scip"]

TOLERANCE = 1e-4
"""How far SCIP's objective may be off that of its path, relative."""

KINDS = {"binary": "B", "continuous": "C"}


def scip(
    problem: Problem,
    deadline_s: float | None = None,
    *,
    reading: Reading = "repaired",
    M: float | None = None,
    epsilon: float = EPSILON,
) -> Plan:
    """Solve Table IV with SCIP on one thread.

    Args:
        problem: Any problem for ``repaired``; for ``literal`` see
            :func:`mobius.plan.solvers.table_iv.table_iv`.
        deadline_s: Wall time [s] for SCIP itself, ``None`` for none.
        reading: ``repaired`` or ``literal``.
        M: The table's M [cells^2], ``literal`` only.
        epsilon: The table's epsilon, ``literal`` only.

    Raises:
        MissingDependency: pyscipopt is not installed.
        NoPlan: There is none, or none is left by an ``M`` that is too small.
        PlanError: The reading cannot state the problem, or no plan was found in time.
    """
    refuse_unknown(problem, "scip")
    try:
        import pyscipopt
    except ImportError as error:
        raise MissingDependency("pyscipopt", "baseline", "solver 'scip'") from error
    began = time.perf_counter()
    table = table_iv(problem, reading, M=M, epsilon=epsilon)
    model, variables = _stated(pyscipopt, table.model)
    if deadline_s is not None:
        model.setParam("limits/time", deadline_s)
    model.optimize()
    status = model.getStatus()
    if status in ("infeasible", "inforunbd"):
        raise no_plan("scip")
    if status == "userinterrupt":
        raise KeyboardInterrupt
    if model.getNSols() == 0:
        raise PlanError(
            f"solver 'scip' found no plan (status '{status}'); give it more time or use the"
            " solver 'exact'"
        )
    best = model.getBestSol()
    cells, modes = table.path([model.getSolVal(best, v) for v in variables])
    return finished(
        problem,
        cells,
        modes,
        claimed=model.getObjVal(),
        tol=TOLERANCE,
        bound=model.getDualbound(),
        proven=status == "optimal",
        began=began,
    )


def _stated(library: Any, formulation: Formulation) -> tuple[Any, list[Any]]:
    """The formulation as a SCIP model, and its variables in order."""
    model = library.Model("Table IV")
    model.hideOutput()
    v = [model.addVar(x.name, KINDS[x.kind], lb=x.low, ub=x.high) for x in formulation.variables]

    def total(row: dict[int, float]) -> Any:
        return library.quicksum(c * v[k] for k, c in row.items())

    for a in formulation.linear:
        left = total(a.row)
        model.addCons(left == a.right if a.sense == "==" else left <= a.right)
    for q in formulation.quadratic:
        left = total(q.row) + library.quicksum(c * v[k] * v[k] for k, c in q.squares.items())
        model.addCons(left == q.right if q.sense == "==" else left <= q.right)
    model.setObjective(total(formulation.objective) + formulation.constant, "maximize")
    return model, v
