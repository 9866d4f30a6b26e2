"""Few boxes, and together they are exactly the pixels."""

import numpy as np
import pytest

from mobius.world.cover import cover, worth_building

RNG = np.random.default_rng(4)


def painted(boxes, shape):
    """How often each pixel is covered."""
    count = np.zeros(shape, dtype=int)
    for row0, col0, row1, col1 in boxes:
        count[row0:row1, col0:col1] += 1
    return count


@pytest.mark.parametrize("density", [0.0, 0.05, 0.3, 0.7, 0.97, 1.0])
def test_boxes_are_exactly_the_pixels_and_disjoint(density):
    mask = RNG.random((30, 47)) < density
    assert np.array_equal(painted(cover(mask), mask.shape), mask.astype(int))


def test_straight_walls_are_one_box_each():
    # a ring of four walls and a block: four strips and one box
    mask = np.zeros((40, 60), dtype=bool)
    mask[2:4, 2:58] = mask[36:38, 2:58] = True
    mask[2:38, 2:4] = mask[2:38, 56:58] = True
    mask[15:20, 20:35] = True
    assert len(cover(mask)) == 5


def test_an_l_is_two_boxes():
    mask = np.zeros((5, 5), dtype=bool)
    mask[0] = mask[:, 0] = True
    boxes = cover(mask)
    assert sorted(map(tuple, boxes.tolist())) == [(0, 0, 1, 5), (1, 0, 5, 1)]


@pytest.mark.parametrize("density", [0.05, 0.2, 0.5])
def test_with_leave_to_run_on_boxes_hold_what_they_must_and_nothing_they_may_not(density):
    must = RNG.random((30, 47)) < density
    may = RNG.random((30, 47)) < 0.4
    count = painted(cover(must, may), must.shape)
    assert count.max() <= 1
    assert (count[must] == 1).all()
    assert (count[~(must | may)] == 0).all()
    assert len(cover(must, may)) <= len(cover(must))


def test_a_dashed_line_becomes_one_box_where_the_gaps_do_not_matter():
    must = np.zeros((3, 20), dtype=bool)
    must[1, 2:19:4] = True
    may = np.zeros_like(must)
    may[1] = True
    assert cover(must, may).tolist() == [[1, 2, 2, 19]]
    assert len(cover(must)) == 5


def rack():
    """A 60 x 60 floor with walls; a shell of speckle 20 px wide with unseen pixels inside."""
    occupied = np.zeros((60, 60), dtype=bool)
    occupied[[0, -1], :] = occupied[:, [0, -1]] = True
    occupied[20:40, [20, 39]] = occupied[[20, 39], 20:40] = True
    occupied[24:36:3, 24:36:4] = True
    occupied[20, 26:29] = False  # a hole in the shell, 3 px wide
    inside = np.zeros_like(occupied)
    inside[10, 10] = True
    return occupied, inside


def test_what_the_robot_can_reach_is_exact():
    occupied, inside = rack()
    must, may = worth_building(occupied, inside, probe=3.0, near=3.0, fill=4.0)
    count = painted(cover(must, may), occupied.shape)
    ring = np.zeros_like(occupied)
    ring[1:20, 1:59] = True  # open floor on one side of the rack
    assert np.array_equal(count[ring] > 0, occupied[ring])
    assert (count[20, 20:26] == 1).all()


def test_what_hides_behind_a_shell_costs_no_boxes():
    occupied, inside = rack()
    must, may = worth_building(occupied, inside, probe=3.0, near=3.0, fill=4.0)
    assert len(cover(must, may)) < 0.5 * len(cover(occupied))
    assert not must[24:36, 24:36].any()


def test_a_hole_that_the_disc_can_enter_is_kept_open():
    occupied, inside = rack()
    must, may = worth_building(occupied, inside, probe=1.0, near=3.0, fill=4.0)
    count = painted(cover(must, may), occupied.shape)
    assert (count[20, 27] == 0).all()
    assert must[24, 24]


def test_far_walls_behind_walls_are_left_out():
    occupied = np.zeros((20, 60), dtype=bool)
    occupied[:, 30:33] = True
    occupied[5:15, 45] = True
    inside = np.zeros_like(occupied)
    inside[10, 10] = True
    must, _ = worth_building(occupied, inside, probe=2.0, near=3.0, fill=2.0)
    assert must[:, 30:33].all()
    assert not must[:, 40:].any()


def test_a_robot_that_is_nowhere_gets_the_walls_of_the_largest_room():
    occupied = np.zeros((20, 60), dtype=bool)
    occupied[:, 20] = True
    must, _ = worth_building(occupied, np.zeros_like(occupied), probe=2.0, near=3.0, fill=2.0)
    assert must[:, 20].all()
