"""Fig. 12: a plan over the map, on ours.

``python -m mobius.reproduce.fig_12 [--out FILE.png]``. The paper's map is not published;
this is the reconstructed map at the first setting of Table VI (W_exp = W_goal = 20, T = 20).
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path

from mobius import paper
from mobius.errors import MobiusError
from mobius.plan import (
    RECONSTRUCTED_WEIGHTS,
    Problem,
    build_problem,
    check,
    plan_cost,
    reconstructed_map,
    solve,
)
from mobius.reproduce.common import as_text, write_out
from mobius.types import Plan
from mobius.view.plan_picture import draw_plan

__all__ = ["TITLE", "plan_of_fig_12"]

TITLE = "reconstructed map"


def plan_of_fig_12(horizon: int = paper.MAP_HORIZON) -> tuple[Problem, Plan]:
    """The problem and its plan, checked.

    Args:
        horizon: T.
    """
    printed = paper.TABLE_VI_MULTI[0]
    weights = replace(RECONSTRUCTED_WEIGHTS, W_exp=printed.W_exp, W_goal=abs(printed.W_goal))
    problem = build_problem(reconstructed_map(), horizon=horizon, weights=weights)
    plan = solve(problem, deadline_s=None)
    check(problem, plan)
    return problem, plan


def main() -> None:
    """Draw, and print what the figure's plan is like beside the printed figures."""
    parser = argparse.ArgumentParser(prog="python -m mobius.reproduce.fig_12", description=TITLE)
    parser.add_argument("--out", type=Path, default=Path("fig_12.png"), help="the .png to write")
    parser.add_argument("--horizon", type=int, default=paper.MAP_HORIZON, help="T, steps")
    options = parser.parse_args()
    try:
        problem, plan = plan_of_fig_12(options.horizon)
    except MobiusError as error:
        sys.exit(f"fig_12: {error}")
    cost, printed = plan_cost(problem, plan), paper.TABLE_VI_MULTI[0]
    ours = (cost.mode_switches / max(len(plan.modes), 1), cost.energy_per_cell_J, plan.solve_s)
    theirs = (printed.switch_rate, printed.energy, printed.seconds)
    names = ("mode switches a step", "J per visited cell", "seconds")
    lines = zip(names, ours, theirs, strict=True)
    print(as_text([{TITLE: what, "ours": a, "paper": b} for what, a, b in lines]))
    write_out("fig_12", lambda: draw_plan(options.out, problem, plan, title=TITLE), options.out)


if __name__ == "__main__":
    main()
