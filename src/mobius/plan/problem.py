r"""The planner's problem as data: Table IV of the paper, repaired.

    maximise   W_exp |cells counted|  -  W_goal ||x_T - x_goal||^2  -  sum_t P[m(t)]
                                      -  sum of cell_cost over the cells entered
                                      -  sum_t (per_s seconds + per_J joules of step t)
                                      -  sum of switch_cost over the changes of mode

over paths x(0), ..., x(T) of grid cells and modes m(0), ..., m(T-1), where x(t+1) = x(t) +
d(t) (7) and d(t) is a step of mode m(t) (8)-(11). Distances count cells, so all weights
are in points: W_exp per cell seen, W_goal per squared cell, P per step.

What was repaired, and the argument that brings the printed form back:

===========================  ======================================  =====================
printed                      here                                    printed form
===========================  ======================================  =====================
(4) is vacuous,              a cell counts once, and only when       (no use)
(5) (6) one-sided            the robot was on it
(2) leaves x_T out           x_T counts                              count_terminal=False
(5) (6) end points only      a crawl's middle cell is seen too;      count="endpoint"
                             a roll sees only where it lands
(8)-(10) both axes           one axis per step                       connectivity=
                                                                     "diagonal"
(12)-(15) circles force      bits of ``GridMap.allowed``             (same meaning)
a mode on departure          on every cell of the step               check="endpoint"
(16)-(20) infeasible         blocked cells, passed over or           check="endpoint"
                             landed on                               (landings only)
===========================  ======================================  =====================

With ``check="swept"`` a step of mode m needs m allowed on its departure, on its landing
and on everything between: the body changes mode only on ground that allows both modes.

With a ``footprint`` more is counted than where the robot is: every place that counts (as
``count`` and ``count_terminal`` say) looks round, and the cells in its sight count.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from mobius.errors import InvalidInput, PlanError, UnknownName
from mobius.plan.actions import Action, Connectivity, actions_for
from mobius.plan.sight import footprint_of
from mobius.plan.travel import PAPER_TRAVEL, Travel, plan_mode, switch_table
from mobius.types import GridMap, Mode, frozen_array

__all__ = ["DEFAULT_WEIGHTS", "Check", "Count", "NoPlan", "Problem", "Weights"]

Count = Literal["sweep", "endpoint"]
Check = Literal["swept", "endpoint"]
Cell = tuple[int, int]

MAX_TABLE = 50_000_000
"""Entries of the bound table, (horizon + 1) x cells, that are accepted (400 MB)."""


MAX_POINTS = 1e12
"""Largest weight that is accepted [points]; sums of larger ones overflow."""


class NoPlan(PlanError):
    """The problem has no plan at all; the message says why and what would help.

    Attributes:
        smallest_horizon: The smallest horizon that has a plan, if one has.
    """

    def __init__(self, message: str, *, smallest_horizon: int | None = None) -> None:
        self.smallest_horizon = smallest_horizon
        super().__init__(message)


@dataclass(frozen=True)
class Weights:
    """Weights of the objective. The paper prints none of P; the order is its text's."""

    W_exp: float = 20.0
    """Points per cell seen for the first time, >= 0."""
    W_goal: float = 20.0
    """Points per squared cell between the last cell and the goal, >= 0."""
    P: Mapping[Mode, float] = field(
        default_factory=lambda: {Mode.BIPED: 5.0, Mode.CRAWL: 1.0, Mode.ROLL: 10.0}
    )
    """Points per step of each mode, >= 0."""
    per_s: float = 0.0
    """Points per second that a step takes, >= 0."""
    per_J: float = 0.0
    """Points per joule that a step takes, >= 0."""
    travel: Travel = PAPER_TRAVEL
    """Seconds and joules per metre and mode; measured ones by
    :func:`mobius.plan.read_costs`. Resting lasts as long as one cell takes and costs no J."""

    def __post_init__(self) -> None:
        P = {plan_mode(m): _points(f"P[{m}]", v) for m, v in dict(self.P or {}).items()}
        object.__setattr__(self, "P", MappingProxyType(P))
        for name in ("W_exp", "W_goal", "per_s", "per_J"):
            object.__setattr__(self, name, _points(name, getattr(self, name)))


def _points(name: str, value: object) -> float:
    """A weight as a number; raises where it is none, or one that no plan can be weighed with."""
    try:
        number = float(value)  # type: ignore[arg-type]  # what is no number is told below
    except (TypeError, ValueError):
        number = float("nan")
    if not 0 <= number <= MAX_POINTS:
        upper = f" and <= {MAX_POINTS:g}" if number > MAX_POINTS else ""
        raise InvalidInput(f"Weights.{name}: expected a number >= 0{upper}, got {value}")
    return number


DEFAULT_WEIGHTS = Weights()


@dataclass(frozen=True, eq=False)
class Problem:
    """One planning problem, complete and checked. Places are cells here, not metres.

    Make one with :func:`mobius.plan.build_problem`, which takes metres and explains what is
    wrong with a place.
    """

    grid: GridMap
    start: Cell
    goal: Cell
    horizon: int
    """T, number of steps: exactly (default) or at most (``early_stop``)."""
    modes: tuple[Mode, ...] = (Mode.BIPED, Mode.CRAWL, Mode.ROLL)
    weights: Weights = DEFAULT_WEIGHTS
    connectivity: Connectivity = "axis"
    count: Count = "sweep"
    """``sweep``: a crawl's crossed cells count; ``endpoint``: only cells stopped on."""
    check: Check = "swept"
    """``swept``: all cells of a step must be free and allow the mode; ``endpoint``: the
    departure must allow the mode and the landing be free."""
    count_terminal: bool = True
    """Whether the last cell counts as seen."""
    allow_stay: bool = False
    """Whether biped and crawl may rest for a step (it costs P)."""
    must_reach: bool = False
    """The last cell must be the goal (otherwise being away from it only costs)."""
    early_stop: bool = False
    """The plan may end after any t <= T steps; the objective is that of the steps taken."""
    cell_cost: NDArray[np.float64] | None = None
    """(nx, ny) points >= 0 subtracted for every cell a step enters (crossed or landed on,
    each time), e.g. for coming close to walls; ``None`` is all zero."""
    seen: NDArray[np.bool_] | None = None
    """(nx, ny) cells that were seen before the plan begins and earn nothing; ``None``: none."""
    closed: NDArray[np.bool_] | None = None
    """(K, nx, ny) cells that something else occupies at step t = 0, 1, ...; the last one holds
    from K - 1 on. A step from t to t + 1 may neither cross nor land on what is closed at t or
    at t + 1, so that nothing is met and nothing swaps places. ``None``: nothing moves."""
    switch_cost: Mapping[tuple[Mode, Mode], float] | None = None
    """Points >= 0 subtracted where a step's mode differs from that of the step before, by
    (from, to); changes left out are free. ``None``: all are."""
    last_mode: Mode | None = None
    """The mode before the first step; ``None``: the first step changes nothing."""
    footprint: tuple[Cell, ...] | None = None
    """Cells a place sees, as offsets (:func:`mobius.plan.disc` makes a round one), less what
    obstacles hide, see :mod:`mobius.plan.sight`. ``None``: only itself."""

    def __post_init__(self) -> None:
        for name, kind in (("connectivity", Connectivity), ("count", Count), ("check", Check)):
            if getattr(self, name) not in get_args(kind):
                raise UnknownName(f"{name} option", str(getattr(self, name)), get_args(kind))
        object.__setattr__(self, "modes", tuple(dict.fromkeys(plan_mode(m) for m in self.modes)))
        if not self.modes:
            raise PlanError("no modes to plan with; pass some of biped, crawl, roll")
        for mode in self.modes:
            if mode not in self.weights.P:
                raise PlanError(f"Weights.P: no penalty for mode '{mode}'; add P['{mode}']")
        for name in ("start", "goal"):
            cell = tuple(int(v) for v in getattr(self, name))
            object.__setattr__(self, name, cell)
            if not self.grid.holds(cell):
                raise PlanError(f"{name} cell {cell} is off the grid of {self.grid.shape} cells")
            if self.grid.blocked[cell]:
                raise PlanError(f"{name} cell {cell} lies in an obstacle")
        self._check_horizon()
        cost = np.zeros(self.grid.shape) if self.cell_cost is None else self.cell_cost
        frozen_array(self, "cell_cost", cost, self.grid.shape)
        if np.min(cost) < 0:
            raise InvalidInput(f"Problem.cell_cost: expected costs >= 0, got {np.min(cost)}")
        if self.seen is not None:
            frozen_array(self, "seen", self.seen, self.grid.shape, np.bool_)
        if self.closed is not None:
            frozen_array(self, "closed", self.closed, (None, *self.grid.shape), np.bool_)
            if len(self.closed) == 0:
                raise InvalidInput("Problem.closed: expected at least one step, got none")

        self._check_extras()

    def _check_extras(self) -> None:
        """Prices of time, energy and changes of mode, and the footprint."""
        w = self.weights
        for mode in self.modes:
            if w.per_s:
                w.travel.seconds(mode, 1.0)
            if w.per_J:
                w.travel.joules(mode, 1.0)
        if self.last_mode is not None:
            object.__setattr__(self, "last_mode", plan_mode(self.last_mode))
        if self.switch_cost is not None:
            table = switch_table("Problem.switch_cost", self.switch_cost)
            object.__setattr__(self, "switch_cost", table if any(table.values()) else None)
        if self.footprint is not None:
            cells = footprint_of(self.footprint)
            object.__setattr__(self, "footprint", None if cells == ((0, 0),) else cells)

    def _check_horizon(self) -> None:
        T = self.horizon
        if not (T >= 0 and float(T).is_integer()):
            raise InvalidInput(f"horizon: expected a whole number of steps >= 0, got {T}")
        object.__setattr__(self, "horizon", int(T))
        nx, ny = self.grid.shape
        tables = 1 if not self.switch_cost else len(self.modes)
        if (T + 1) * nx * ny * tables > MAX_TABLE:
            most = MAX_TABLE // (nx * ny * tables) - 1
            raise PlanError(
                f"horizon {T} on {nx} x {ny} cells is too large to solve in memory; use a"
                f" horizon of at most {most} or larger cells"
            )

    @property
    def actions(self) -> tuple[Action, ...]:
        """Every kind of step, in a fixed order."""
        return actions_for(self.modes, self.connectivity, allow_stay=self.allow_stay)

    def closed_between(self, t: int) -> NDArray[np.bool_] | None:
        """(nx, ny) cells that a step from t to t + 1 may not enter; ``None`` where all may."""
        if self.closed is None:
            return None
        last = len(self.closed) - 1
        occupied = self.closed[min(t, last)] | self.closed[min(t + 1, last)]
        return occupied if occupied.any() else None

    def switch_points(self, before: Mode | None, mode: Mode) -> float:
        """Points of changing from one mode (``None``: from any) to another."""
        if self.switch_cost is None or before is None or before is mode:
            return 0.0
        return self.switch_cost.get((before, mode), 0.0)

    @property
    def pays(self) -> NDArray[np.bool_]:
        """(nx, ny) cells whose first visit earns ``W_exp``."""
        return ~self.grid.blocked if self.seen is None else ~self.grid.blocked & ~self.seen

    @property
    def costs(self) -> NDArray[np.float64]:
        """(nx, ny) :attr:`cell_cost`, zeros where none was given."""
        return np.zeros(self.grid.shape) if self.cell_cost is None else self.cell_cost
