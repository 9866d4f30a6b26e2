"""What is seen from a cell, and what hides it."""

from __future__ import annotations

import numpy as np
import pytest

from mobius.errors import InvalidInput
from mobius.plan import Problem, cells_seen, disc
from mobius.plan.check import in_sight
from mobius.plan.sight import footprint_of, sight_masks
from mobius.types import GridMap, Mode


def seen_from(picture: GridMap, place: tuple[int, int], radius: float) -> set:
    offsets = disc(radius)
    masks = sight_masks(picture.blocked, offsets)
    return {(place[0] + o[0], place[1] + o[1]) for o in offsets if masks[o][place]}


def test_a_disc_holds_the_centres_within_its_radius():
    assert disc(0) == ((0, 0),)
    assert set(disc(1)) == {(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)}
    assert len(disc(1.5)) == 9
    assert len(disc(2)) == 13


def test_a_wall_hides_what_lies_behind_it(picture):
    grid = picture(
        """
        .....
        ..#..
        .....
        """
    )
    assert (4, 1) not in seen_from(grid, (0, 1), 4)
    assert (2, 1) not in seen_from(grid, (0, 1), 4)  # the wall itself is no free cell
    assert (4, 2) in seen_from(grid, (0, 2), 4)


def test_a_diagonal_wall_hides_and_one_corner_does_not(picture):
    closed = picture("#.\n.#")
    assert (1, 1) not in seen_from(closed, (0, 0), 2)
    corner = picture("..\n.#")
    assert (1, 1) in seen_from(corner, (0, 0), 2)
    # a longer diagonal: the corner between (1, 2) and (2, 1) is shut, the others are open
    long = picture("....\n.#..\n..#.\n....")
    assert {(1, 1), (3, 3)} & seen_from(long, (0, 0), 5) == {(1, 1)}


def test_the_masks_and_the_checker_agree_and_sight_is_mutual(rng):
    seen = 0
    for _ in range(20):
        shape = tuple(int(v) for v in rng.integers(2, 9, 2))
        blocked = rng.random(shape) < 0.25
        blocked[0, 0] = False
        grid = GridMap("random", 0.5, np.zeros(3), blocked, np.full(shape, 7))
        p = Problem(grid, (0, 0), (0, 0), 0, footprint=disc(float(rng.uniform(1, 5))))
        masks = sight_masks(blocked, p.footprint)
        for place in map(tuple, np.argwhere(~blocked).tolist()):
            by_mask = {(place[0] + o[0], place[1] + o[1]) for o in masks if masks[o][place]}
            assert by_mask == in_sight(p, place)
            assert all(place in in_sight(p, other) for other in by_mask)
            seen += len(by_mask)
    assert seen > 2000


def test_a_crossed_cell_looks_round_and_a_roll_only_where_it_lands(picture):
    p = Problem(picture("....\n....\n...."), (0, 1), (3, 1), 1, footprint=disc(1))
    crawl = cells_seen(p, [(0, 1), (2, 1)], [Mode.CRAWL])
    assert crawl == {(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2), (2, 0), (2, 1), (2, 2), (3, 1)}
    roll = cells_seen(p, [(0, 1), (3, 1)], [Mode.ROLL])
    assert roll == {(0, 0), (0, 1), (0, 2), (1, 1), (2, 1), (3, 0), (3, 1), (3, 2)}


def test_the_own_cell_always_belongs_and_alone_is_no_footprint(picture):
    assert footprint_of([(1, 0)]) == ((0, 0), (1, 0))
    assert Problem(picture("..."), (0, 0), (2, 0), 1, footprint=disc(0.5)).footprint is None


@pytest.mark.parametrize("wrong", [-1.0, 99.0, float("nan"), [(1, 2, 3)], [(0.5, 0)], [(31, 0)]])
def test_a_wrong_footprint_is_refused(wrong):
    with pytest.raises(InvalidInput, match="footprint: expected"):
        footprint_of(wrong)
