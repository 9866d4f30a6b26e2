"""How a roll may end."""

from __future__ import annotations

import pytest

from mobius.errors import InvalidInput
from mobius.plan import RollRisk


def test_landings_that_cannot_happen_are_left_out():
    assert RollRisk(0.0, 0.75, 0.25).landings == ((3, 0.75), (4, 0.25))


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"p_two": -0.1}, "p_two: expected a probability"),
        ({"p_bad": 1.5}, "p_bad: expected a probability"),
        ({"p_bad": float("nan")}, "p_bad: expected a probability"),
        ({"p_two": 0.3}, "must be 1, got 1.2"),
        ({"p_two": 0.5, "p_three": 0.0, "p_four": 0.5}, "p_three: expected > 0"),
        ({"penalty": -1.0}, "penalty: expected points >= 0"),
    ],
)
def test_wrong_numbers_are_named(wrong, says):
    with pytest.raises(InvalidInput, match=says):
        RollRisk(**wrong)
