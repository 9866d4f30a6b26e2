"""Large maps: a plan that obeys, under a bound that holds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mobius.plan import Problem, check, solve
from mobius.plan.bounds import build_arcs, dp_bound
from mobius.plan.large import is_large, solve_large
from mobius.plan.solvers.brute import brute, number_of_paths
from mobius.types import GridMap, Plan


def open_map(n: int, share: float, seed: int) -> GridMap:
    blocked = np.random.default_rng(seed).random((n, n)) < share
    blocked[:3, :3] = blocked[-3:, -3:] = False
    return GridMap("noise", 0.5, np.zeros(3), blocked, np.full((n, n), 7))


def large(p: Problem, *, incumbent: Plan | None = None, deadline_s: float | None = None) -> Plan:
    arcs = build_arcs(p)
    U = dp_bound(p, arcs, window=True)
    return solve_large(p, arcs, U, deadline_s=deadline_s, max_states=20_000, incumbent=incumbent)


def has_a_plan(p: Problem) -> bool:
    arcs = build_arcs(p)
    return dp_bound(p, arcs)[p.horizon, arcs.flat(p.start)] > -np.inf


def test_its_bound_and_its_plan_enclose_the_best_of_all_paths(rng, random_problem):
    compared = 0
    for _ in range(50):
        p = replace(random_problem(rng), horizon=int(rng.integers(0, 6)))
        if not has_a_plan(p) or number_of_paths(p) > 2000:
            continue
        plan = large(p)
        check(p, plan)
        best = brute(p).objective
        assert plan.objective <= best + 1e-6
        assert best <= plan.bound + 1e-6
        compared += 1
    assert compared > 15


def test_they_enclose_the_optimum_too_where_things_move(rng, random_problem):
    compared = 0
    for _ in range(50):
        p = replace(random_problem(rng, moving=True), horizon=int(rng.integers(0, 9)))
        if not has_a_plan(p):
            continue
        plan, best = large(p), solve(p, deadline_s=None)
        check(p, plan)
        if best.status == "optimal":
            assert plan.objective <= best.objective + 1e-6
            assert best.objective <= plan.bound + 1e-6
            compared += 1
    assert compared > 15


def test_a_map_of_100_by_100_cells_there_and_home():
    grid = open_map(100, 0.2, 3)
    for goal in ((99, 99), (0, 0)):
        p = Problem(grid, (0, 0), goal, 100)
        plan = large(p)
        check(p, plan)
        assert plan.gap <= 0.1 * plan.bound
        assert plan.bound <= p.weights.W_exp * 2 * 101


def test_a_small_region_of_a_large_map_is_bounded_by_what_there_is_to_see():
    blocked = np.zeros((60, 60), bool)
    blocked[6, :6] = blocked[:7, 6] = True
    grid = GridMap("cage", 0.5, np.zeros(3), blocked, np.full((60, 60), 7))
    plan = large(Problem(grid, (0, 0), (0, 0), 60))
    assert plan.bound <= 20.0 * 36 - 60


def test_a_known_plan_is_never_made_worse_and_no_time_is_still_a_plan():
    p = Problem(open_map(60, 0.25, 1), (0, 0), (0, 0), 60)
    good = large(p)
    again = large(p, incumbent=good, deadline_s=0.0)
    check(p, again)
    assert again.objective >= good.objective
    hurried = large(p, deadline_s=0.0)
    check(p, hurried)
    assert hurried.objective <= good.objective


def test_solve_takes_this_way_when_the_table_is_large():
    p = Problem(open_map(200, 0.1, 0), (0, 0), (199, 199), 120)
    assert is_large(p)
    plan = solve(p, deadline_s=None, max_states=5000)
    check(p, plan)
    assert plan.gap <= 0.1 * abs(plan.bound)


def test_a_plan_that_may_stop_early_is_found_on_a_large_map_too():
    p = replace(
        Problem(open_map(120, 0.1, 0), (0, 0), (20, 20), 30), early_stop=True, must_reach=True
    )
    plan = large(p)
    check(p, plan)
    assert tuple(plan.cells[-1]) == (20, 20)
