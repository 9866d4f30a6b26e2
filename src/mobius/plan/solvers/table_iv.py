r"""Table IV of the paper as a mixed-integer programme, in two readings.

Common to both: one binary u(t, a) per kind of step a says which is taken, so that (7) to (11)
hold exactly for every ``connectivity``: d(t) = sum of d_a u(t, a), m_l(t) = sum of u(t, a)
over the steps of mode l, and the modes of a time add up to one.

``literal`` keeps the table's variables, big M and circles, and changes only what has no
solution or no meaning as printed:

- (4) names V on both sides, which says nothing; read as z_sum <= T V.
- (5) (6) bound x from one side, so that z could be 1 for every cell below and left of the
  robot; the two other sides are added.
- (12)-(14) leave out k and t; here every circle has its own distance and b at every time.
- (15) uses k for the circle and for the mode; here a circle has the modes it leaves open.
- (16)-(19) ask for x beyond x_min + M where b = 0, and all four b = 1 contradicts (20). Read
  as: b = 0 puts the robot beyond that side, b = 1 frees it, and one of four must be 0.
- x(0), and the bounds of x, are added. W_goal counts as a penalty (Table VII lists negative
  numbers for it, under a minus sign).

Its circles and rectangles are worked out from the map: each set of cells with the same open
modes is covered with discs, the obstacles with rectangles; on whole cells that is exact.

``repaired`` is exact on whole cells, has neither big M nor quadratics nor epsilon, and states
every option of :class:`mobius.plan.Problem` but ``closed``:

- exactly one z(t, i, j) is 1 at each time, and x is read off it;
- ground and obstacles (12)-(20): a step that the checker refuses from a cell cannot be taken
  where z is 1 there, which also holds what lies *between* the ends of a step;
- the squared distance to the goal is a number per cell, so the objective is linear;
- what a step sees or costs between its ends hangs on one more variable per step and cell,
  y >= z + u - 1, y <= z, y <= u;
- with ``early_stop`` the modes of a time add up to at most one, and never resume;
- with a ``footprint`` V is held by the z of every cell that sees it; a change of mode is one
  more variable, w >= m_a(t-1) + m_b(t) - 1.
"""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np

from mobius.errors import InvalidInput, PlanError, UnknownName
from mobius.plan.problem import Problem
from mobius.plan.solvers.literal import add_literal, refuse_for_literal
from mobius.plan.solvers.motion import TableIV, build_motion
from mobius.plan.solvers.repaired import add_repaired

__all__ = ["EPSILON", "Reading", "table_iv"]

Reading = Literal["repaired", "literal"]

EPSILON = 0.5
"""The table's epsilon [cells, or cells^2]; any number in (0, 1] means the same on cells."""


def table_iv(
    problem: Problem,
    reading: Reading = "repaired",
    *,
    M: float | None = None,
    epsilon: float = EPSILON,
) -> TableIV:
    """State a problem as Table IV.

    Args:
        problem: Any problem for ``repaired``. ``literal`` has end points only
            (``count="endpoint"``, ``check="endpoint"``), no cell costs, no prices
            of time, energy or changes of mode, no footprint and no early stop.
        reading: ``repaired`` or ``literal``, see the module's docstring.
        M: The table's M, ``literal`` only; the default is nx^2 + ny^2 [cells^2], just enough.
            A smaller one cuts off plans, as any M that is too small does.
        epsilon: The table's epsilon in (0, 1], ``literal`` only.

    Raises:
        PlanError: The reading has no words for an option of the problem, or no M.
    """
    if reading not in get_args(Reading):
        raise UnknownName("reading of Table IV", str(reading), get_args(Reading))
    if not 0 < epsilon <= 1:
        raise InvalidInput(f"epsilon: expected a number in (0, 1], got {epsilon}")
    if M is not None and not (np.isfinite(M) and M > 0):
        raise InvalidInput(f"M: expected a number > 0, got {M}")
    if M is not None and reading != "literal":
        raise PlanError(f"reading '{reading}' has no M; leave it out or use reading='literal'")
    if reading == "literal":
        refuse_for_literal(problem)
    table = build_motion(problem)
    if reading == "literal":
        nx, ny = problem.grid.shape
        add_literal(table, float(nx**2 + ny**2) if M is None else M, epsilon)
    else:
        add_repaired(table)
    return table
