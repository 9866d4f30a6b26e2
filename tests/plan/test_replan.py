"""Planning again and again: nothing is lost on the way, nothing is run into."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mobius.errors import PlanError
from mobius.plan import (
    RECONSTRUCTED_WEIGHTS,
    NoPlan,
    Planner,
    Problem,
    build_problem,
    check,
    objective_of,
    reconstructed_map,
    solve,
)
from mobius.types import GridMap, Mode


@pytest.fixture
def problem() -> Problem:
    return build_problem(reconstructed_map(), horizon=20, weights=RECONSTRUCTED_WEIGHTS)


def test_following_and_planning_again_earns_what_was_planned(problem):
    planner = Planner(problem)
    first = plan = planner.plan(None)
    cells, modes = [tuple(plan.cells[0])], []
    for _ in range(problem.horizon):
        cells.append(tuple(plan.cells[1]))
        modes.append(plan.modes[0])
        planner.update(at=plan.cells[1])
        plan = planner.plan(None)
        check(planner.problem, plan)
        assert plan.status == "optimal"
    assert len(plan.modes) == 0
    assert objective_of(problem, np.array(cells), modes) == pytest.approx(first.objective)


def test_what_was_seen_earns_nothing_any_more(problem):
    planner = Planner(problem, keep_horizon=True)
    plan = planner.plan(None)
    planner.update(at=plan.cells[3], steps=3)
    seen = planner.problem.seen
    assert seen[tuple(plan.cells[0])] and seen[tuple(plan.cells[2])]
    assert not seen[tuple(plan.cells[3])]  # it counts when it is left
    assert planner.problem.horizon == problem.horizon
    again = planner.plan(None)
    check(planner.problem, again)
    assert not any(
        (a == plan.cells[0]).all() for a in again.cells[1:]
    )  # there is enough that was never seen


def test_a_wall_that_appears_is_walked_round(problem):
    planner = Planner(problem)
    plan = planner.plan(None)
    wall = tuple(int(v) for v in plan.cells[4])
    planner.update(blocked={wall: True})
    again = planner.plan(None)
    check(planner.problem, again)
    assert wall not in {tuple(c) for c in again.cells}
    assert again.objective == solve(planner.problem, deadline_s=None).objective


def test_without_time_the_rest_of_the_last_plan_is_kept(problem):
    planner = Planner(problem)
    best = planner.plan(None)
    planner.update(at=best.cells[1])
    hurried = planner.plan(0.0, max_states=1)
    check(planner.problem, hurried)
    first = replace(problem, horizon=1, weights=replace(problem.weights, W_goal=0.0))
    gained = objective_of(replace(first, count_terminal=False), best.cells[:2], best.modes[:1])
    assert hurried.objective >= best.objective - gained - 1e-9


def test_a_broken_plan_is_repaired_into_an_incumbent(problem):
    planner = Planner(problem)
    plan = planner.plan(None)
    planner.update(at=plan.cells[1], blocked={tuple(int(v) for v in plan.cells[6]): True})
    incumbent = planner._incumbent()
    check(planner.problem, incumbent)
    assert (incumbent.cells[:4] == plan.cells[1:5]).all()  # its sound part is kept


def walls(n: int = 12, seed: int = 0) -> tuple[GridMap, np.ndarray]:
    """An open map, and where five things walk to and fro for 80 steps (80, n, n)."""
    rng = np.random.default_rng(seed)
    closed = np.zeros((80, n, n), dtype=bool)
    for _ in range(5):
        i, low, high = rng.integers(2, n), *sorted(rng.choice(n, 2, replace=False))
        path = [*range(low, high), *range(high, low, -1)]
        shift = rng.integers(len(path))
        for t in range(80):
            closed[t, i, path[(t + shift) % len(path)]] = True
    free = np.zeros((n, n), dtype=bool)
    return GridMap("open", 0.5, np.zeros(3), free, np.full((n, n), 7, np.uint8)), closed


@pytest.mark.parametrize("seed", range(4))
def test_nothing_that_moves_is_met(seed):
    grid, closed = walls(seed=seed)
    problem = Problem(grid, (0, 0), (11, 11), 8, allow_stay=True, closed=closed)
    planner = Planner(problem, keep_horizon=True)
    at = (0, 0)
    for t in range(40):
        planner.update(closed=closed[t:])
        plan = planner.plan(0.02)
        check(planner.problem, plan)
        low, high = np.minimum(at, plan.cells[1]), np.maximum(at, plan.cells[1])
        swept = np.zeros_like(closed[0])
        swept[low[0] : high[0] + 1, low[1] : high[1] + 1] = True
        swept[at] = plan.modes[0] is None
        assert not (swept & (closed[t] | closed[t + 1])).any()
        at = tuple(int(v) for v in plan.cells[1])
        planner.update(at=at)


def test_no_way_is_said_and_forgotten(problem):
    planner = Planner(problem)
    planner.plan(None)
    shut = replace(problem.grid, blocked=np.ones_like(problem.grid.blocked))
    with pytest.raises(PlanError):
        planner.update(grid=shut)
    with pytest.raises(PlanError, match="off the grid"):
        planner.update(blocked={(99, 0): True})
    around = {(i, j): True for i in range(4) for j in range(4) if (i, j) != (0, 0)}
    planner.update(blocked=around)
    with pytest.raises(NoPlan, match="shut in"):
        planner.plan()


def test_following_with_changes_of_mode_and_a_footprint_earns_what_was_planned(picture):
    p = build_problem(
        picture("S.....\n.##...\n..b...\n.....G"),
        horizon=5,
        switch_cost=4.0,
        last_mode="roll",
        footprint=1,
    )
    planner = Planner(p)
    first = plan = planner.plan(None)
    assert first.status == "optimal"
    cells, modes = [tuple(plan.cells[0])], []
    for _ in range(p.horizon):
        cells.append(tuple(plan.cells[1]))
        modes.append(plan.modes[0])
        planner.update(at=plan.cells[1])
        assert planner.problem.last_mode is modes[-1]
        plan = planner.plan(None)
        check(planner.problem, plan)
        assert plan.status == "optimal"
    assert objective_of(p, np.array(cells), modes) == pytest.approx(first.objective)


def test_the_mode_it_is_in_may_be_told(picture):
    p = build_problem(picture("S...G"), horizon=2, must_reach=True, switch_cost=4.0)
    planner = Planner(p)
    best = planner.plan(None).objective
    planner.update(mode="roll")
    plan = planner.plan(None)
    assert plan.modes[0] is not Mode.ROLL
    assert plan.objective == best - 4.0
