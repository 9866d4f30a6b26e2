"""The steps of a cell: those of the arcs, one by one, the dearer of two alike left out."""

from __future__ import annotations

import numpy as np
import pytest

from mobius.plan.arcs import build_arcs
from mobius.plan.bounds import dp_bound
from mobius.plan.space import Space


def one_by_one(space: Space, cell: int) -> dict[tuple[int, int, int], float]:
    """Cost of the cheapest step by landing, bits counted and number of the mode."""
    arcs, best = space.arcs, dict[tuple[int, int, int], float]()
    for a in np.flatnonzero(arcs.valid[:, cell]).tolist():
        seen = space.look(cell)
        for o in arcs.seen[a]:
            seen |= space.look(cell + o) if arcs.free[cell + o] else 0
        alike = (cell + arcs.offset[a], seen, space.mode_of[a])
        best[alike] = min(best.get(alike, np.inf), float(arcs.cost[a, cell]))
    return best


@pytest.mark.parametrize("seed", range(6))
def test_steps_are_those_of_the_arcs_moved_to_the_cell(seed, random_problem, dressed):
    rng = np.random.default_rng([seed, 11])
    touched = 0
    for n in range(12):
        p = dressed(rng, random_problem(rng, side=(2, 6), moving=bool(n % 2)))
        arcs = build_arcs(p)
        space = Space(p, arcs, dp_bound(p, arcs))
        for cell in np.flatnonzero(arcs.free).tolist():
            steps = space.successors(cell)
            expected = one_by_one(space, cell)
            assert {(to, seen, space.mode_of[a]): c for a, to, seen, c, *_ in steps} == expected
            assert len(steps) == len(expected)
            landings = 0
            for action, to, seen, cost, touch, most in steps:
                landings |= 1 << to
                assert arcs.valid[action, cell] and cost == arcs.cost[action, cell]
                assert most >= space.W * seen.bit_count() - cost
                where = sum(1 << (cell + o) for o in set(arcs.touch[action]))
                assert touch == where or not any(space._closed)
                touched += touch > 0
            assert space.neighbours(cell) == landings
    assert touched > 0
