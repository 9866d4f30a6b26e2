"""The drive behind the film: every step obeys, what was covered grows, a dead end is told."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from mobius.errors import PlanError
from mobius.plan import Problem, broken_rule
from mobius.reproduce.replanning import drive, scene, walkers
from mobius.types import GridMap


def test_no_step_of_the_drive_meets_anything():
    problem, closed = scene(seed=1, steps=6)
    moments = drive(problem, closed, 6, deadline_s=None)
    truth = replace(problem, closed=closed)
    for t, moment in enumerate(moments):
        a, b = (tuple(int(v) for v in c) for c in moment.plan.cells[:2])
        assert a == tuple(moment.trail[-1])
        assert broken_rule(truth, a, b, moment.plan.modes[0], t) is None
        assert np.array_equal(moment.moving, closed[t])


def test_covered_cells_stay_covered_and_hold_the_trail():
    problem, closed = scene(seed=1, steps=6)
    moments = drive(problem, closed, 6, deadline_s=None)
    for before, after in pairwise(moments):
        assert not (before.seen & ~after.seen).any()
        assert all(after.seen[tuple(c)] for c in after.trail)
    assert moments[-1].seen.sum() > moments[0].seen.sum() == 1


def test_walkers_keep_off_walls_and_move_one_cell_at_a_time():
    blocked = np.zeros((6, 6), bool)
    blocked[3] = True
    closed = walkers(np.random.default_rng(0), blocked, 20, 1)
    assert not (closed & blocked).any() and (closed.sum(axis=(1, 2)) == 1).all()
    at = np.argwhere(closed)[:, 1:]
    assert set(np.abs(np.diff(at, axis=0)).sum(axis=1)) <= {0, 1}


def test_a_robot_without_a_way_out_is_told_at_which_step():
    grid = GridMap("lane", 0.5, np.zeros(3), np.zeros((2, 1), bool), np.full((2, 1), 7))
    problem = Problem(grid, (0, 0), (1, 0), 1)
    with pytest.raises(PlanError, match="step 0: "):
        drive(problem, np.ones((3, 2, 1), bool), 1)
