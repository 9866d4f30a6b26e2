"""Bad input: an error in one line with what was expected, or a proof that says what is missing."""

from __future__ import annotations

import numpy as np
import pytest

from mobius.errors import InvalidInput, MapError, MobiusError, PlanError
from mobius.plan import NoPlan, Planner, Problem, Weights, build_problem, solve
from mobius.types import GridMap

NAN, INF = float("nan"), float("inf")


def grid_of(blocked) -> GridMap:
    blocked = np.asarray(blocked, dtype=bool)
    return GridMap("small", 0.5, np.zeros(3), blocked, np.full(blocked.shape, 7))


def message(error: type[MobiusError], work) -> str:
    """The message of the error that ``work`` raises; one line."""
    with pytest.raises(error) as caught:
        work()
    text = str(caught.value)
    assert text and "\n" not in text
    return text


@pytest.mark.parametrize("what", ["start", "goal"])
def test_a_blocked_place_names_the_nearest_free_cell(picture, what):
    text = message(MapError, lambda: build_problem(picture("S.##.G"), **{what: (1.2, 0.25)}))
    assert text == (
        f"drawing: {what} (1.2, 0.25) m lies in an obstacle; nearest free cell centre"
        " (0.75, 0.25) m"
    )


def test_a_blocked_cell_is_refused_by_the_problem_itself():
    grid = grid_of([[0, 1, 0]])
    assert "start cell (0, 1)" in message(PlanError, lambda: Problem(grid, (0, 1), (0, 0), 2))
    assert "goal cell (0, 1)" in message(PlanError, lambda: Problem(grid, (0, 0), (0, 1), 2))


ROOM = """
S......
..####.
..#.G#.
..####.
.......
"""


def test_a_walled_in_goal_names_the_wall_and_where_it_is_thinnest(picture):
    text = message(NoPlan, lambda: build_problem(picture(ROOM)))
    assert "the wall in between (x 1 to 3, y 0.5 to 2 m) is 1 cell thick at" in text
    assert "nearest cell that can be reached" in text


@pytest.mark.parametrize("horizon", [0, 3, 30])
def test_a_walled_in_goal_is_proven_whatever_the_horizon(picture, horizon):
    problem = build_problem(picture(ROOM), horizon=horizon, must_reach=True)
    assert "the wall in between" in message(NoPlan, lambda: solve(problem))
    plan = solve(problem, raise_infeasible=False)
    assert plan.status == "infeasible" and len(plan.cells) == 0


def test_regions_that_force_different_modes_leave_no_mode_where_they_overlap(picture):
    text = message(NoPlan, lambda: build_problem(picture("S.x.G")))
    assert "at (1.25, 0.25) m, allows no mode: regions that force different modes overlap" in text
    text = message(MapError, lambda: build_problem(picture("S.x.G"), start=(1.25, 0.25)))
    assert "allows no mode: regions that force different modes overlap there" in text


def test_ground_where_the_mode_cannot_change_is_named(picture):
    text = message(NoPlan, lambda: build_problem(picture("SbbccG"), modes=("biped", "crawl")))
    assert "biped only at (1.25, 0.25) m and crawl only at (1.75, 0.25) m" in text
    assert "changes its mode only on ground that allows both" in text


def test_ground_for_another_mode_is_named_where_no_mode_can_be_added(picture):
    weights = Weights(P={"crawl": 1.0})
    text = message(
        NoPlan, lambda: build_problem(picture("S.bb.G"), modes=("crawl",), weights=weights)
    )
    assert "the ground in between, at (1.25, 0.25) m, allows biped only" in text


def test_steps_that_never_land_on_the_goal_are_not_blamed_on_a_wall(picture):
    weights = Weights(P={"roll": 1.0})
    text = message(
        NoPlan, lambda: build_problem(picture("S...G"), modes=("roll",), weights=weights)
    )
    assert "no wall is in between, but steps of roll" in text


@pytest.mark.parametrize(("horizon", "missing"), [(0, 3), (1, 2), (2, 1)])
def test_too_short_a_horizon_says_how_many_steps_are_missing(picture, horizon, missing):
    problem = build_problem(picture("S.......G"), horizon=horizon, must_reach=True)
    text = message(NoPlan, lambda: solve(problem))
    assert f"{missing} more; smallest horizon is 3" in text


@pytest.mark.parametrize("value", [NAN, INF, -INF, -1.0, 1e300, None, "dear"])
@pytest.mark.parametrize("name", ["W_exp", "W_goal"])
def test_a_weight_that_is_no_number_from_zero_on_is_named(name, value):
    text = message(InvalidInput, lambda: Weights(**{name: value}))
    assert text.startswith(f"Weights.{name}: expected a number >= 0")
    assert text.endswith(f"got {value}")


@pytest.mark.parametrize("value", [NAN, INF, -0.5, None, "dear"])
def test_a_penalty_that_is_no_number_from_zero_on_is_named(value):
    text = message(InvalidInput, lambda: Weights(P={"crawl": value}))
    assert text.startswith("Weights.P[crawl]: expected a number >= 0")


def test_a_penalty_for_an_unknown_mode_and_a_mode_without_penalty(picture):
    assert "Did you mean 'crawl'?" in message(MobiusError, lambda: Weights(P={"crwl": 1.0}))
    weights = Weights(P={"crawl": 1.0})
    text = message(PlanError, lambda: build_problem(picture("S.G"), weights=weights))
    assert "add P['biped']" in text


@pytest.mark.parametrize("cost", [np.full((3, 1), NAN), -np.ones((3, 1)), np.zeros((1, 3))])
def test_cell_costs_must_be_finite_from_zero_on_and_fit_the_map(picture, cost):
    text = message(InvalidInput, lambda: build_problem(picture("S.G"), cell_cost=cost))
    assert text.startswith("Problem.cell_cost: expected")


@pytest.mark.parametrize("shape", [(0, 0), (0, 3), (3, 0)])
def test_an_empty_map_is_told_as_such(shape):
    text = message(
        MapError, lambda: build_problem(grid_of(np.zeros(shape)), start=(0, 0), goal=(0, 0))
    )
    assert text == f"small: expected a map of at least 1 x 1 cells, got {shape[0]} x {shape[1]}"


def test_a_map_without_a_free_cell_is_told_as_such():
    text = message(
        MapError, lambda: build_problem(grid_of(np.ones((3, 3))), start=(0.2, 0.2), goal=(1, 1))
    )
    assert "no cell of the map is free" in text


def on_one_cell(**options) -> Problem:
    return build_problem(grid_of([[0]]), start=(0.25, 0.25), goal=(0.25, 0.25), **options)


@pytest.mark.parametrize("options", [{}, {"horizon": 5, "early_stop": True}])
def test_on_a_map_of_one_cell_the_plan_is_to_be_there(options):
    plan = solve(on_one_cell(**options))
    assert plan.status == "optimal" and plan.cells.tolist() == [[0, 0]]


def test_on_a_map_of_one_cell_no_step_is_possible_but_resting_is():
    text = message(NoPlan, lambda: solve(on_one_cell(horizon=5)))
    assert "the map has no other cell" in text and "allow_stay=True" in text
    assert solve(on_one_cell(horizon=5, allow_stay=True)).status == "optimal"


def test_a_robot_in_a_pocket_is_told_which_wall(picture):
    problem = build_problem(picture("..#\n.S#\n###"), goal=(0.75, 0.75), horizon=3, modes=("roll",))
    text = message(NoPlan, lambda: solve(problem))
    assert "the robot is shut in (walls such as the one at (1.25, 0.75) m" in text


@pytest.mark.parametrize("horizon", [NAN, INF, 2.5, -1, 10**9])
def test_a_horizon_that_is_no_number_of_steps_is_refused(picture, horizon):
    assert "horizon" in message(MobiusError, lambda: build_problem(picture("S.G"), horizon=horizon))


@pytest.mark.parametrize("slack", [NAN, -1, 0.5])
def test_slack_that_is_no_number_of_steps_is_refused(picture, slack):
    message(InvalidInput, lambda: build_problem(picture("S.G"), slack=slack))


@pytest.mark.parametrize("start", [(NAN, 0.2), (INF, 0.2), (1e300, 0.2), (0.1, 0.2, 0.3)])
def test_a_place_that_is_no_point_is_refused_without_a_warning(picture, start, recwarn):
    text = message(InvalidInput, lambda: build_problem(picture("S.G"), start=start))
    assert text.startswith("start: expected two finite numbers x y [m]")
    assert not recwarn.list


def test_no_modes_at_all_are_told_as_such(picture):
    assert "no modes to plan with" in message(
        PlanError, lambda: build_problem(picture("S.G"), modes=())
    )


@pytest.mark.parametrize("deadline", [NAN, -1.0, -INF, "soon"])
def test_a_deadline_that_is_no_time_is_refused(picture, deadline):
    problem = build_problem(picture("S...G"), horizon=4)
    planner = Planner(problem)
    before = planner.plan(None)
    for work in (lambda: solve(problem, deadline_s=deadline), lambda: planner.plan(deadline)):
        text = message(InvalidInput, work)
        assert text == (
            f"deadline_s: expected seconds >= 0, or None for no deadline, got {deadline}"
        )
    assert planner.plan(0).objective == before.objective


def test_a_deadline_that_never_comes_is_none():
    """A problem that goes through every search: an infinite time left once overflowed there."""
    blocked = np.zeros((7, 7), dtype=bool)
    blocked[[1, 3, 4], [2, 3, 0]] = True
    problem = Problem(grid_of(blocked), (0, 0), (0, 0), 24, must_reach=True)
    ever, none = (solve(problem, deadline_s=s, max_states=20_000) for s in (INF, None))
    assert ever.cells.tolist() == none.cells.tolist()
    assert (ever.objective, ever.bound) == (none.objective, none.bound)
