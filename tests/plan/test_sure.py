"""Cells that every plan sees: the same problem, a tighter bound."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mobius.plan import build_problem, objective_of, solve
from mobius.plan.bounds import build_arcs, dp_bound
from mobius.plan.check import broken_rule
from mobius.plan.sure import without_sure_cells


def test_every_path_earns_the_points_more_than_in_what_is_left(rng, random_problem):
    walks = taken_out = 0
    for _ in range(150):
        p = replace(random_problem(rng, moving=True), horizon=int(rng.integers(0, 6)))
        rest, points = without_sure_cells(p)
        taken_out += points > 0
        cells, modes = [p.start], []
        for t in range(p.horizon):
            if p.early_stop and rng.integers(4) == 0:
                break
            steps = [((cells[-1][0] + a.d[0], cells[-1][1] + a.d[1]), a.mode) for a in p.actions]
            steps = [s for s in steps if not broken_rule(p, cells[-1], *s, t)]
            if not steps:
                break
            cell, mode = steps[rng.integers(len(steps))]
            cells.append(cell)
            modes.append(mode)
        if (len(modes) < p.horizon and not p.early_stop) or (p.must_reach and cells[-1] != p.goal):
            continue
        walks += 1
        assert np.isclose(objective_of(p, cells, modes), objective_of(rest, cells, modes) + points)
    assert walks > 50
    assert taken_out > 20


def test_a_tour_home_is_proven_though_the_table_counts_the_start_twice(picture):
    grid = picture("\n".join(["." * 12] * 12))
    p = build_problem(grid, start=(2.25, 2.25), goal=(2.25, 2.25), horizon=20, must_reach=True)
    arcs = build_arcs(p)
    plan = solve(p, deadline_s=None)
    assert plan.status == "optimal"
    assert dp_bound(p, arcs)[20, arcs.flat(p.start)] > plan.bound


def test_nothing_is_sure_where_the_plan_may_end_at_once_uncounted(picture):
    p = build_problem(picture("S..G"), horizon=3, count_terminal=False, early_stop=True)
    assert without_sure_cells(p) == (p, 0.0)
