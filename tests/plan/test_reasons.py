"""What is said of plans that end away from the goal."""

from __future__ import annotations

from mobius.plan import Weights, build_problem, solve
from mobius.plan.reasons import short_of_goal


def said(grid, **options) -> str | None:
    problem = build_problem(grid, **options)
    return short_of_goal(problem, solve(problem))


def test_of_a_plan_that_ends_at_the_goal_nothing(picture):
    assert said(picture("S...G"), horizon=2) is None


def test_too_few_steps_are_counted(picture):
    text = said(picture("S.......G"), horizon=1)
    assert text == (
        "the plan ends at (1.75, 0.25) m, 2.5 m from the goal, which takes at least 3 steps:"
        " horizon 1 is 2 too short"
    )


def test_a_goal_that_is_worth_less_than_seeing_more(picture):
    text = said(picture("G.S...."), horizon=2, weights=Weights(W_goal=0.0))
    assert text is not None and "pass must_reach=True" in text


def test_a_goal_out_of_reach_names_the_wall(picture):
    text = said(picture("S..#G"), horizon=2)
    assert text is not None
    assert "which cannot be reached: the wall in between (x 1.5 to 2, y 0 to 0.5 m)" in text
