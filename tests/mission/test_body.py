"""Which bodies a mission may use, and where there is room for them."""

import numpy as np
import pytest

from mobius.errors import InvalidInput, UnknownName
from mobius.mission.body import BIPED_ROOM, ROLL_ROOM, check_modes, fit_modes
from mobius.types import GridMap, Mode


@pytest.mark.parametrize("typed", [("crawl,biped,roll",), ("crawl", "biped", "roll")])
def test_modes_may_be_joined_by_commas_or_not(typed):
    assert check_modes(typed) == (Mode.CRAWL, Mode.BIPED, Mode.ROLL)


def test_without_crawl_there_is_no_mission():
    with pytest.raises(InvalidInput, match="--modes crawl,biped"):
        check_modes(["biped"])
    with pytest.raises(InvalidInput, match="at least one mode"):
        check_modes([","])
    with pytest.raises(UnknownName, match="Did you mean 'biped'"):
        check_modes(["crawl", "bipde"])


def test_a_cell_admits_only_bodies_that_fit():
    room = np.array([[BIPED_ROOM + 0.01, BIPED_ROOM - 0.01, ROLL_ROOM - 0.01]])
    grid = GridMap("m", 0.5, np.zeros(3), np.zeros((1, 3), bool), np.full((1, 3), 7, np.uint8))
    crawl, biped, roll = Mode.CRAWL.bit, Mode.BIPED.bit, Mode.ROLL.bit
    assert fit_modes(grid, room).tolist() == [[crawl | biped | roll, crawl | roll, crawl]]
