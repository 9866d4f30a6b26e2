"""From metres to a problem, and what is said when a place will not do."""

from __future__ import annotations

import numpy as np
import pytest

from mobius.errors import InvalidInput, MapError, PlanError
from mobius.plan import NoPlan, build_problem, solve
from mobius.types import GridMap, Mode

ROOM = """
.....#....
.S...#..G.
..........
.....#....
"""

SPLIT = """
S..#..
...#..
...#.G
"""


def test_places_come_from_the_map_or_the_caller_in_metres(picture):
    p = build_problem(picture(ROOM), goal=(4.9, 0.1), horizon=9)
    assert p.start == (1, 2)
    assert p.goal == (9, 0)


def test_places_follow_a_shifted_and_turned_grid(picture):
    flat = picture(ROOM)
    turned = GridMap("turned", 0.5, (7.0, -2.0, 0.5), flat.blocked, flat.allowed)
    at = turned.center_of([(1, 2), (8, 2)])
    p = build_problem(turned, start=at[0], goal=at[1])
    assert (p.start, p.goal) == ((1, 2), (8, 2))


def test_the_default_horizon_is_the_fewest_steps(picture):
    # 7 cells right and down round the wall's gap: 1 down, 7 right, 1 up = 9 cells. Biped: 9
    # steps. Crawl: 1 + 4 + 1 = 6.
    assert build_problem(picture(ROOM), modes=("biped",)).horizon == 9
    assert build_problem(picture(ROOM), modes=("crawl",)).horizon == 6
    assert build_problem(picture(ROOM), modes=("crawl",), slack=3).horizon == 9


def test_start_on_the_goal_is_a_plan_of_no_steps(picture):
    p = build_problem(picture(ROOM), goal=(0.75, 1.25), must_reach=True)
    plan = solve(p)
    assert p.horizon == 0
    assert plan.cells.tolist() == [[1, 2]]
    assert plan.modes == ()
    assert (plan.status, plan.objective) == ("optimal", 20.0)


@pytest.mark.parametrize(
    ("places", "error", "message"),
    [
        (
            {"start": (2.6, 1.3)},
            MapError,
            "drawing: start (2.6, 1.3) m lies in an obstacle; nearest free cell centre"
            " (2.25, 1.25) m",
        ),
        (
            {"goal": (12.0, 3.5)},
            MapError,
            "drawing: goal (12, 3.5) m lies outside the map, which covers x 0 to 5, y 0 to 2 m",
        ),
        (
            {"goal": (1.0, float("nan"))},
            InvalidInput,
            "goal: expected two finite numbers x y [m], got [1.0, nan]",
        ),
        (
            {"slack": 1, "horizon": 8},
            PlanError,
            "slack only adds to the smallest horizon; leave out horizon or slack",
        ),
        ({"slack": -1}, InvalidInput, "slack: expected a number of steps >= 0, got -1"),
    ],
)
def test_a_place_that_will_not_do_is_named_with_a_better_one(picture, places, error, message):
    with pytest.raises(error) as caught:
        build_problem(picture(ROOM), **places)
    assert str(caught.value) == message


def test_a_map_without_a_goal_asks_for_one(picture):
    with pytest.raises(PlanError, match="names no goal; give one"):
        build_problem(picture("..\nS."))


def test_ground_that_no_mode_may_use_is_not_a_place(picture):
    with pytest.raises(MapError, match=r"is not open to roll; nearest free cell centre \(0.75"):
        build_problem(picture("S.b"), goal=(1.25, 0.25), modes=("roll",))
    with pytest.raises(MapError, match="no cell of the map is free for roll"):
        build_problem(picture("bbb"), start=(0.25, 0.25), goal=(1.25, 0.25), modes=("roll",))


def test_a_goal_behind_a_wall_is_closed_off(picture):
    with pytest.raises(NoPlan) as caught:
        build_problem(picture(SPLIT))
    assert str(caught.value) == (
        "drawing: goal (2.75, 0.25) m lies in an area closed off from the start (0.25, 1.25) m;"
        " the wall in between (x 1.5 to 2, y 0 to 1.5 m) is 1 cell thick at (1.75, 0.75) m;"
        " nearest cell that can be reached (1.25, 0.25) m"
    )


def test_a_goal_that_another_mode_reaches_names_the_mode(picture):
    with pytest.raises(NoPlan) as caught:
        build_problem(picture("S.bb.G"), modes=("crawl",))
    assert str(caught.value) == (
        "drawing: goal (2.75, 0.25) m cannot be reached from the start (0.25, 0.25) m with"
        " crawl alone; add mode 'biped' (5 steps)"
    )


def test_too_short_a_horizon_names_the_smallest(picture):
    p = build_problem(picture(ROOM), modes=("crawl",), horizon=5, must_reach=True)
    with pytest.raises(NoPlan, match="smallest horizon is 6") as caught:
        solve(p)
    assert caught.value.smallest_horizon == 6
    solve(build_problem(picture(ROOM), modes=("crawl",), horizon=6, must_reach=True))


def test_a_horizon_of_the_wrong_parity_says_what_would_do(picture):
    p = build_problem(picture("S.G"), modes=("biped",), horizon=3, must_reach=True)
    with pytest.raises(NoPlan) as caught:
        solve(p)
    assert str(caught.value) == (
        "no path of exactly 3 steps ends at the goal (the shortest has 2);"
        " pass early_stop=True or use horizon 4"
    )


def test_a_robot_that_cannot_move_is_told_so(picture):
    p = build_problem(picture("S#G"), horizon=2)
    with pytest.raises(NoPlan, match="shut in"):
        solve(p)


def test_an_infeasible_problem_can_also_be_returned(picture):
    p = build_problem(picture(SPLIT), horizon=9, must_reach=True)
    plan = solve(p, raise_infeasible=False)
    assert plan.status == "infeasible"
    assert plan.cells.shape == (0, 2)
    assert plan.objective == plan.bound == -np.inf


def test_mode_names_and_modes_mean_the_same(picture):
    a = build_problem(picture(ROOM), modes=("crawl",))
    b = build_problem(picture(ROOM), modes=(Mode.CRAWL,))
    assert a.modes == b.modes


def test_one_number_prices_every_change_of_mode_and_a_radius_is_a_footprint(picture):
    p = build_problem(picture("S..G"), horizon=1, switch_cost=3, last_mode="crawl", footprint=1)
    assert set(p.switch_cost.values()) == {3.0} and len(p.switch_cost) == 6
    assert p.switch_points(p.last_mode, Mode.ROLL) == 3.0
    assert p.switch_points(p.last_mode, Mode.CRAWL) == p.switch_points(None, Mode.ROLL) == 0.0
    assert len(p.footprint) == 5
    free = build_problem(picture("S..G"), horizon=1, switch_cost=0.0, footprint=0)
    assert free.switch_cost is None and free.footprint is None
