"""A first plan stretch by stretch."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mobius.plan import Problem, objective_of
from mobius.plan.bounds import build_arcs, dp_bound
from mobius.plan.check import broken_rule
from mobius.plan.rollout import roll_out
from mobius.types import GridMap


def legal(p: Problem, cells: list, modes: list) -> bool:
    return (
        len(modes) == p.horizon
        and cells[0] == p.start
        and (cells[-1] == p.goal or not p.must_reach)
        and not any(broken_rule(p, cells[t], cells[t + 1], m, t) for t, m in enumerate(modes))
    )


@pytest.mark.parametrize("moving", [False, True])
def test_every_problem_that_has_a_plan_gets_a_legal_one_below_the_bound(
    rng, random_problem, moving
):
    made = 0
    for _ in range(60):
        p = random_problem(rng, moving=moving)
        p = replace(p, horizon=int(rng.integers(0, 50)), early_stop=False)
        arcs = build_arcs(p)
        U = dp_bound(p, arcs)
        bound = U[p.horizon, arcs.flat(p.start)]
        if bound == -np.inf:
            continue
        cells, modes = roll_out(p, arcs, U)
        assert legal(p, cells, modes)
        assert objective_of(p, cells, modes) <= bound + 1e-6
        made += 1
    assert made > 10


def test_a_plan_is_whole_even_without_time():
    blocked = np.random.default_rng(2).random((60, 60)) < 0.2
    blocked[:3, :3] = False
    p = Problem(
        GridMap("noise", 0.5, np.zeros(3), blocked, np.full((60, 60), 7)), (0, 0), (0, 0), 80
    )
    arcs = build_arcs(p)
    U = dp_bound(p, arcs)
    hurried = roll_out(p, arcs, U, deadline_s=0.0)
    assert legal(p, *hurried)
    assert objective_of(p, *roll_out(p, arcs, U)) >= objective_of(p, *hurried)
