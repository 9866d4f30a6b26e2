"""What a plan takes in metres, seconds and joules."""

from __future__ import annotations

import pytest

from mobius.errors import PlanError
from mobius.plan import Problem, Travel, Weights, build_problem, plan_cost, solve, step_duration
from mobius.types import Mode, Plan


def test_step_times_follow_table_v():
    assert step_duration(Mode.BIPED, 0.5) == pytest.approx(5.0)
    assert step_duration(Mode.CRAWL, 1.0) == pytest.approx(2.5)
    assert step_duration(Mode.ROLL, 1.5) == pytest.approx(2.142857)


def test_a_mode_without_a_speed_is_named():
    with pytest.raises(PlanError, match="no speed for mode 'climb'"):
        step_duration(Mode.CLIMB, 0.5)


def test_cost_of_a_short_plan_by_hand(picture):
    # (0,0) -crawl-> (2,0) -roll-> (5,0) -biped-> (6,0): 1.0 + 1.5 + 0.5 m,
    # 2.5 + 1.5/0.7 + 5 s; the crawl sees 2 new cells, the roll and the biped 1 each.
    p = Problem(picture("......."), (0, 0), (6, 0), 3)
    cells = [(0, 0), (2, 0), (5, 0), (6, 0)]
    modes = (Mode.CRAWL, Mode.ROLL, Mode.BIPED)
    plan = Plan(cells, modes, p.grid.center_of(cells), "feasible", 0.0, 0.0, 0.0)
    cost = plan_cost(p, plan)
    assert cost.length_m == pytest.approx(3.0)
    assert cost.duration_s == pytest.approx(2.5 + 1.5 / 0.7 + 5.0)
    assert cost.energy_J == pytest.approx(2 * 5.11 + 21.96 + 26.89)
    assert cost.energy_per_cell_J == pytest.approx(cost.energy_J / 4)
    assert (cost.cells_seen, cost.mode_switches) == (5, 2)
    assert cost.travel_J == pytest.approx(1.0 * 64.86 + 1.5 * 70 + 0.5 * 104.17)


def test_measured_speeds_and_joules_are_those_of_the_weights(picture):
    travel = Travel({"crawl": 0.5}, {"crawl": 100.0})
    p = Problem(picture("..."), (0, 0), (2, 0), 1, weights=Weights(travel=travel))
    plan = Plan(
        [(0, 0), (2, 0)], (Mode.CRAWL,), p.grid.center_of([(0, 0), (2, 0)]), "feasible", 0, 0, 0
    )
    cost = plan_cost(p, plan)
    assert (cost.duration_s, cost.travel_J) == (pytest.approx(2.0), pytest.approx(100.0))
    assert plan_cost(p, plan, max_speed={Mode.CRAWL: 0.25}).duration_s == pytest.approx(4.0)


def test_no_steps_cost_nothing(picture):
    p = build_problem(picture("S.."), goal=(0.25, 0.25), must_reach=True)
    cost = plan_cost(p, solve(p))
    assert (cost.length_m, cost.duration_s, cost.energy_J, cost.energy_per_cell_J) == (0, 0, 0, 0)
