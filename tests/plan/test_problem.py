"""What a problem accepts, and what it says about the rest."""

from __future__ import annotations

import numpy as np
import pytest

from mobius.errors import InvalidInput, PlanError, UnknownName
from mobius.plan import Problem, Weights
from mobius.types import Mode

OPEN = """
...
...
...
"""


def test_modes_are_kept_in_order_and_once(picture):
    p = Problem(picture(OPEN), (0, 0), (2, 2), 4, modes=("roll", "crawl", "roll"))
    assert p.modes == (Mode.ROLL, Mode.CRAWL)


def test_arrays_cannot_be_changed_behind_the_problem(picture):
    cost = np.ones((3, 3))
    p = Problem(picture(OPEN), (0, 0), (2, 2), 4, cell_cost=cost)
    cost[0, 0] = 99.0
    assert p.costs[0, 0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        p.costs[0, 0] = 2.0
    with pytest.raises(TypeError):
        p.weights.P[Mode.CRAWL] = 0.0


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"modes": ("craw",)}, UnknownName, "Did you mean 'crawl'"),
        ({"modes": ("climb",)}, UnknownName, "Known: biped, crawl, roll"),
        ({"modes": ()}, PlanError, "no modes"),
        ({"connectivity": "axes"}, UnknownName, "Did you mean 'axis'"),
        ({"count": "all"}, UnknownName, "Known: endpoint, sweep"),
        ({"check": "none"}, UnknownName, "Known: endpoint, swept"),
        ({"horizon": -1}, InvalidInput, "horizon: expected .* >= 0, got -1"),
        ({"horizon": 2.5}, InvalidInput, "whole number of steps"),
        ({"horizon": 10_000_000}, PlanError, "horizon of at most 5555554"),
        ({"start": (3, 0)}, PlanError, "off the grid"),
        ({"cell_cost": np.full((3, 3), -1.0)}, InvalidInput, "costs >= 0, got -1.0"),
        ({"cell_cost": np.zeros((2, 3))}, InvalidInput, "expected shape"),
        (
            {"weights": Weights(P={"biped": 1.0, "crawl": 1.0})},
            PlanError,
            "penalty for mode 'roll'",
        ),
    ],
)
def test_a_wrong_argument_is_named(picture, options, error, message):
    given = {"start": (0, 0), "goal": (2, 2), "horizon": 4, **options}
    with pytest.raises(error, match=message):
        Problem(picture(OPEN), **given)


def test_weights_are_numbers_not_below_zero():
    with pytest.raises(InvalidInput, match="W_goal"):
        Weights(W_goal=-20.0)  # the sign in the paper's Table VI
    with pytest.raises(InvalidInput, match=r"P\[roll\]"):
        Weights(P={"biped": 1.0, "crawl": 1.0, "roll": float("nan")})


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"switch_cost": {("crawl", "roll"): -1.0}}, InvalidInput, r"\[crawl, roll\]: .* >= 0"),
        ({"switch_cost": {("crawl", "rol"): 1.0}}, UnknownName, "Did you mean 'roll'"),
        ({"switch_cost": {"crawl": 1.0}}, InvalidInput, "keys .from, to. of two modes"),
        ({"switch_cost": {("crawl", "crawl"): 1.0}}, InvalidInput, "no change"),
        ({"last_mode": "climb"}, UnknownName, "Known: biped, crawl, roll"),
        ({"footprint": ((0, 99),)}, InvalidInput, "footprint: expected offsets"),
    ],
)
def test_a_wrong_price_or_footprint_is_named(picture, options, error, message):
    with pytest.raises(error, match=message):
        Problem(picture(OPEN), (0, 0), (2, 2), 4, **options)
