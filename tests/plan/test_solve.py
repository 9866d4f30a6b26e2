"""The search finds the optimum, proves it, and says honestly when it cannot."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mobius.plan import (
    RECONSTRUCTED_WEIGHTS,
    NoPlan,
    Problem,
    Weights,
    build_problem,
    check,
    literal_problem,
    objective_of,
    reconstructed_map,
    solve,
)
from mobius.plan.check import broken_rule
from mobius.types import GridMap, Mode

MAX_LEAVES = 500


def legal_steps(p: Problem, t: int = 0) -> dict:
    cells = [(i, j) for i in range(p.grid.shape[0]) for j in range(p.grid.shape[1])]
    return {
        a: [(b, m) for b in cells for m in p.modes if not broken_rule(p, a, b, m, t)]
        for a in cells
        if not p.grid.blocked[a]
    }


def brute_force(p: Problem, steps: dict, *later: dict) -> float:
    """The best objective over every path there is, -inf if there is none.

    ``steps`` are the legal steps at time 0, ``later`` those at 1, 2, ...; the last ones hold on.
    """
    at = [steps, *later]
    best = -np.inf
    stack = [([p.start], [])]
    while stack:
        cells, modes = stack.pop()
        t = len(modes)
        if (t == p.horizon or p.early_stop) and (cells[-1] == p.goal or not p.must_reach):
            best = max(best, objective_of(p, cells, modes))
        if t < p.horizon:
            now = at[min(t, len(at) - 1)]
            stack += [([*cells, b], [*modes, m]) for b, m in now[cells[-1]]]
    return best


def largest_horizon(p: Problem, steps: dict) -> int:
    """The largest horizon <= 6 with few enough paths for brute force."""
    paths, total = {p.start: 1}, 0
    for T in range(7):
        total = total + sum(paths.values()) if p.early_stop else sum(paths.values())
        if total > MAX_LEAVES:
            return T - 1
        after: dict = {}
        for a, n in paths.items():
            for b, _ in steps[a]:
                after[b] = after.get(b, 0) + n
        paths = after
    return 6


@pytest.mark.parametrize("seed", range(8))
def test_the_search_agrees_with_brute_force(seed, random_problem):
    """Hundreds of small maps, every option drawn at random."""
    rng = np.random.default_rng(seed)
    feasible = 0
    for _ in range(40):
        p = random_problem(rng)
        steps = legal_steps(p)
        p = replace(p, horizon=largest_horizon(p, steps))
        truth = brute_force(p, steps)
        plan = solve(p, deadline_s=None, raise_infeasible=False)
        if truth == -np.inf:
            assert plan.status == "infeasible"
            continue
        check(p, plan)
        assert plan.status == "optimal"
        assert plan.objective == pytest.approx(truth, abs=1e-9)
        feasible += 1
    assert feasible > 15


@pytest.mark.parametrize("seed", range(60))
def test_the_search_agrees_with_brute_force_where_things_move_and_were_seen(seed, random_problem):
    p = random_problem(np.random.default_rng([seed, 77]), side=(3, 4), moving=True)
    steps = [legal_steps(p, t) for t in range(len(p.closed) + 1)]
    p = replace(p, horizon=max(largest_horizon(replace(p, closed=None), legal_steps(p)), 1))
    best = brute_force(p, *steps)
    plan = solve(p, deadline_s=None, raise_infeasible=False)
    if best == -np.inf:
        assert plan.status == "infeasible"
        with pytest.raises(NoPlan):
            solve(p)
        return
    check(p, plan)
    assert plan.status == "optimal"
    assert plan.objective == pytest.approx(best)


@pytest.mark.parametrize(
    ("n", "T", "best"),
    [
        # literal Table IV counts x_0 ... x_{T-1}; every step can be a crawl to a new cell and
        # the goal is within 2 T cells, so the optimum is 20 T - T.
        (20, 20, 380.0),
        (10, 10, 190.0),
        (20, 40, 760.0),
    ],
)
def test_the_literal_table_iv_is_proven_optimal(n, T, best):
    p = literal_problem(reconstructed_map(n), horizon=T, weights=RECONSTRUCTED_WEIGHTS)
    plan = solve(p)
    check(p, plan)
    assert (plan.status, plan.objective, plan.bound, plan.gap) == ("optimal", best, best, 0.0)


def test_counting_the_last_cell_adds_one_reward():
    p = literal_problem(reconstructed_map(), horizon=20, weights=RECONSTRUCTED_WEIGHTS)
    plan = solve(replace(p, count_terminal=True))
    assert (plan.status, plan.objective) == ("optimal", 400.0)


@pytest.mark.parametrize("connectivity", ["axis", "box", "diagonal"])
@pytest.mark.parametrize("count", ["endpoint", "sweep"])
@pytest.mark.parametrize("T", [15, 20, 40])
def test_the_reconstructed_map_is_solved_under_every_reading(T, count, connectivity):
    p = build_problem(
        reconstructed_map(),
        horizon=T,
        weights=RECONSTRUCTED_WEIGHTS,
        count=count,
        connectivity=connectivity,
    )
    plan = solve(p, deadline_s=None)
    check(p, plan)
    assert plan.status == "optimal"


def hard_problem() -> Problem:
    """A comb of dead ends, where the table's bound is far off."""
    n = 11
    blocked = np.zeros((n, n), dtype=bool)
    blocked[1::2, 1:] = True
    grid = GridMap("comb", 0.5, np.zeros(3), blocked, np.full((n, n), 7))
    return Problem(grid, (0, 0), (n - 1, n - 1), 60)


def test_a_spent_budget_leaves_a_checked_plan_with_an_honest_gap():
    p = hard_problem()
    plan = solve(p, deadline_s=None, max_states=2000)
    check(p, plan)
    assert plan.status == "feasible"
    assert plan.gap > 0
    better = solve(p, deadline_s=None, max_states=20_000)
    check(p, better)
    assert plan.objective <= better.objective <= better.bound <= plan.bound


def test_no_time_at_all_still_gives_a_plan():
    p = hard_problem()
    plan = solve(p, deadline_s=0.0)
    check(p, plan)
    assert plan.status in ("feasible", "optimal")


@pytest.mark.parametrize("make", [hard_problem, lambda: build_problem(reconstructed_map())])
def test_the_same_problem_gives_the_same_plan_bit_for_bit(make):
    one, two = (solve(make(), deadline_s=None, max_states=5000) for _ in range(2))
    assert one.cells.tobytes() == two.cells.tobytes()
    assert one.modes == two.modes
    assert (one.status, one.objective, one.bound) == (two.status, two.objective, two.bound)


def test_a_mission_is_a_shortest_path_that_turns_little(picture):
    grid = picture(
        """
        .......
        .......
        ....G..
        .......
        S......
        """
    )
    p = build_problem(grid, modes=("crawl",), must_reach=True)
    plan = solve(p)
    check(p, plan)
    assert plan.cells.tolist() in (
        [[0, 0], [2, 0], [4, 0], [4, 2]],
        [[0, 0], [0, 2], [2, 2], [4, 2]],
    )


def test_a_forced_mode_is_obeyed_and_the_change_is_on_common_ground(picture):
    plan = solve(build_problem(picture("S.cc.bb.G"), must_reach=True))
    by_cell = dict(zip([int(i) for i, _ in plan.cells], plan.modes, strict=False))
    assert all(by_cell[i] == Mode.CRAWL for i in (2, 3) if i in by_cell)
    assert [m for i, m in by_cell.items() if i in (5, 6)] == [Mode.BIPED, Mode.BIPED]
    assert 4 in by_cell  # the only cell on which crawl can hand over to biped


def test_a_roll_jumps_a_wall_only_where_end_points_are_all_that_is_checked(picture):
    wall = picture("S#.G")
    p = build_problem(wall, modes=("roll",), horizon=1, check="endpoint", must_reach=True)
    assert solve(p).modes == (Mode.ROLL,)
    p = build_problem(wall, modes=("roll",), horizon=1, must_reach=True)
    assert solve(p, raise_infeasible=False).status == "infeasible"


def test_early_stop_ends_at_the_goal_and_not_later(picture):
    p = build_problem(
        picture("S..G...."),
        modes=("crawl",),
        horizon=10,
        must_reach=True,
        early_stop=True,
        weights=Weights(W_exp=0.0),
    )
    plan = solve(p)
    check(p, plan)
    assert len(plan.modes) == 2
    assert plan.objective == -2.0


def test_cell_costs_push_the_path_off_the_wall(picture):
    grid = picture(
        """
        .........
        .........
        .........
        S.......G
        #########
        """
    )
    cost = np.zeros(grid.shape)
    cost[:, 1] = 3.0  # beside the wall
    options = dict(modes=("crawl",), must_reach=True, weights=Weights(W_exp=0.0))
    straight = solve(build_problem(grid, **options))
    assert set(straight.cells[:, 1]) == {1}
    p = build_problem(grid, slack=4, early_stop=True, cell_cost=cost, **options)
    plan = solve(p)
    check(p, plan)
    assert plan.cells[:, 1].max() == 2
    # up, 4 double steps, down: 6 steps at 1 point, and the goal's own 3. Straight on would
    # be 4 steps and 8 cells at 3 points each.
    assert plan.objective == -(6 + 3)
