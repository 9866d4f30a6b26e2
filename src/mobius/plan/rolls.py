"""How a roll may end, and every step of a problem with all its endings."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobius.errors import InvalidInput, PlanError
from mobius.plan.actions import Action, line_between
from mobius.plan.arcs import price_of
from mobius.plan.problem import Problem
from mobius.types import Mode

__all__ = ["Endings", "Outcome", "RollRisk"]

Cell = tuple[int, int]
Array = NDArray[np.float64]

PAD = 4
"""Longest step per axis [cells]."""


@dataclass(frozen=True)
class RollRisk:
    """How a roll may end. The defaults are a guess, not a measurement."""

    p_two: float = 0.1
    """Probability of coming to rest after 2 cells."""
    p_three: float = 0.8
    """After 3 cells, > 0."""
    p_four: float = 0.1
    """After 4 cells; the three add up to 1."""
    p_bad: float = 0.05
    """Probability of a bad end, wherever it is."""
    penalty: float = 20.0
    """What a bad end costs [points], >= 0."""

    def __post_init__(self) -> None:
        for name in ("p_two", "p_three", "p_four", "p_bad"):
            p = getattr(self, name)
            if not 0 <= p <= 1:
                raise InvalidInput(f"RollRisk.{name}: expected a probability, got {p}")
        total = self.p_two + self.p_three + self.p_four
        if abs(total - 1) > 1e-9:
            raise InvalidInput(f"RollRisk: p_two + p_three + p_four must be 1, got {total:g}")
        if self.p_three == 0:
            raise InvalidInput("RollRisk.p_three: expected > 0, a roll is meant to land there")
        if not (math.isfinite(self.penalty) and self.penalty >= 0):
            raise InvalidInput(f"RollRisk.penalty: expected points >= 0, got {self.penalty}")

    @property
    def landings(self) -> tuple[tuple[int, float], ...]:
        """Cells and probability of every landing that may happen."""
        each = ((2, self.p_two), (3, self.p_three), (4, self.p_four))
        return tuple((n, p) for n, p in each if p > 0)


class Outcome(NamedTuple):
    """One way a step may end, from every cell. Arrays (nx, ny)."""

    p: float
    step: Action
    cost: Array
    """Points, bad ends by their expectation."""


class Endings:
    """Every action's outcomes and legality."""

    def __init__(self, problem: Problem, risk: RollRisk) -> None:
        for name in ("switch_cost", "footprint"):
            if getattr(problem, name) is not None:
                raise PlanError(f"planning under risk cannot state Problem.{name}; leave it out")
        self.problem = problem
        grid, self._shape = problem.grid, problem.grid.shape
        self._free = np.pad(~grid.blocked, PAD)
        self._ok = {m: self._free & np.pad(grid.allowed & m.bit > 0, PAD) for m in problem.modes}
        self._costs = np.pad(problem.costs, PAD)
        self._pays = np.pad(problem.pays, PAD)
        self.pays = problem.pays
        self.outcomes: list[list[Outcome]] = []
        self.legal: list[NDArray[np.bool_]] = []
        self.earns: list[Array] = []
        """Per action the cells that departure and places crossed may count."""
        for action in problem.actions:
            self._add(action, risk)

    def at(self, padded: NDArray, o: Cell) -> NDArray:
        """(nx, ny) view of a padded array, moved by an offset."""
        i, j = PAD + o[0], PAD + o[1]
        return padded[i : i + self._shape[0], j : j + self._shape[1]]

    def _add(self, action: Action, risk: RollRisk) -> None:
        p, mode = self.problem, action.mode
        legal = self.at(self._ok[mode], (0, 0)).copy()
        outcomes = []
        for step, chance in _endings_of(action, risk):
            cost = np.full(self._shape, price_of(p, step))
            if mode is Mode.ROLL:
                cost += risk.p_bad * risk.penalty
            for c in (*step.crossed, step.d) if step.d != (0, 0) else ():
                cost += self.at(self._costs, c)
            if p.check == "swept":
                for c in (*step.crossed, *step.touched, step.d):
                    legal &= self.at(self._ok[mode], c)
            else:
                legal &= self.at(self._free, step.d)
            outcomes.append(Outcome(chance, step, cost))
        earns = self.pays.astype(float)
        if p.count == "sweep" and mode is not Mode.ROLL:
            for c in action.crossed:
                earns = earns + self.at(self._pays, c)
        self.outcomes.append(outcomes)
        self.legal.append(legal)
        self.earns.append(earns)

    def open_at(self, a: int, k: int) -> NDArray[np.bool_]:
        """(nx, ny) where an action may be taken with k steps to go."""
        p, legal = self.problem, self.legal[a]
        closed = p.closed_between(p.horizon - k)
        if closed is None:
            return legal
        padded, legal = np.pad(closed, PAD), legal.copy()
        for outcome in self.outcomes[a]:
            step = outcome.step
            swept = (*step.crossed, *step.touched) if p.check == "swept" else ()
            for c in (*swept, step.d):
                legal &= ~self.at(padded, c)
        return legal


def _endings_of(action: Action, risk: RollRisk) -> list[tuple[Action, float]]:
    """The steps that an action may turn out to be, with their probabilities."""
    if action.mode is not Mode.ROLL:
        return [(action, 1.0)]
    sx, sy = (int(np.sign(v)) for v in action.d)
    ends = []
    for n, p in risk.landings:
        d = (n * sx, n * sy)
        ends.append((Action(Mode.ROLL, d, *line_between(d)), p))
    return ends
