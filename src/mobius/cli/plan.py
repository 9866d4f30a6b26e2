"""``mobius plan``: the plan alone."""

from __future__ import annotations

import json
import math
import re
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tyro.conf import Positional

from mobius.cli.common import XY, at_least, place, png_file
from mobius.errors import InvalidInput

if TYPE_CHECKING:
    from mobius.plan import Problem
    from mobius.types import Plan


def typed(message: str) -> str:
    """A message of the library with its arguments as they are typed here."""
    return re.sub(r"\b(must_reach|allow_stay|early_stop)=True", _as_option, message)


def _as_option(found: re.Match[str]) -> str:
    return "--" + found[1].replace("_", "-")


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
    policy: str | None = None
    """Whose stance needs the room: ONNX file, or flat or rough for a shipped policy of the crawl;
    flat if left out."""
    solver: str = "exact"
    """exact (our own search), didp, scip or gurobi (each with its package installed), brute
    (every path of a tiny problem), or a solver that another package brings."""
    count: str = "sweep"
    """sweep: the cell under a long crawl step is seen too; endpoint: only cells stopped on."""
    footprint: float | None = None
    """Radius of what a place sees [cells], less what obstacles hide; only itself if left out."""
    switch_cost: float | None = None
    """Points for every change of mode, >= 0; those of --costs if left out, else none."""
    costs: Path | None = None
    """Measured seconds and joules per metre and mode, a JSON file (docs/planning.md); the
    paper's if left out. Needs --per-s or --per-j."""
    per_s: float = 0.0
    """Points per second that the plan takes, >= 0."""
    per_j: float = 0.0
    """Points per joule that the plan takes, >= 0."""
    deadline: float = 2.0
    """Wall time for the search [s], > 0; the best plan by then is returned with its gap."""
    json: bool = False
    """Print one JSON object and nothing else."""
    png: Path | None = None
    """Also draw the plan over the map into this .png file."""
    gap_png: Path | None = None
    """Also draw best plan and bound over the time of the search into this .png file."""
    must_reach: bool = False
    """With --horizon: only plans that end at the goal; without it that is always so."""
    allow_stay: bool = False
    """Biped and crawl may rest for a step."""
    early_stop: bool = False
    """With --horizon: the plan may end before its last step."""

    def __call__(self) -> int:
        """Solve and print."""
        from mobius import mission
        from mobius.plan import NoPlan, build_problem, check, solve
        from mobius.plan.reasons import short_of_goal
        from mobius.plan.solvers import solver_of

        self._check()
        solver = solver_of(self.solver)
        world = mission.open_world(
            self.map,
            start=self.start,
            goal=self.goal,
            footprint=mission.footprint_of(self.policy),
        )
        trace: list[tuple[float, float, float]] = []
        try:
            problem = build_problem(
                world.grid,
                horizon=self.horizon,
                modes=self.modes,
                count=self.count,  # type: ignore[arg-type]  # Problem says what it may be
                must_reach=self.must_reach or self.horizon is None,
                allow_stay=self.allow_stay,
                early_stop=self.early_stop,
                **self._prices(),
            )
            if self.gap_png is None:
                plan = solver(problem, self.deadline)
            else:
                plan = solve(
                    problem, deadline_s=self.deadline, on_progress=lambda *m: trace.append(m)
                )
        except NoPlan as error:
            print(f"mobius: {typed(str(error))}", file=sys.stderr)
            if self.json:
                nothing = dict.fromkeys(("objective", "bound", "gap", "solve_ms"))
                print(json.dumps({"status": "infeasible", **nothing, "steps": []}))
            return 1
        check(problem, plan)
        self._draw(problem, plan, trace, world.name)
        if (short := short_of_goal(problem, plan)) is not None:
            print(f"mobius: {typed(short)}", file=sys.stderr)
        self._print(plan)
        return 0

    def _check(self) -> None:
        """Refuse options that make no sense, before any work."""
        if self.horizon is not None:
            at_least("--horizon", self.horizon, 0)
        if not self.deadline > 0:
            raise InvalidInput(f"--deadline: expected seconds > 0, got {self.deadline}")
        place("--start", self.start)
        place("--goal", self.goal)
        png_file("--png", self.png)
        png_file("--gap-png", self.gap_png)
        if self.gap_png is not None and self.solver != "exact":
            raise InvalidInput(
                f"--gap-png: only the solver 'exact' tells how it gets on, got '{self.solver}';"
                " leave out --gap-png or --solver"
            )

    def _draw(
        self, problem: Problem, plan: Plan, trace: list[tuple[float, float, float]], name: str
    ) -> None:
        """The pictures that were asked for."""
        if self.png is not None:
            from mobius.view.plan_picture import draw_plan

            draw_plan(self.png, problem, plan, title=name)
        if self.gap_png is not None:
            from mobius.view.gap_picture import draw_gap

            draw_gap(self.gap_png, trace, plan, title=name)

    def _prices(self) -> dict[str, Any]:
        """Options of the problem that price time, energy, changes of mode and sight."""
        from mobius.plan import DEFAULT_WEIGHTS, read_costs

        for flag in ("per_s", "per_j", "switch_cost"):
            value = getattr(self, flag)
            if value is not None and not (math.isfinite(value) and value >= 0):
                name = flag.replace("_", "-")
                raise InvalidInput(f"--{name}: expected points >= 0, got {value:g}")
        if self.costs is not None and not (self.per_s or self.per_j):
            raise InvalidInput("--costs: seconds and joules have no price; add --per-s or --per-j")
        travel = DEFAULT_WEIGHTS.travel if self.costs is None else read_costs(self.costs)
        weights = replace(DEFAULT_WEIGHTS, per_s=self.per_s, per_J=self.per_j, travel=travel)
        switch: Any = self.switch_cost
        if switch is None:
            switch = travel.switch_points(per_s=self.per_s, per_J=self.per_j)
        return {"weights": weights, "switch_cost": switch, "footprint": self.footprint}

    def _print(self, plan: Plan) -> None:
        """The plan as one JSON object, or in lines."""
        from mobius.results import plan_as_json

        result = plan_as_json(plan)
        if self.json:
            print(json.dumps(result))
            return
        print(
            f"{plan.status}: objective {plan.objective:g}, bound {plan.bound:g}, gap"
            f" {plan.gap:g}, {result['solve_ms']:.1f} ms, {len(plan.modes)} steps"
        )
        for step in result["steps"]:
            print(f"{step['t']:4d}  {step['x']:8.2f} {step['y']:8.2f} m  {step['mode']}")
