r"""Planning where a roll does not land for sure: expectation on rolls, a policy for an answer.

A roll comes to rest 2, 3 or 4 cells on with given probabilities, and ends badly (on the side,
say) with another, which costs points and is over before the next step. With k steps to go

    V_0(c) = stop(c)
    V_k(c) = max_a  W (1 + seen_a(c)) - E cost_a(c)  +  sum_n p_n V_{k-1}(c + n d_a)

and the policy takes the a that attains it. A roll is only allowed where every landing that
may happen is allowed, so a robot that follows the policy never hits a wall, and with
``must_reach`` it ends at the goal for certain.

What is relaxed: V pays for a cell on every visit. It is therefore the expectation of the
objective where nothing is paid for seeing (``W_exp=0``: a shortest way under risk), and
otherwise an upper bound on what any policy can expect, with or without memory; the policy of
the table alone may then walk to and fro. :meth:`RiskyPlan.action_at` takes the cells seen so
far for that reason: it prices the next step and its landing by what is new. What that really
earns is for :meth:`RiskyPlan.play` to say.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mobius.errors import PlanError
from mobius.plan.actions import Action, line_between
from mobius.plan.arcs import build_arcs
from mobius.plan.bounds import dp_bound
from mobius.plan.check import cells_seen, objective_of
from mobius.plan.problem import NoPlan, Problem
from mobius.plan.rolls import PAD, Endings, RollRisk
from mobius.types import Mode, Plan

__all__ = ["Played", "RiskyPlan", "RollRisk", "plan_under_risk", "risky_value"]

Cell = tuple[int, int]
Array = NDArray[np.float64]

STOP = -1
"""In a table of choices: end the plan here."""


class Played(NamedTuple):
    """One run of a policy with the dice thrown."""

    cells: list[Cell]
    modes: list[Mode]
    bad: int
    """Rolls that ended badly."""
    points: float
    """The objective: every cell earns once, bad ends cost."""
    paid: float
    """What the table counts: every visit earns."""


def _stop(problem: Problem) -> Array:
    """(nx, ny) value of ending on a cell, its own reward left out."""
    i, j = np.indices(problem.grid.shape)
    d2 = (i - problem.goal[0]) ** 2 + (j - problem.goal[1]) ** 2
    stop = -problem.weights.W_goal * d2.astype(float)
    stop[problem.grid.blocked | (problem.must_reach & (d2 > 0))] = -np.inf
    return stop


def risky_value(problem: Problem, risk: RollRisk) -> tuple[Array, NDArray[np.int16]]:
    """The table V of the module's docstring and the choices that attain it.

    Args:
        problem: Any problem without ``switch_cost`` and ``footprint``.
        risk: How rolls end.

    Returns:
        (T + 1, nx, ny) points with k steps to go, -inf where no policy keeps the rules, and
        (T + 1, nx, ny) numbers of ``problem.actions``, -1 to end there.

    Raises:
        PlanError: The problem has an option that is not stated here.
    """
    return _value(Endings(problem, risk))


def _value(tables: Endings) -> tuple[Array, NDArray[np.int16]]:
    problem = tables.problem
    W, T = problem.weights.W_exp, problem.horizon
    stop = _stop(problem) + (W * problem.pays if problem.count_terminal else 0.0)
    V = np.full((T + 1, *problem.grid.shape), -np.inf)
    choice = np.full(V.shape, STOP, dtype=np.int16)
    V[0] = stop
    for k in range(1, T + 1):
        if problem.early_stop:
            V[k] = stop
        later = np.pad(V[k - 1], PAD, constant_values=-np.inf)
        for a, outcomes in enumerate(tables.outcomes):
            q = W * tables.earns[a]
            for o in outcomes:
                q = q + o.p * (tables.at(later, o.step.d) - o.cost)
            better = tables.open_at(a, k) & (q > V[k])
            V[k][better] = q[better]
            choice[k][better] = a
    return V, choice


class RiskyPlan:
    """A policy, what it may expect, and the path it takes if every roll lands where meant."""

    def __init__(self, problem: Problem, risk: RollRisk) -> None:
        self.problem, self.risk = problem, risk
        self._tables = Endings(problem, risk)
        self.value, self.choice = _value(self._tables)
        """(T + 1, nx, ny) points and numbers of actions, see :func:`risky_value`."""
        self.expected = float(self.value[(problem.horizon, *problem.start)])
        """V_T(start) [points]: exact where ``W_exp`` is 0, else no policy can expect more."""

    def action_at(self, k: int, cell: Cell, seen: set[Cell] | None = None) -> Action | None:
        """What to do with k steps to go on a cell; ``None``: end here.

        Args:
            k: Steps to go, 0 to the horizon.
            cell: Where the robot is.
            seen: Cells counted so far on this run: the next step is then priced by what it
                sees anew. The table's own choice if not given.

        Raises:
            PlanError: No policy keeps the rules from there.
        """
        if not (0 <= k <= self.problem.horizon and self.problem.grid.holds(cell)):
            raise PlanError(
                f"no entry for {k} steps to go at cell {cell}; the table has 0 to"
                f" {self.problem.horizon} steps and {self.problem.grid.shape} cells"
            )
        if self.value[(k, *cell)] == -np.inf:
            raise PlanError(f"from cell {cell} no policy keeps every rule in {k} steps")
        if k == 0:
            return None
        a = int(self.choice[(k, *cell)]) if seen is None else self._best(k, cell, seen)
        return None if a == STOP else self.problem.actions[a]

    def _best(self, k: int, cell: Cell, seen: set[Cell]) -> int:
        """The action whose step and landing are worth most after what was seen."""
        p, W = self.problem, self.problem.weights.W_exp
        surely = p.count_terminal or (k > 1 and not p.early_stop)
        best, value = STOP, -np.inf
        if p.early_stop:
            here = len(cells_seen(p, [cell], []) - seen)  # a last cell counts only if it may
            value = float(_stop(p)[cell]) + W * here
        for a, outcomes in enumerate(self._tables.outcomes):
            if not self._tables.open_at(a, k)[cell]:
                continue
            q = 0.0
            for o in outcomes:
                to = (cell[0] + o.step.d[0], cell[1] + o.step.d[1])
                now = seen | self._counted(cell, to, o.step.mode)
                q += o.p * (W * len(now - seen) - o.cost[cell] + self.value[(k - 1, *to)])
                if surely and to in now and p.pays[to]:
                    q -= o.p * W  # the table pays for the landing, which will not pay
            if q > value:
                best, value = a, q
        return best

    def _counted(self, cell: Cell, to: Cell, mode: Mode) -> set[Cell]:
        """Cells that a step counts without its landing; those that never earn left out."""
        counted = {cell}
        if self.problem.count == "sweep" and mode is not Mode.ROLL:
            d = (to[0] - cell[0], to[1] - cell[1])
            counted |= {(cell[0] + i, cell[1] + j) for i, j in line_between(d)[0]}
        return {c for c in counted if self.problem.pays[c]}

    def play(self, rng: np.random.Generator | None = None, *, aware: bool = True) -> Played:
        """Run the policy once.

        Args:
            rng: Throws the dice; without it every roll lands 3 cells on and ends well.
            aware: Whether it looks at what it has seen, or goes by the table alone.
        """
        p, risk = self.problem, self.risk
        cells, modes, seen, bad, paid = [p.start], list[Mode](), set[Cell](), 0, 0.0
        for k in range(p.horizon, 0, -1):
            here = cells[-1]
            action = self.action_at(k, here, seen if aware else None)
            if action is None:
                break
            a = p.actions.index(action)
            outcomes = self._tables.outcomes[a]
            n = [o.step.d == action.d for o in outcomes].index(True)
            if rng is not None and action.mode is Mode.ROLL:
                n = int(rng.choice(len(outcomes), p=[o.p for o in outcomes]))
                bad += int(rng.random() < risk.p_bad)
            d = outcomes[n].step.d
            cells.append((here[0] + d[0], here[1] + d[1]))
            modes.append(action.mode)
            seen |= self._counted(here, cells[-1], action.mode)
            paid += p.weights.W_exp * float(self._tables.earns[a][here])
        unpaid = _without_reward(p, cells, modes) - risk.penalty * bad
        last = p.weights.W_exp * float(p.count_terminal and p.pays[cells[-1]])
        points = objective_of(p, cells, modes) - risk.penalty * bad
        return Played(cells, modes, bad, points, paid + last + unpaid)

    @property
    def nominal(self) -> Plan:
        """The path if every roll lands 3 cells on, priced as if there were no risk."""
        played = self.play()
        p, cells = self.problem, np.array(played.cells, dtype=np.int64)
        arcs = build_arcs(p)
        bound = float(dp_bound(p, arcs)[p.horizon, arcs.flat(p.start)])
        xy = p.grid.center_of(cells)
        return Plan(cells, tuple(played.modes), xy, "feasible", played.points, bound, 0.0)


def _without_reward(p: Problem, cells: list[Cell], modes: list[Mode]) -> float:
    """The objective less what was seen."""
    return objective_of(p, cells, modes) - p.weights.W_exp * len(cells_seen(p, cells, modes))


def plan_under_risk(problem: Problem, risk: RollRisk) -> RiskyPlan:
    """Plan with rolls that land by chance.

    Args:
        problem: Any problem without ``switch_cost`` and ``footprint``.
        risk: How rolls end.

    Raises:
        NoPlan: No policy keeps every rule for certain.
        PlanError: The problem has an option that is not stated here.
    """
    plan = RiskyPlan(problem, risk)
    if plan.expected == -np.inf:
        end = "ends at the goal" if problem.must_reach else "goes on"
        raise NoPlan(
            f"under this risk no policy {end} for certain in {problem.horizon} steps; add a mode"
            " that lands where it means to, more steps, or early_stop=True"
        )
    return plan
