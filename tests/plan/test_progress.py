"""What a search tells while it runs."""

from __future__ import annotations

import numpy as np

from mobius.plan import Problem, build_problem, reconstructed_map, solve
from mobius.plan.progress import Teller
from mobius.types import GridMap


def saturated() -> Problem:
    """8 x 8 cells and 40 steps: the first bound is not attained."""
    blocked = np.random.default_rng(3).random((8, 8)) < 0.2
    blocked[0, 0] = blocked[7, 7] = False
    grid = GridMap("saturated", 0.5, np.zeros(3), blocked, np.full((8, 8), 7))
    return Problem(grid, (0, 0), (7, 7), 40)


def traced(problem: Problem, **options):
    trace: list[tuple[float, float, float]] = []
    plan = solve(problem, deadline_s=None, on_progress=lambda *m: trace.append(m), **options)
    return plan, np.array(trace)


def test_time_and_objective_only_rise_and_the_bound_only_falls():
    plan, trace = traced(saturated(), max_states=4000)
    t, best, bound = trace.T
    assert len(trace) >= 4
    assert (np.diff(t) >= 0).all() and (best[1:] >= best[:-1]).all() and (np.diff(bound) <= 0).all()
    assert (best <= bound).all()
    assert (best[-1], bound[-1]) == (plan.objective, plan.bound)


def test_every_moment_is_news():
    _, trace = traced(saturated(), max_states=4000)
    moments = [tuple(m[1:]) for m in trace]
    assert len(set(moments)) == len(moments)


def test_an_easy_problem_tells_its_bound_and_its_proof():
    plan, trace = traced(build_problem(reconstructed_map(), horizon=20))
    assert plan.status == "optimal"
    assert trace[0, 1] == -np.inf and tuple(trace[-1, 1:]) == (plan.objective, plan.objective)


def test_a_plan_to_start_from_is_told_before_anything_is_found():
    problem = saturated()
    known = solve(problem, deadline_s=None, max_states=200)
    _, trace = traced(problem, max_states=4000, incumbent=known)
    assert trace[1, 1] == known.objective


def test_being_listened_to_does_not_change_the_plan():
    problem = saturated()
    plan, _ = traced(problem, max_states=4000)
    alone = solve(problem, deadline_s=None, max_states=4000)
    assert np.array_equal(plan.cells, alone.cells) and plan.modes == alone.modes


def test_what_is_worse_than_before_is_not_told():
    told: list[tuple[float, float, float]] = []
    tell = Teller(lambda *m: told.append(m), 0.0)
    for moment in ((-np.inf, 9.0), (3.0, 9.0), (2.0, 10.0), (3.0, 8.0)):
        tell(*moment)
    assert [m[1:] for m in told] == [(-np.inf, 9.0), (3.0, 9.0), (3.0, 8.0)]
