"""The checker rejects broken plans, each with words of its own.

The messages are pinned in ``snapshots/check.json``. To change them on purpose:

    UPDATE_SNAPSHOTS=1 python -m pytest tests/plan/test_check.py

and read the difference before committing it.
"""

from __future__ import annotations

import json
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mobius.errors import PlanError
from mobius.plan import Problem, Weights, build_problem, cells_seen, check, objective_of, solve
from mobius.types import Mode, Plan

SNAPSHOT = Path(__file__).parent / "snapshots" / "check.json"

PICTURE = """
    .......
    ..##b..
    ..##...
    c......
    S..cx.G
    """

B, C, R = Mode.BIPED, Mode.CRAWL, Mode.ROLL


def plan_of(problem: Problem, cells: list, modes: list, **claims: object) -> Plan:
    """A plan with correct claims, unless told otherwise."""
    value = objective_of(problem, cells, modes) if cells else 0.0
    fields = dict(
        xy_M=problem.grid.center_of(cells) if cells else np.empty((0, 2)),
        status="optimal",
        objective=value,
        bound=value,
        solve_s=0.0,
    )
    return Plan(np.reshape(cells, (-1, 2)), tuple(modes), **{**fields, **claims})


@pytest.fixture
def problem(picture):
    grid = picture(PICTURE)

    def make(**options: object) -> Problem:
        return build_problem(grid, **{"horizon": 4, "early_stop": True, **options})

    return make


GOOD = [(0, 0), (1, 0), (1, 1), (3, 1), (6, 1)]
GOOD_MODES = [B, C, C, R]


@pytest.fixture
def broken_plans(problem) -> dict[str, tuple[Problem, Plan]]:
    """Hand-broken plans: one rule each."""
    p = problem()
    must, exact = problem(must_reach=True), problem(early_stop=False)
    stay, box, diagonal = (
        problem(allow_stay=True),
        problem(connectivity="box"),
        problem(connectivity="diagonal"),
    )
    nan = float("nan")

    def good(**claims: object) -> Plan:
        return plan_of(p, GOOD, GOOD_MODES, **claims)

    xy = p.grid.center_of(GOOD)
    xy[2] += (0.1, 0.0)
    return {
        "no path": (p, plan_of(p, [], [], status="infeasible")),
        "wrong start": (p, plan_of(p, GOOD[1:], GOOD_MODES[1:])),
        "goal missed": (must, plan_of(must, GOOD, GOOD_MODES)),
        "too long": (p, plan_of(p, [*GOOD, (6, 0)], [*GOOD_MODES, C])),
        "too short": (exact, plan_of(exact, GOOD[:3], GOOD_MODES[:2])),
        "mode not offered": (problem(modes=("crawl", "roll")), good()),
        "off the grid": (p, plan_of(p, [(0, 0), (0, -1)], [C])),
        "in an obstacle": (p, plan_of(p, [*GOOD[:4], (3, 2)], [B, C, C, C])),
        "stays": (p, plan_of(p, [(0, 0), (0, 0)], [C])),
        "roll stays": (stay, plan_of(stay, [(0, 0), (0, 0)], [R])),
        "both axes": (p, plan_of(p, [(0, 0), (1, 1)], [C])),
        "one axis": (diagonal, plan_of(diagonal, [(0, 0), (1, 0)], [C])),
        "biped too far": (p, plan_of(p, [(0, 0), (2, 0)], [B])),
        "crawl too far": (p, plan_of(p, [(0, 0), (3, 0)], [C])),
        "roll too short": (p, plan_of(p, [(0, 0), (1, 0), (1, 2)], [C, R])),
        "wrong mode on departure": (p, plan_of(p, [(0, 0), (1, 0), (3, 0), (3, 1)], [C, C, B])),
        "through an obstacle": (p, plan_of(p, [*GOOD[:4], (3, 4)], [B, C, C, R])),
        "over the wrong ground": (p, plan_of(p, [(0, 0), (0, 3)], [R])),
        "cuts an obstacle": (box, plan_of(box, [(0, 0), (1, 0), (1, 1), (2, 1), (1, 2)], [C] * 4)),
        "cuts the wrong ground": (box, plan_of(box, [(0, 0), (1, 1)], [B])),
        "lands on the wrong ground": (p, plan_of(p, [(0, 0), (0, 1)], [B])),
        "wrong metres": (p, good(xy_M=xy)),
        "infeasible with a path": (p, good(status="infeasible")),
        "objective not a number": (p, good(objective=nan)),
        "bound not a number": (p, good(bound=nan)),
        "boasts": (p, good(objective=1000.0)),
        "bound too low": (p, good(bound=-1000.0)),
        "optimal with a gap": (p, good(bound=1000.0)),
    }


def message(problem: Problem, plan: Plan) -> str:
    with pytest.raises(PlanError) as caught:
        check(problem, plan)
    return str(caught.value)


def test_the_unbroken_plan_passes(problem):
    p = problem()
    check(p, plan_of(p, GOOD, GOOD_MODES))
    check(p, plan_of(p, GOOD, GOOD_MODES, status="feasible", bound=1000.0))


def test_every_broken_plan_is_rejected_in_words_of_its_own(broken_plans):
    messages = {name: message(*case) for name, case in broken_plans.items()}
    # Numbers out: the words alone must tell the rules apart.
    words = {"".join(c for c in text if not c.isdigit()) for text in messages.values()}
    assert len(messages) >= 20
    assert len(words) == len(messages)
    assert not any("\n" in text for text in messages.values())


def test_messages_are_those_of_the_snapshot(broken_plans):
    messages = {name: message(*case) for name, case in broken_plans.items()}
    if os.environ.get("UPDATE_SNAPSHOTS"):
        SNAPSHOT.write_text(json.dumps(messages, indent=1) + "\n")
    assert messages == json.loads(SNAPSHOT.read_text())


def test_a_solved_plan_passes_and_fails_once_a_step_is_changed(picture):
    p = build_problem(picture(PICTURE), must_reach=True)
    plan = solve(p)
    check(p, plan)
    for t, mode in enumerate(plan.modes):
        other = R if mode is not R else B
        modes = [*plan.modes[:t], other, *plan.modes[t + 1 :]]
        with pytest.raises(PlanError, match=rf"step {t}: "):
            check(p, replace(plan, modes=tuple(modes)))


def test_the_objective_by_hand(problem):
    # Path: (0,0) biped (1,0) crawl (1,1) crawl over (2,1) to (3,1) roll to (6,1).
    # Seen: five cells stopped on and (2,1); the roll's (4,1), (5,1) are not: 6 x 20.
    # Goal (6,0) is 1 cell away: -20 x 1. Steps: 5 + 1 + 1 + 10.
    p = problem()
    assert cells_seen(p, GOOD, GOOD_MODES) == {(0, 0), (1, 0), (1, 1), (2, 1), (3, 1), (6, 1)}
    assert objective_of(p, GOOD, GOOD_MODES) == 120 - 20 - 17
    # End points only: (2,1) is gone. Last cell not counted: (6,1) is gone too.
    literal = replace(p, count="endpoint", count_terminal=False)
    assert objective_of(literal, GOOD, GOOD_MODES) == 80 - 20 - 17
    # A cost of 1/2 everywhere: 1 + 1 + 2 + 3 cells entered.
    costly = replace(p, cell_cost=np.full(p.grid.shape, 0.5))
    assert objective_of(costly, GOOD, GOOD_MODES) == 83 - 3.5


def test_going_back_earns_nothing(problem):
    p = replace(problem(), weights=Weights(W_goal=0.0, P={B: 5.0, C: 1.0, R: 10.0}))
    there = objective_of(p, GOOD[:2], [C])
    assert objective_of(p, [*GOOD[:2], (0, 0)], [C, C]) == there - 1.0


def test_changes_of_mode_are_counted_by_hand(problem):
    # GOOD: biped, crawl, crawl, roll. From crawl before it: crawl-biped, biped-crawl, crawl-roll.
    p = problem()
    plain = objective_of(p, GOOD, GOOD_MODES)
    table = {(C, B): 1.0, (B, C): 2.0, (C, R): 4.0, (R, C): 8.0}
    paid = replace(p, switch_cost=table)
    assert objective_of(paid, GOOD, GOOD_MODES) == plain - 6.0
    assert objective_of(replace(paid, last_mode=C), GOOD, GOOD_MODES) == plain - 7.0
    assert objective_of(replace(paid, last_mode=R), GOOD, GOOD_MODES) == plain - 6.0


def test_a_footprint_counts_what_is_in_sight_by_hand(problem):
    # From (0,0), (1,0), (1,1), crossed (2,1), (3,1): themselves and their four neighbours, no
    # blocked cell; the roll lands on (6,1), whose neighbours are (5,1), (6,0), (6,2).
    p = replace(problem(), footprint=((-1, 0), (1, 0), (0, -1), (0, 1)))
    seen = {(0, 0), (1, 0), (2, 0), (3, 0), (0, 1), (1, 1), (2, 1), (3, 1), (4, 1), (1, 2)}
    end = {(6, 1), (5, 1), (6, 0), (6, 2)}
    assert cells_seen(p, GOOD, GOOD_MODES) == seen | end
    assert cells_seen(replace(p, count_terminal=False), GOOD, GOOD_MODES) == seen
    assert objective_of(p, GOOD, GOOD_MODES) == 20 * 14 - 20 - 17
