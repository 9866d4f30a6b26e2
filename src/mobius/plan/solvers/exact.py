"""Our own exact search under the name ``exact``."""

from __future__ import annotations

from mobius.plan.problem import Problem
from mobius.plan.solve import solve
from mobius.types import Plan

__all__ = ["exact"]


def exact(problem: Problem, deadline_s: float | None = None) -> Plan:
    """Solve with :func:`mobius.plan.solve`.

    Args:
        problem: Any problem.
        deadline_s: Wall time [s] for the search, ``None`` for none.
    """
    return solve(problem, deadline_s=deadline_s)
