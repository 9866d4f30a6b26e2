"""Which solvers there are: those shipped, and entry points of installed packages."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from importlib import metadata
from typing import Any, cast

from mobius.errors import MobiusError, PlanError, UnknownName
from mobius.plan.problem import Problem
from mobius.types import Plan

__all__ = ["BUILT_IN", "GROUP", "Solver", "solver_names", "solver_of"]

Solver = Callable[[Problem, float | None], Plan]
"""A problem and a deadline [s] (``None`` for none) to a plan."""

GROUP = "mobius.solvers"
"""Entry-point group that is looked at."""

BUILT_IN = {
    "exact": "mobius.plan.solvers.exact:exact",
    "didp": "mobius.plan.solvers.didp:didp",
    "scip": "mobius.plan.solvers.scip:scip",
    "gurobi": "mobius.plan.solvers.gurobi:gurobi",
    "brute": "mobius.plan.solvers.brute:brute",
}
"""Solvers of this package, the same as its entry points in pyproject.toml; they are known
here too, so that a checkout works before it is installed."""


def solver_names() -> list[str]:
    """Every name that :func:`solver_of` knows, sorted; their libraries may be missing."""
    return sorted(_places())


def solver_of(name: str) -> Solver:
    """The solver of that name.

    Args:
        name: ``exact``, ``didp``, ``scip``, ``gurobi``, ``brute`` or the name of an entry
            point of the group ``mobius.solvers``.

    Raises:
        UnknownName: There is none; suggests the closest name.
        PlanError: Two packages claim the name, or what the entry point names is not there.
    """
    places = _places()
    if name not in places:
        raise UnknownName("solver", name, places)
    if len(places[name]) > 1:
        raise PlanError(
            f"solver '{name}' is claimed by {' and '.join(sorted(places[name]))}; uninstall one"
            " of the packages or rename its entry point"
        )
    (place,) = places[name]
    return cast(Solver, _load(name, place))


def _places() -> dict[str, set[str]]:
    """Name -> every ``module:function`` that claims it."""
    places = {name: {place} for name, place in BUILT_IN.items()}
    for point in metadata.entry_points(group=GROUP):
        places.setdefault(point.name, set()).add(point.value.replace(" ", ""))
    return places


def _load(name: str, place: str) -> Any:
    """What an entry point names."""
    module, _, attribute = place.partition(":")
    try:
        found: Any = importlib.import_module(module)
        for part in attribute.split("."):
            found = getattr(found, part)
    except MobiusError:
        raise
    except (ImportError, AttributeError, ValueError) as error:
        raise PlanError(
            f"solver '{name}': the entry point '{place}' cannot be loaded: {error}; reinstall the"
            " package that brings it"
        ) from error
    if not callable(found):
        raise PlanError(
            f"solver '{name}': the entry point '{place}' names a {type(found).__name__}; expected"
            " a function (problem, deadline_s) -> Plan"
        )
    return found
