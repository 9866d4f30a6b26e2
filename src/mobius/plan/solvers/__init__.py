"""Solvers by name: our own exact search, and independent ones to hold it against.

    from mobius.plan.solvers import solver_of

    plan = solver_of("didp")(problem, 5.0)

A solver is a function of the problem and a deadline [s] (``None`` for none). It returns a
:class:`mobius.types.Plan` of status "optimal" or "feasible" with an honest bound, and raises

- :class:`mobius.plan.NoPlan` where it has proven that there is none,
- :class:`mobius.errors.PlanError` where it cannot state the problem, or finds nothing in time,
- :class:`mobius.errors.MissingDependency` where its library is not installed.

To add one without touching this package, declare an entry point of the group
``mobius.solvers`` in a package of your own:

    [project.entry-points."mobius.solvers"]
    mine = "my_package.my_module:my_solver"
"""

from mobius.plan.solvers.registry import BUILT_IN as BUILT_IN
from mobius.plan.solvers.registry import GROUP as GROUP
from mobius.plan.solvers.registry import Solver as Solver
from mobius.plan.solvers.registry import solver_names as solver_names
from mobius.plan.solvers.registry import solver_of as solver_of
