"""``mobius plan``: the plan alone."""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from pathlib import Path

from tyro.conf import Positional

from mobius.cli.common import XY, at_least
from mobius.errors import InvalidInput


@dataclass
class PlanVerb:
    """Plan on a map and print the plan: status, objective (higher is better), bound, steps.

    The objective is the repaired Table IV: cells seen earn, modes cost. ``mobius run`` plans the
    shortest way instead, with a cost near obstacles.
    """

    map: Positional[str]
    """A Nav2 map.yaml, a MovingAI .map, or the name of a shipped map."""
    start: XY | None = None
    """x y [m] in the map frame; the map's own if left out."""
    goal: XY | None = None
    """x y [m] in the map frame; the map's own if left out."""
    horizon: int | None = None
    """T: number of steps, >= 0; the fewest that reach the goal if left out."""
    modes: tuple[str, ...] = ("biped", "crawl", "roll")
    """Body modes the plan may use: biped, crawl, roll."""
    solver: str = "exact"
    """exact (our own search), didp, scip or gurobi (each with its package installed), brute
    (every path of a tiny problem), or a solver that another package brings."""
    count: str = "sweep"
    """sweep: the cell under a long crawl step is seen too; endpoint: only cells stopped on."""
    deadline: float = 2.0
    """Wall time for the search [s], > 0; the best plan by then is returned with its gap."""
    json: bool = False
    """Print one JSON object and nothing else."""
    png: Path | None = None
    """Also draw the plan over the map into this .png file."""

    def __call__(self) -> int:
        """Solve and print."""
        from mobius import mission
        from mobius.plan import NoPlan, build_problem, check
        from mobius.plan.solvers import solver_of
        from mobius.results import plan_as_json

        if self.horizon is not None:
            at_least("--horizon", self.horizon, 0)
        if not self.deadline > 0:
            raise InvalidInput(f"--deadline: expected seconds > 0, got {self.deadline}")
        solver = solver_of(self.solver)
        if self.png is not None and self.png.suffix.lower() != ".png":
            raise InvalidInput(f"--png: expected a file that ends in .png, got {self.png}")
        world = mission.open_world(self.map, start=self.start, goal=self.goal)
        try:
            problem = build_problem(
                world.grid,
                horizon=self.horizon,
                modes=self.modes,
                count=self.count,  # type: ignore[arg-type]  # Problem says what it may be
                must_reach=self.horizon is None,
            )
            plan = solver(problem, self.deadline)
        except NoPlan as error:
            print(f"mobius: {error}", file=sys.stderr)
            if self.json:
                nothing = dict.fromkeys(("objective", "bound", "gap", "solve_ms"))
                print(json.dumps({"status": "infeasible", **nothing, "steps": []}))
            return 1
        check(problem, plan)
        if self.png is not None:
            from mobius.view.plan_picture import draw_plan

            draw_plan(self.png, problem, plan, title=world.name)
        result = plan_as_json(plan)
        if self.json:
            print(json.dumps(result))
        else:
            print(
                f"{plan.status}: objective {plan.objective:g}, bound {plan.bound:g}, gap"
                f" {plan.gap:g}, {result['solve_ms']:.1f} ms, {len(plan.modes)} steps"
            )
            for step in result["steps"]:
                print(f"{step['t']:4d}  {step['x']:8.2f} {step['y']:8.2f} m  {step['mode']}")
        return 0
