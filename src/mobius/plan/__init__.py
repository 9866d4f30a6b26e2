"""Where to go: the repaired Table IV as data, exact search, and a checker without a solver.

    problem = build_problem(grid, modes=("crawl",), must_reach=True)
    plan = solve(problem)      # status, objective, bound, gap
    check(problem, plan)       # raises if any rule is broken

Needs numpy only.
"""

from mobius.plan.actions import Action as Action
from mobius.plan.actions import actions_for as actions_for
from mobius.plan.build import build_problem as build_problem
from mobius.plan.build import literal_problem as literal_problem
from mobius.plan.check import broken_rule as broken_rule
from mobius.plan.check import cells_seen as cells_seen
from mobius.plan.check import check as check
from mobius.plan.check import objective_of as objective_of
from mobius.plan.energy import PlanCost as PlanCost
from mobius.plan.energy import plan_cost as plan_cost
from mobius.plan.energy import step_duration as step_duration
from mobius.plan.maps import RECONSTRUCTED_WEIGHTS as RECONSTRUCTED_WEIGHTS
from mobius.plan.maps import reconstructed_map as reconstructed_map
from mobius.plan.problem import DEFAULT_WEIGHTS as DEFAULT_WEIGHTS
from mobius.plan.problem import NoPlan as NoPlan
from mobius.plan.problem import Problem as Problem
from mobius.plan.problem import Weights as Weights
from mobius.plan.replan import Planner as Planner
from mobius.plan.risk import RiskyPlan as RiskyPlan
from mobius.plan.risk import plan_under_risk as plan_under_risk
from mobius.plan.risk import risky_value as risky_value
from mobius.plan.rolls import RollRisk as RollRisk
from mobius.plan.sight import disc as disc
from mobius.plan.solve import solve as solve
from mobius.plan.travel import Travel as Travel
from mobius.plan.travel import read_costs as read_costs
