"""Planning where a roll lands by chance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mobius.errors import PlanError
from mobius.plan import (
    NoPlan,
    Problem,
    RollRisk,
    Weights,
    build_problem,
    check,
    plan_under_risk,
    risky_value,
    solve,
)
from mobius.plan.bounds import build_arcs, dp_bound
from mobius.types import Mode

RISK = RollRisk(0.2, 0.5, 0.3, 0.1, 7.0)
SURE = RollRisk(0.0, 1.0, 0.0, 0.0, 0.0)


def test_without_risk_the_table_is_that_of_the_bound(rng, random_problem):
    for _ in range(15):
        p = replace(random_problem(rng, moving=True), horizon=5)
        arcs = build_arcs(p)
        U = dp_bound(p, arcs).reshape(6, -1, arcs.stride)[:, 3:-3, 3:-3]
        np.testing.assert_allclose(risky_value(p, SURE)[0], U, rtol=1e-12)


def expectimax(p: Problem, risk: RollRisk, k: int, cell: tuple, memo: dict) -> float:
    """V_k(cell) cell by cell, for axis steps, whole-step checks and nothing that moves."""
    if (k, cell) in memo:
        return memo[k, cell]
    d2 = (cell[0] - p.goal[0]) ** 2 + (cell[1] - p.goal[1]) ** 2
    stop = -np.inf if p.must_reach and d2 else -p.weights.W_goal * d2
    stop += p.weights.W_exp * p.count_terminal * p.pays[cell]
    values = [stop] if k == 0 or p.early_stop else []
    for action in p.actions if k else ():
        sign = np.sign(action.d)
        ends = [(abs(sum(action.d)), 1.0)]
        if action.mode is Mode.ROLL:
            ends = [(2, risk.p_two), (3, risk.p_three), (4, risk.p_four)]
        way = [tuple((cell + n * sign).tolist()) for n in range(max(n for n, _ in ends) + 1)]
        open_ = [
            p.grid.holds(c) and not p.grid.blocked[c] and p.grid.allowed[c] & action.mode.bit
            for c in way
        ]
        if not all(open_):
            continue
        q = p.weights.W_exp * p.pays[cell] - p.weights.P[action.mode]
        if action.mode is Mode.ROLL:
            q -= risk.p_bad * risk.penalty
        elif p.count == "sweep":
            q += p.weights.W_exp * sum(p.pays[c] for c in way[1:-1])
        for n, chance in ends:
            q += chance * expectimax(p, risk, k - 1, way[n], memo)
            q -= chance * sum(p.costs[c] for c in way[1 : n + 1])
        values.append(q)
    memo[k, cell] = max(values, default=-np.inf)
    return memo[k, cell]


def test_the_table_is_the_expectation_worked_out_cell_by_cell(rng, random_problem):
    finite = 0
    for _ in range(12):
        p = random_problem(rng, side=(4, 7))
        p = replace(p, horizon=4, connectivity="axis", check="swept", allow_stay=False)
        V, _ = risky_value(p, RISK)
        memo: dict = {}
        for cell in map(tuple, np.argwhere(~p.grid.blocked).tolist()):
            assert V[(4, *cell)] == pytest.approx(expectimax(p, RISK, 4, cell, memo))
            finite += np.isfinite(V[(4, *cell)])
    assert finite > 100


@pytest.fixture
def corridor(picture) -> Problem:
    weights = Weights(W_exp=0.0, W_goal=1.0, P={"biped": 3.0, "crawl": 2.0, "roll": 1.0})
    grid = picture(".................\nS...............G")
    return build_problem(grid, horizon=8, weights=weights, must_reach=True, early_stop=True)


@pytest.mark.parametrize("W_exp", [0.0, 0.5])
def test_many_runs_earn_what_the_table_expects(corridor, W_exp):
    p = replace(corridor, weights=replace(corridor.weights, W_exp=W_exp))
    plan, rng = plan_under_risk(p, RISK), np.random.default_rng(3)
    runs = [plan.play(rng, aware=False) for _ in range(800)]
    paid = np.array([run.paid for run in runs])
    error = paid.std() / np.sqrt(len(paid))
    assert error > 0
    assert abs(paid.mean() - plan.expected) < 4 * error
    points = np.array([run.points for run in runs])
    assert (points <= paid + 1e-9).all()
    if W_exp == 0:
        np.testing.assert_allclose(points, paid)
    assert any(run.bad for run in runs)


def test_a_run_always_ends_at_the_goal_and_never_in_a_wall(corridor):
    blocked = np.zeros(corridor.grid.shape, bool)
    blocked[9, 1] = True
    p = replace(corridor, grid=replace(corridor.grid, blocked=blocked))
    plan, rng, rolled = plan_under_risk(p, RISK), np.random.default_rng(1), 0
    for _ in range(200):
        run = plan.play(rng)
        assert run.cells[-1] == p.goal and len(run.modes) <= p.horizon
        for a, b, mode in zip(run.cells, run.cells[1:], run.modes, strict=False):
            assert not blocked[b]
            if mode is Mode.ROLL:
                rolled += 1
                (axis,) = np.flatnonzero(np.subtract(a, b))
                far = list(a)
                far[axis] += 4 * int(np.sign(b[axis] - a[axis]))
                assert p.grid.holds(far)
                low, high = np.minimum(a, far), np.maximum(a, far)
                assert not blocked[low[0] : high[0] + 1, low[1] : high[1] + 1].any()
    assert rolled > 100


def test_risk_makes_it_walk_where_it_would_roll(corridor):
    assert Mode.ROLL in plan_under_risk(corridor, RISK).nominal.modes
    grave = replace(RISK, p_bad=0.5, penalty=50.0)
    assert Mode.ROLL not in plan_under_risk(corridor, grave).nominal.modes


def test_looking_at_what_was_seen_sees_more_than_the_table_alone(picture):
    grid = picture("........\n........\n........\n........\n........\nS......G")
    p = build_problem(grid, horizon=12)
    plan = plan_under_risk(p, RollRisk())
    aware = [plan.play(np.random.default_rng(n)).points for n in range(20)]
    table = [plan.play(np.random.default_rng(n), aware=False).points for n in range(20)]
    assert np.mean(aware) > np.mean(table)
    assert plan.expected >= np.mean(aware)


def test_the_nominal_plan_obeys_every_rule_and_is_no_better_than_the_best(picture):
    p = build_problem(picture("S.....\n.##...\n......\n.....G"), horizon=7)
    nominal = plan_under_risk(p, RollRisk()).nominal
    check(p, nominal)
    assert nominal.objective <= solve(p).objective <= nominal.bound


def test_what_cannot_be_had_for_certain_is_said(picture):
    p = build_problem(picture("S..G"), modes=("roll",), horizon=1, must_reach=True)
    assert plan_under_risk(p, SURE).nominal.modes == (Mode.ROLL,)
    with pytest.raises(NoPlan, match="for certain in 1 steps"):
        plan_under_risk(p, RISK)


@pytest.mark.parametrize("option", [{"switch_cost": 3.0}, {"footprint": 2}])
def test_an_option_it_cannot_state_is_named(picture, option):
    p = build_problem(picture("S..G"), horizon=2, **option)
    with pytest.raises(PlanError, match=f"cannot state Problem.{next(iter(option))}"):
        plan_under_risk(p, RISK)


def test_places_outside_the_table_are_named(corridor):
    plan = plan_under_risk(corridor, RISK)
    assert plan.action_at(0, corridor.goal) is None
    with pytest.raises(PlanError, match="no entry for 9 steps"):
        plan.action_at(9, (0, 0))
    with pytest.raises(PlanError, match="no policy keeps every rule in 1 steps"):
        plan.action_at(1, (0, 0))
