"""Which bodies a mission may use, and where they have room."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from mobius.errors import InvalidInput, UnknownName
from mobius.types import GridMap, Mode

BIPED_ROOM = 0.58
"""Distance to obstacles [m] where it is on two legs: standing takes a disc of 0.45 m, and
lying, as it may between the bodies, one of 0.58 m."""
ROLL_ROOM = 0.48
"""Distance to obstacles [m] along a roll: the prone width's half, 0.41 m, and a heading 3 deg
off over 1.4 m."""
ARRIVE_WITHIN = 0.35
"""A run counts as arrived when the true trunk ends this close to the goal [m]."""
DRIVABLE = (Mode.CRAWL, Mode.BIPED, Mode.ROLL)
"""Modes a mission may use; without crawl there is none: changes, rolls and recoveries end
in it."""
ROOM = {Mode.BIPED: BIPED_ROOM, Mode.ROLL: ROLL_ROOM}


def check_modes(modes: Iterable[str]) -> tuple[Mode, ...]:
    """Names, or several joined by commas, to modes; each once, in the order given.

    Raises:
        UnknownName: For one that is no mode of a plan.
        InvalidInput: None is given, or crawl is not among them.
    """
    names = [part.strip() for name in modes for part in str(name).split(",") if part.strip()]
    for name in names:
        if name not in {m.value for m in DRIVABLE}:
            raise UnknownName("mode", name, [m.value for m in DRIVABLE])
    chosen = tuple(dict.fromkeys(Mode(name) for name in names))
    if not chosen:
        raise InvalidInput("expected at least one mode, e.g. --modes crawl")
    if Mode.CRAWL not in chosen:
        raise InvalidInput(
            f"a mission without crawl cannot be driven: rolls and recoveries end in it; type"
            f" --modes crawl,{','.join(chosen)}"
        )
    return chosen


def fit_modes(grid: GridMap, clearance: NDArray[np.float64]) -> NDArray[np.uint8]:
    """(nx, ny) modes that each cell admits and has room for.

    Args:
        grid: Free where the crawling robot fits.
        clearance: (nx, ny) distance from the cells' centres to obstacles [m].
    """
    allowed = np.array(grid.allowed)
    for mode, room in ROOM.items():
        allowed[clearance < room] &= np.uint8(~mode.bit & 0xFF)
    return allowed
