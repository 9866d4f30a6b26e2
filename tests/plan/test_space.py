"""The search's states: what prices, changes of mode and a footprint do to them."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from mobius.plan import NoPlan, Problem, Weights, build_problem, check, disc, solve
from mobius.plan.bounds import build_arcs, capacity_bound, dp_bound, mode_bounds
from mobius.plan.solvers.brute import _moves, _number_of_paths, brute
from mobius.plan.space import Space
from mobius.types import GridMap, Mode

MAX_PATHS = 120
FREE = Weights(W_exp=20.0, W_goal=0.0, P={"biped": 0.0, "crawl": 0.0, "roll": 0.0})


def small(p: Problem) -> Problem:
    """The problem with the largest T <= 7 that leaves few paths."""
    moves, T = _moves(p), 7
    while _number_of_paths(replace(p, horizon=T), moves) > MAX_PATHS:
        T -= 1
    return replace(p, horizon=T)


def truth_of(p: Problem) -> float:
    try:
        return brute(p).objective
    except NoPlan:
        return -np.inf


@pytest.mark.parametrize("seed", range(10))
def test_the_search_agrees_with_brute_force_on_every_option(seed, random_problem, dressed):
    """Hundreds of small maps: prices, changes of mode, footprint, seen and closed cells."""
    rng = np.random.default_rng([seed, 5])
    feasible = Counter()
    for n in range(30):
        p = small(dressed(rng, random_problem(rng, side=(2, 5), moving=bool(n % 2))))
        truth = truth_of(p)
        plan = solve(p, deadline_s=None, raise_infeasible=False)
        if truth == -np.inf:
            assert plan.status == "infeasible"
            continue
        check(p, plan)
        assert plan.status == "optimal"
        assert plan.objective == pytest.approx(truth, abs=1e-9)
        bounds(p, truth)
        feasible["footprint"] += p.footprint is not None
        feasible["switch_cost"] += p.switch_cost is not None
        feasible["all"] += 1
    assert feasible["all"] > 10
    assert min(feasible["footprint"], feasible["switch_cost"]) > 3


def bounds(p: Problem, truth: float) -> None:
    """Every bound holds, and that per mode is the tighter one."""
    arcs, tol = build_arcs(p), 1e-9 * max(1.0, abs(truth))
    U = dp_bound(p, arcs)
    root = float(U[p.horizon, arcs.flat(p.start)])
    assert capacity_bound(p, arcs) >= truth - tol
    assert root >= truth - tol
    space = Space(p, arcs, U)
    assert root + tol >= space.root >= truth - tol
    if p.switch_cost is not None:
        by_mode, tight = mode_bounds(p, arcs)
        assert root + tol >= tight >= truth - tol
        assert (by_mode <= U + 1e-9).all()


def test_a_change_of_mode_is_paid_and_then_avoided(picture):
    # Seven cells on in three steps: roll, roll, biped (free, but two modes) or crawl three times.
    weights = Weights(W_exp=0.0, W_goal=0.0, P={"biped": 0.0, "crawl": 2.0, "roll": 0.0})
    p = build_problem(picture("S......G"), horizon=3, must_reach=True, weights=weights)
    assert sorted(solve(p).modes) == [Mode.BIPED, Mode.ROLL, Mode.ROLL]
    assert solve(p).objective == 0.0
    one_way = replace(p, switch_cost={("biped", "roll"): 9.0})
    assert solve(one_way).modes == (Mode.ROLL, Mode.ROLL, Mode.BIPED)
    both = replace(p, switch_cost={("biped", "roll"): 9.0, ("roll", "biped"): 5.0})
    plan = solve(both)
    check(both, plan)
    assert plan.objective == -2.0  # a crawl in the biped's place: its changes are free
    every = build_problem(p.grid, horizon=3, must_reach=True, weights=weights, switch_cost=9.0)
    assert solve(every).objective == -9.0
    before = replace(every, last_mode=Mode.CRAWL)
    assert solve(before).objective == -11.0  # crawl, roll, roll: one change, one crawl


def test_a_state_in_another_mode_does_not_make_one_superfluous(picture):
    # On the first three cells the table thinks more of crawling to and fro than of the biped's
    # corridor ahead. A state there that crawls is no better than one that is in biped already.
    weights = Weights(W_exp=20.0, W_goal=0.0, P={"biped": 1.0, "crawl": 1.0})
    p = build_problem(
        picture("sssbbbb"),
        start=(0.25, 0.25),
        goal=(3.25, 0.25),
        horizon=6,
        modes=("crawl", "biped"),
        weights=weights,
        switch_cost=50.0,
    )
    plan = solve(p)
    check(p, plan)
    assert (plan.status, plan.objective) == ("optimal", 7 * 20.0 - 6)


def test_the_table_per_mode_is_exact_where_nothing_is_paid_for_seeing(rng, random_problem, dressed):
    changes = 0
    for n in range(40):
        p = small(dressed(rng, random_problem(rng, side=(2, 4), moving=bool(n % 2))))
        p = replace(p, weights=replace(p.weights, W_exp=0.0))
        if p.switch_cost is not None:
            assert mode_bounds(p, build_arcs(p))[1] == pytest.approx(truth_of(p))
            changes += np.isfinite(truth_of(p))
    assert changes > 10


def test_a_wall_hides_what_a_window_shows(picture):
    grid = picture(
        """
        .......
        ###.###
        S......
        """
    )
    weights = replace(FREE, P={"biped": 1.0})
    p = build_problem(grid, goal=(0.25, 0.25), horizon=3, modes=("biped",), weights=weights)
    near, far = replace(p, footprint=disc(1)), replace(p, footprint=disc(2))
    assert solve(near).objective == 20 * 6 - 3  # (0,0) to (3,0), its end and the window
    plan = solve(far)
    check(far, plan)
    assert plan.objective == 20 * 8 - 3  # from (3, 0) the cell behind the window too
    assert plan.cells[-1].tolist() == [3, 0]


@pytest.mark.parametrize("radius", [1, 2])
def test_an_open_room_is_seen_whole_and_proven_so(radius):
    n = 5
    grid = GridMap("room", 0.5, np.zeros(3), np.zeros((n, n), bool), np.full((n, n), 7))
    p = Problem(grid, (0, 0), (n - 1, n - 1), 8, footprint=disc(radius), early_stop=True)
    plan = solve(p, deadline_s=None)
    check(p, plan)
    assert plan.status == "optimal"
    assert plan.objective > 20 * n * n - 20


def test_the_same_dressed_problem_gives_the_same_plan_bit_for_bit(picture):
    p = build_problem(picture("S.....\n.##...\n.....G"), horizon=7, switch_cost=3, footprint=1.5)
    one, two = (solve(p, deadline_s=None, max_states=4000) for _ in range(2))
    assert one.cells.tobytes() == two.cells.tobytes() and one.modes == two.modes
    assert (one.status, one.objective, one.bound) == (two.status, two.objective, two.bound)
