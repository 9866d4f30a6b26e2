"""The bounds bound, and mean what they say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mobius.plan import Problem, Weights, bounds, build_problem, solve
from mobius.plan.bounds import (
    UNREACHED,
    build_arcs,
    capacity_bound,
    dp_bound,
    shortest_steps,
    steps_from,
)
from mobius.plan.check import broken_rule
from mobius.types import Mode

LINE = "S..G"
CRAWL_ONE = Weights(W_exp=20.0, W_goal=20.0, P={"crawl": 1.0})


def test_the_table_of_a_corridor_by_hand(picture):
    # Crawl in S..G (cells 0..3), goal 3, two steps, all cells count on the first visit only
    # in truth, on every visit in the table. Ending on c is worth 20 - 20 (3 - c)^2:
    #   U_0 = [-160, -60, 0, 20]
    # One step (20 per counted cell, 1 for the step):
    #   U_1(3): to 2: 20 - 1 + 0 = 19; to 1 over 2: 40 - 1 - 60 = -21      -> 19
    #   U_1(2): to 3: 20 - 1 + 20 = 39                                      -> 39
    #   U_1(1): over 2 to 3: 40 - 1 + 20 = 59                               -> 59
    #   U_1(0): to 1: -41; over 1 to 2: 40 - 1 + 0 = 39                     -> 39
    # U_2(0): to 1: 19 + U_1(1) = 78; over 1 to 2: 39 + U_1(2) = 78         -> 78
    p = build_problem(picture(LINE), modes=("crawl",), horizon=2, weights=CRAWL_ONE)
    arcs = build_arcs(p)
    U = dp_bound(p, arcs)
    cells = [arcs.flat((i, 0)) for i in range(4)]
    assert U[0, cells].tolist() == [-160, -60, 0, 20]
    assert U[1, cells].tolist() == [39, 59, 39, 19]
    assert U[2, cells[0]] == 78


def test_a_table_made_layer_by_layer_is_that_made_step_by_step(
    rng, random_problem, dressed, monkeypatch
):
    for n in range(60):
        p = replace(dressed(rng, random_problem(rng)), horizon=n % 7)
        arcs = build_arcs(p)
        at_once = dp_bound(p, arcs)
        with monkeypatch.context() as m:
            m.setattr(bounds, "SMALL", 0)
            assert np.array_equal(dp_bound(p, arcs), at_once)
            near = dp_bound(p, arcs, window=True)
        start = arcs.flat(p.start)
        assert near[p.horizon, start] == at_once[p.horizon, start]


def test_the_search_and_the_checker_agree_on_every_step(rng, random_problem):
    """Two implementations of legality: shifted masks, and the rules one by one."""
    agreed = 0
    for _ in range(20):
        p = random_problem(rng)
        arcs = build_arcs(p)
        nx, ny = p.grid.shape
        legal = {
            ((i, j), arcs.cell(arcs.flat((i, j)) + arcs.offset[a]), act.mode)
            for a, act in enumerate(p.actions)
            for i in range(nx)
            for j in range(ny)
            if arcs.valid[a, arcs.flat((i, j))]
        }
        free = [(i, j) for i in range(nx) for j in range(ny) if not p.grid.blocked[i, j]]
        every = [(i, j) for i in range(-3, nx + 3) for j in range(-3, ny + 3)]
        by_rule = {
            (a, b, m) for a in free for b in every for m in Mode if not broken_rule(p, a, b, m)
        }
        assert legal == by_rule
        agreed += len(legal)
    assert agreed > 500


def test_fewest_steps_forward_and_backward_meet(rng, random_problem):
    for _ in range(30):
        p = random_problem(rng)
        arcs = build_arcs(p)
        there = steps_from(p, arcs)[arcs.flat(p.goal)]
        back = shortest_steps(p, arcs)[arcs.flat(p.start)]
        assert there == back


def test_fewest_steps_are_those_after_which_the_table_has_a_plan(rng, random_problem):
    for _ in range(30):
        p = replace(random_problem(rng), must_reach=True, early_stop=True, horizon=8)
        arcs = build_arcs(p)
        reachable = np.isfinite(dp_bound(p, arcs))
        fewest = shortest_steps(p, arcs)
        for k in range(p.horizon + 1):
            assert (reachable[k, arcs.free] == (fewest[arcs.free] <= k)).all()


def test_a_wall_cannot_be_reached(picture):
    p = Problem(picture("..#.."), (0, 0), (4, 0), 3)
    arcs = build_arcs(p)
    assert shortest_steps(p, arcs)[arcs.flat((0, 0))] == UNREACHED


def test_few_cells_cap_the_reward_of_many_steps(picture):
    # 5 cells, 30 steps: no plan sees more than 5 cells, whatever the table says.
    p = build_problem(
        picture("S...G"), modes=("crawl",), horizon=30, weights=CRAWL_ONE, must_reach=True
    )
    arcs = build_arcs(p)
    assert capacity_bound(p, arcs) == 5 * 20 - 30
    assert dp_bound(p, arcs)[30, arcs.flat(p.start)] > 500


def test_capacity_counts_cells_that_are_only_ever_passed(picture):
    # Two double crawls from end to end: cells 1 and 3 are seen, though no path of two steps
    # stops on them.
    p = build_problem(picture("S...G"), modes=("crawl",), weights=CRAWL_ONE, must_reach=True)
    assert p.horizon == 2
    assert capacity_bound(p, build_arcs(p)) == 5 * 20 - 2 == solve(p).objective


def test_no_plan_beats_either_bound(rng, random_problem):
    seen = 0
    for _ in range(60):
        p = replace(random_problem(rng), horizon=7)
        plan = solve(p, deadline_s=None, max_states=3000, raise_infeasible=False)
        if plan.status == "infeasible":
            continue
        arcs = build_arcs(p)
        tol = 1e-9 * max(1.0, abs(plan.objective))
        assert plan.objective <= capacity_bound(p, arcs) + tol
        assert plan.objective <= dp_bound(p, arcs)[7, arcs.flat(p.start)] + tol
        seen += 1
    assert seen > 20


def test_capacity_counts_only_what_is_in_reach(picture):
    # 2 biped steps that end at the goal beside the start see those two cells and one more
    # stop; the ten cells to the right are out of reach.
    p = build_problem(
        picture("SG.........."),
        modes=("biped",),
        horizon=3,
        weights=Weights(P={"biped": 1.0}),
        must_reach=True,
    )
    assert capacity_bound(p, build_arcs(p)) == 3 * 20 - 3


@pytest.mark.parametrize("option", [{"cell_cost": np.full((4, 1), 2.0)}, {"early_stop": True}])
def test_options_enter_the_table(picture, option):
    kw = dict(modes=("crawl",), horizon=2, weights=CRAWL_ONE)
    p = build_problem(picture(LINE), **kw)
    q = build_problem(picture(LINE), **kw, **option)
    arcs = build_arcs(q)
    U = dp_bound(q, arcs)
    if option.keys() == {"cell_cost"}:
        # both best paths enter three cells: 78 - 3 * 2
        assert U[2, arcs.flat((0, 0))] == 72
    else:
        # from the goal itself, stopping at once (20) beats walking off and back only if the
        # table did not pay revisits: 19 + 39 = 58 is still its bound
        assert U[1, arcs.flat((3, 0))] == 20
        assert (dp_bound(p, build_arcs(p)) <= U).all()


def test_a_windowed_table_is_the_table_wherever_the_start_gets(rng, random_problem):
    left_out = 0
    for _ in range(30):
        p = replace(random_problem(rng, side=(3, 14), moving=True), horizon=4)
        arcs = build_arcs(p)
        whole, windowed = dp_bound(p, arcs), dp_bound(p, arcs, window=True)
        steps = steps_from(p, arcs)
        for k in range(p.horizon + 1):
            reached = steps <= p.horizon - k
            assert (windowed[k, reached] == whole[k, reached]).all()
        assert (windowed <= whole).all()
        left_out += np.isfinite(whole).sum() - np.isfinite(windowed).sum()
    assert left_out > 0
