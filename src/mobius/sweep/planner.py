"""The planner as a sweep's work: a setting becomes a plan becomes a row of figures."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mobius.errors import MapError, PlanError, UnknownName
from mobius.plan import Problem, Weights, build_problem, check, plan_cost, solve
from mobius.sweep.settings import Row, Setting
from mobius.types import GridMap, Mode, Plan

__all__ = ["ALL_MODES", "SETTING_KEYS", "PlannerWork", "modes_of", "plan_row"]

ALL_MODES = "biped+crawl+roll"
"""Modes of a setting are one word, joined by '+'."""
SETTING_KEYS = (
    "map", "horizon", "modes", "connectivity", "count",
    "W_exp", "W_goal", "P_biped", "P_crawl", "P_roll",
)  # fmt: skip
"""What :func:`plan_row` reads of a setting; more may stand there and does nothing."""


@dataclass(frozen=True, eq=False)
class PlannerWork:
    """``work(setting)`` plans on the map that the setting names."""

    maps: Mapping[str, GridMap]

    def __call__(self, setting: Setting) -> Row:
        """The row of a setting."""
        if setting["map"] not in self.maps:
            raise UnknownName("map", setting["map"], self.maps)
        return plan_row(setting, self.maps[setting["map"]])

    @property
    def stamp(self) -> str:
        """Digest of everything in the maps."""
        digest = hashlib.sha256()
        for name, grid in sorted(self.maps.items()):
            ends = [[] if p is None else p.tolist() for p in (grid.start, grid.goal)]
            digest.update(repr((name, grid.cell, grid.origin_M.tolist(), grid.shape)).encode())
            digest.update(repr(ends).encode() + grid.blocked.tobytes() + grid.allowed.tobytes())
        return digest.hexdigest()


def modes_of(word: str) -> tuple[str, ...]:
    """Names of the modes in a word such as ``biped+crawl``."""
    return tuple(word.split("+"))


def weights_of(setting: Setting) -> Weights:
    """The weights of a setting [points]; W_goal and P are penalties, >= 0."""
    P = {Mode(m): float(setting[f"P_{m}"]) for m in ("biped", "crawl", "roll")}
    return Weights(W_exp=float(setting["W_exp"]), W_goal=float(setting["W_goal"]), P=P)


def plan_row(setting: Setting, grid: GridMap) -> Row:
    """Plan and say what the plan is like.

    The goal is a penalty, not a must, as in the paper's objective; ``goal_cells_away`` says
    what came of it. There is no deadline, so that the row does not depend on the machine
    (``solve_s`` apart): the search has its budget of states.

    Returns:
        ``status`` (optimal, feasible, infeasible), ``goal_cells_away`` (larger of both axes,
        from the last cell), ``objective``, ``bound``, ``gap`` [points], ``steps``,
        ``mode_switches``, ``mode_switch_rate`` (a step), ``cells_seen``, ``energy_J``,
        ``energy_per_cell_J``, ``duration_s``, ``solve_s`` (wall time), ``why`` (no plan).
    """
    try:
        problem, plan = solved(setting, grid)
    except (PlanError, MapError) as error:
        return _figures(None, None, why=str(error))
    return _figures(problem, plan, why="")


def solved(setting: Setting, grid: GridMap) -> tuple[Problem, Plan]:
    """Problem and checked plan of a setting. Raises PlanError or MapError where there is none."""
    problem = build_problem(
        grid,
        horizon=setting["horizon"],
        modes=modes_of(setting["modes"]),
        weights=weights_of(setting),
        connectivity=setting["connectivity"],
        count=setting["count"],
    )
    plan = solve(problem, deadline_s=None)
    check(problem, plan)
    return problem, plan


def _figures(problem: Problem | None, plan: Plan | None, *, why: str) -> Row:
    """A plan as plain values, and the same names where there is none."""
    if problem is None or plan is None:
        names = (
            "goal_cells_away", "objective", "bound", "gap", "steps", "mode_switches",
            "mode_switch_rate", "cells_seen", "energy_J", "energy_per_cell_J", "duration_s",
            "solve_s",
        )  # fmt: skip
        return {"status": "infeasible", **dict.fromkeys(names), "why": why}
    cost = plan_cost(problem, plan)
    steps = len(plan.modes)
    return {
        "status": plan.status,
        "goal_cells_away": int(np.abs(plan.cells[-1] - np.array(problem.goal)).max()),
        "objective": plan.objective,
        "bound": plan.bound,
        "gap": plan.gap,
        "steps": steps,
        "mode_switches": cost.mode_switches,
        "mode_switch_rate": cost.mode_switches / steps if steps else 0.0,
        "cells_seen": cost.cells_seen,
        "energy_J": cost.energy_J,
        "energy_per_cell_J": cost.energy_per_cell_J,
        "duration_s": cost.duration_s,
        "solve_s": plan.solve_s,
        "why": why,
    }
