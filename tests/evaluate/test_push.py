"""Shoves: harder until the fall, and what survival means."""

import json

import pytest

from mobius.evaluate import push
from mobius.evaluate.episode import Setup
from mobius.evaluate.push import MAGNITUDES, PushRun, push_until_fall, survival


def run_of(state: str, count: int) -> PushRun:
    return PushRun(0, state, (0.0, 0.0, 0.0), survived=list(MAGNITUDES[:count]))


def test_survival_is_of_a_magnitude_and_all_smaller_ones():
    runs = [run_of("stand", 0), run_of("stand", 2), run_of("stand", 3), run_of("walk", 10)]
    shares = survival(runs, "stand", MAGNITUDES)
    assert shares[:4] == pytest.approx([2 / 3, 2 / 3, 1 / 3, 0.0])
    assert survival(runs, "walk", MAGNITUDES) == [1.0] * 10


def test_magnitudes_are_those_of_the_bar():
    assert MAGNITUDES == (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)


def test_a_light_shove_is_survived_and_a_mighty_one_is_not():
    run = push_until_fall((Setup("biped", 2, "zero"), "stand"), magnitudes=(0.05, 3.0, 3.0))
    assert run.survived == [0.05] and run.fallen
    assert len(run.angles) == 2 and run.angles[0] != run.angles[1]


def test_both_states_are_shoved_and_reported():
    result = push("biped", seeds=1, seed=4, policy="zero", magnitudes=(4.0,), workers=1)
    plain = json.loads(json.dumps(result.as_json(), allow_nan=False))
    assert plain["survival"] == {"stand": [0.0], "walk": [0.0]}
    assert plain["magnitudes_mps"] == [4.0]
    assert (plain["episodes"], plain["falls"]) == (2, 2)
    assert plain["runs"][0]["command"] == [0, 0, 0] and any(plain["runs"][1]["command"])
