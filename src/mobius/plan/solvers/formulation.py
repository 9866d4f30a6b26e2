"""A mixed-integer programme as plain lists, for any library to read."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

__all__ = ["Formulation", "Kind", "Linear", "Quadratic", "Row", "Sense", "Variable"]

Kind = Literal["binary", "continuous"]
Sense = Literal["<=", "=="]
Row = dict[int, float]
"""Variable number -> coefficient."""


@dataclass(frozen=True)
class Variable:
    """One variable; its number is its place in the list."""

    name: str
    low: float
    high: float
    kind: Kind


@dataclass(frozen=True)
class Linear:
    """sum row[v] v  (<= or ==)  right."""

    row: Row
    sense: Sense
    right: float


@dataclass(frozen=True)
class Quadratic:
    """sum squares[v] v^2 + sum row[v] v  (<= or ==)  right."""

    squares: Row
    row: Row
    sense: Sense
    right: float


@dataclass
class Formulation:
    """Variables, constraints, and a linear objective to maximise."""

    variables: list[Variable] = field(default_factory=list)
    linear: list[Linear] = field(default_factory=list)
    quadratic: list[Quadratic] = field(default_factory=list)
    objective: Row = field(default_factory=dict)
    constant: float = 0.0
    """Added to the objective [points]."""

    def binary(self, name: str) -> int:
        """A new 0/1 variable; its number."""
        return self._new(Variable(name, 0.0, 1.0, "binary"))

    def continuous(self, name: str, low: float, high: float) -> int:
        """A new continuous variable within [low, high]; its number."""
        return self._new(Variable(name, low, high, "continuous"))

    def _new(self, variable: Variable) -> int:
        self.variables.append(variable)
        return len(self.variables) - 1

    def at_most(self, row: Row, right: float) -> None:
        """Add ``row <= right``."""
        self.linear.append(Linear(row, "<=", right))

    def equal(self, row: Row, right: float) -> None:
        """Add ``row == right``."""
        self.linear.append(Linear(row, "==", right))

    def earn(self, variable: int, points: float) -> None:
        """Add ``points`` times a variable to the objective."""
        self.objective[variable] = self.objective.get(variable, 0.0) + points
