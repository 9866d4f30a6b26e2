"""Steps of Table IV (8)-(10) under the three readings of its axes."""

from __future__ import annotations

import pytest

from mobius.plan.actions import actions_for
from mobius.types import Mode

BIPED, CRAWL, ROLL = Mode.BIPED, Mode.CRAWL, Mode.ROLL


def steps(mode: Mode, connectivity: str, **options: bool) -> set[tuple[int, int]]:
    return {a.d for a in actions_for((mode,), connectivity, **options)}


def find(mode: Mode, d: tuple[int, int], connectivity: str = "box"):
    return next(a for a in actions_for((mode,), connectivity) if a.d == d)


@pytest.mark.parametrize("connectivity", ["axis", "box", "diagonal"])
@pytest.mark.parametrize("mode", [BIPED, CRAWL, ROLL])
def test_steps_are_symmetric_under_quarter_turns_and_mirrors(mode, connectivity):
    d = steps(mode, connectivity)
    assert {(-y, x) for x, y in d} == d
    assert {(-x, y) for x, y in d} == d


def test_axis_steps_are_one_one_or_two_and_exactly_three_cells():
    assert steps(BIPED, "axis") == {(1, 0), (-1, 0), (0, 1), (0, -1)}
    assert steps(CRAWL, "axis") == steps(BIPED, "axis") | {(2, 0), (-2, 0), (0, 2), (0, -2)}
    assert steps(ROLL, "axis") == {(3, 0), (-3, 0), (0, 3), (0, -3)}


def test_diagonal_steps_move_both_axes_and_box_adds_the_resting_axis():
    assert steps(BIPED, "diagonal") == {(1, 1), (1, -1), (-1, 1), (-1, -1)}
    assert len(steps(CRAWL, "diagonal")) == 16
    # box: 5 x 5 offsets of crawl and 3 x 3 of roll, without resting
    assert len(steps(CRAWL, "box")) == 24
    assert steps(ROLL, "box") == {(x, y) for x in (-3, 0, 3) for y in (-3, 0, 3)} - {(0, 0)}


def test_staying_is_for_biped_and_crawl_only():
    assert (0, 0) in steps(BIPED, "axis", allow_stay=True)
    assert (0, 0) in steps(CRAWL, "axis", allow_stay=True)
    assert (0, 0) not in steps(ROLL, "axis", allow_stay=True)


def test_a_straight_step_crosses_the_cells_between():
    assert find(CRAWL, (2, 0)).crossed == ((1, 0),)
    assert find(ROLL, (0, -3)).crossed == ((0, -1), (0, -2))
    assert find(CRAWL, (0, 1)).crossed == ()


def test_a_diagonal_step_touches_the_corners_beside_it():
    step = find(CRAWL, (2, -2))
    assert step.crossed == ((1, -1),)
    assert set(step.touched) == {(1, 0), (0, -1), (2, -1), (1, -2)}


def test_a_knights_step_crosses_two_cells_and_touches_none():
    # (0,0) -> (2,1) leaves column 0 at x = 0.5 (y = 0.25), changes row at x = 1,
    # enters column 2 at x = 1.5 (y = 0.75): inside (1,0) then (1,1).
    step = find(CRAWL, (2, 1))
    assert step.crossed == ((1, 0), (1, 1))
    assert step.touched == ()
