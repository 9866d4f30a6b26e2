"""Windows of a plan searched again: never worse, always legal, the same every time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mobius.plan import Problem, build_problem, check, objective_of, solve
from mobius.plan.bounds import build_arcs, dp_bound
from mobius.plan.check import broken_rule
from mobius.plan.search import Budget
from mobius.plan.windows import Path, Windows, improve
from mobius.types import GridMap, Mode, Plan

ROOM = """
    ............
    .####..####.
    .#........#.
    .#..S.....#.
    .#........#.
    .####..####.
    ..........G.
"""


def made(p: Problem, cells: list, modes: list, bound: float) -> Plan:
    where = np.array(cells, dtype=np.int64)
    value = objective_of(p, where, modes)
    return Plan(where, tuple(modes), p.grid.center_of(where), "feasible", value, bound, 0.0)


def to_and_fro(p: Problem) -> Plan:
    """Between the start and the cell beside it; its bound is the table's."""
    arcs = build_arcs(p)
    bound = float(dp_bound(p, arcs)[p.horizon, arcs.flat(p.start)])
    beside = (p.start[0] + 1, p.start[1])
    cells = [p.start if t % 2 == 0 else beside for t in range(p.horizon + 1)]
    return made(p, cells, [Mode.CRAWL] * p.horizon, bound)


def lazy(p: Problem, rng: np.random.Generator) -> Plan | None:
    """A random walk through what is legal; ``None`` if it gets stuck or ends elsewhere."""
    cells, modes = [p.start], []
    for t in range(p.horizon):
        steps = [
            ((cells[-1][0] + a.d[0], cells[-1][1] + a.d[1]), a.mode)
            for a in p.actions
        ]  # fmt: skip
        steps = [s for s in steps if not broken_rule(p, cells[-1], s[0], s[1], t)]
        if not steps:
            return None
        cell, mode = steps[rng.integers(len(steps))]
        cells.append(cell)
        modes.append(mode)
    if p.must_reach and cells[-1] != p.goal:
        return None
    return made(p, cells, modes, np.inf)


def test_a_plan_that_goes_to_and_fro_is_made_good(picture):
    p = build_problem(picture(ROOM), horizon=30, count="endpoint")
    plan = to_and_fro(p)
    better = improve(p, plan)
    check(p, better)
    assert better.objective > plan.objective + 15 * p.weights.W_exp
    assert better.bound <= plan.bound


def test_meeting_the_bound_is_called_optimal(picture):
    p = build_problem(picture(ROOM), horizon=24, modes=("crawl",))
    best = solve(p, deadline_s=None)
    assert best.status == "optimal"
    better = improve(p, replace(to_and_fro(p), bound=best.bound))
    check(p, better)
    assert (better.status, better.objective) == ("optimal", best.objective)


@pytest.mark.parametrize("moving", [False, True])
def test_whatever_the_problem_a_plan_only_gets_better_and_stays_legal(rng, random_problem, moving):
    better = 0
    for _ in range(60):
        p = replace(
            random_problem(rng, side=(4, 7), moving=moving), horizon=int(rng.integers(1, 9))
        )
        plan = lazy(p, rng)
        if plan is None:
            continue
        new = improve(p, plan, max_states=2000)
        check(p, new)
        assert new.objective >= plan.objective - 1e-9
        better += new.objective > plan.objective
    assert better > 10


def test_short_windows_inside_a_plan_obey_what_moves_and_what_was_seen(rng, random_problem):
    """Windows that begin and end in the middle, on every kind of problem."""
    changed = 0
    for _ in range(60):
        p = replace(random_problem(rng, side=(4, 7), moving=True), horizon=9)
        plan = lazy(p, rng)
        if plan is None:
            continue
        path = Path(tuple((int(i), int(j)) for i, j in plan.cells), plan.modes, plan.objective)
        windows = Windows(p, Budget(10_000, None))
        for a, b in ((0, 4), (2, 7), (5, 9), (8, 9)):
            new = windows.research(path, a, b, b - a, 8) if b <= len(path.modes) else None
            if new is not None:
                changed += 1
                check(p, made(p, list(new.cells), list(new.modes), np.inf))
                assert new.value >= path.value - 1e-6
                assert new.cells[: a + 1] == path.cells[: a + 1]
                path = new
    assert changed > 20


def test_the_same_plan_comes_out_every_time():
    blocked = np.random.default_rng(5).random((30, 30)) < 0.25
    blocked[:3, :3] = False
    grid = GridMap("noise", 0.5, np.zeros(3), blocked, np.full((30, 30), 7))
    p = Problem(grid, (0, 0), (0, 0), 60)
    first, second = (improve(p, to_and_fro(p), max_states=20_000) for _ in range(2))
    assert first.objective > to_and_fro(p).objective
    assert (first.cells == second.cells).all()
    assert first.modes == second.modes


def test_no_time_left_gives_the_plan_back(picture):
    p = build_problem(picture(ROOM), horizon=30)
    plan = to_and_fro(p)
    same = improve(p, plan, deadline_s=0.0)
    assert (same.cells == plan.cells).all()
    assert (same.status, same.bound) == ("feasible", plan.bound)
