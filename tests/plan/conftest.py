"""Maps and problems for the planner's tests."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from mobius.plan import Problem, Travel, Weights, disc
from mobius.types import GridMap

LETTERS = {".": 7, "b": 1, "c": 2, "r": 4, "s": 3, "x": 0}
"""Ground that allows everything, one mode, biped and crawl ("safe"), nothing."""


def draw(picture: str, *, cell: float = 0.5) -> GridMap:
    """A map from a picture: top row is the largest y, '#' is blocked, letters as LETTERS.

    'S' and 'G' mark start and goal on open ground.
    """
    rows = [line.strip() for line in picture.strip().splitlines()][::-1]
    nx, ny = len(rows[0]), len(rows)
    blocked = np.zeros((nx, ny), dtype=bool)
    allowed = np.full((nx, ny), 7, dtype=np.uint8)
    place = {}
    for j, row in enumerate(rows):
        for i, letter in enumerate(row):
            blocked[i, j] = letter == "#"
            allowed[i, j] = LETTERS.get(letter, 7)
            if letter in "SG":
                place[letter] = ((np.array([i, j]) + 0.5) * cell).tolist()
    return GridMap("drawing", cell, np.zeros(3), blocked, allowed, place.get("S"), place.get("G"))


def draw_problem(
    rng: np.random.Generator, *, side: tuple[int, int] = (3, 5), moving: bool = False
) -> Problem:
    """A small problem with every option drawn at random; horizon 0 until replaced.

    With ``moving`` some cells were seen before and some close for a while.
    """
    nx, ny = (int(v) for v in rng.integers(side[0], side[1] + 1, size=2))
    blocked = rng.random((nx, ny)) < rng.choice([0.0, 0.2, 0.35])
    allowed = np.where(
        rng.random((nx, ny)) < rng.choice([0.0, 0.3]), rng.integers(0, 8, (nx, ny)), 7
    )
    start = tuple(int(v) for v in rng.integers(0, (nx, ny)))
    goal = tuple(int(v) for v in rng.integers(0, (nx, ny)))
    blocked[start] = blocked[goal] = False
    modes = rng.permutation(["biped", "crawl", "roll"])[: rng.integers(1, 4)].tolist()
    return Problem(
        GridMap("random", 0.5, np.zeros(3), blocked, allowed),
        start,
        goal,
        0,
        modes=tuple(modes),
        weights=Weights(
            W_exp=float(rng.choice([0, 1, 20])),
            W_goal=float(rng.choice([0, 1, 20])),
            P={m: float(rng.integers(0, 12)) for m in ("biped", "crawl", "roll")},
        ),
        connectivity=str(rng.choice(["axis", "axis", "box", "diagonal"])),
        count=str(rng.choice(["sweep", "endpoint"])),
        check=str(rng.choice(["swept", "endpoint"])),
        count_terminal=bool(rng.integers(2)),
        allow_stay=bool(rng.integers(4) == 0),
        must_reach=bool(rng.integers(2)),
        early_stop=bool(rng.integers(2)),
        cell_cost=rng.integers(0, 40, (nx, ny)) / 8 if rng.integers(2) else None,
        seen=rng.random((nx, ny)) < 0.3 if moving and rng.integers(3) else None,
        closed=rng.random((rng.integers(1, 6), nx, ny)) < 0.12 if moving else None,
    )


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(20251101)


@pytest.fixture(scope="session")
def picture() -> Callable[..., GridMap]:
    return draw


@pytest.fixture(scope="session")
def random_problem() -> Callable[..., Problem]:
    return draw_problem


def dress(rng: np.random.Generator, problem: Problem) -> Problem:
    """The problem with prices of time, energy and changes of mode, and a footprint, at random."""
    names = ("biped", "crawl", "roll")
    change: dict = {}
    if rng.integers(2):
        change["weights"] = replace(
            problem.weights,
            per_s=float(rng.choice([0.0, 0.5])),
            per_J=float(rng.choice([0.0, 0.125])),
            travel=Travel(
                {"biped": 0.1, "crawl": 0.4, "roll": 0.7},
                {name: float(rng.integers(0, 80)) for name in names},
            ),
        )
    if rng.integers(3):
        pairs = [(a, b) for a in names for b in names if a != b and rng.integers(4)]
        change["switch_cost"] = {pair: float(rng.integers(0, 20)) for pair in pairs}
    if rng.integers(2):
        change["last_mode"] = str(rng.choice(names))
    if rng.integers(3):
        some = tuple(rng.integers(-4, 5, (rng.integers(1, 6), 2)).tolist())
        change["footprint"] = disc(float(rng.choice([1, 1.5, 2, 3]))) if rng.integers(2) else some
    return replace(problem, **change)


@pytest.fixture(scope="session")
def dressed() -> Callable[..., Problem]:
    return dress
