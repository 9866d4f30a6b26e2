"""The bar of the missions in several modes, on made-up runs."""

import importlib.util
from pathlib import Path

import pytest

FILE = Path(__file__).parents[1] / "benchmarks" / "multimodal.py"


@pytest.fixture(scope="module")
def verdict():
    spec = importlib.util.spec_from_file_location("multimodal", FILE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.verdict


def runs(arrived=20, *, used=20, falls=3, up=3):
    """20 runs, of which so many arrived, and so many of these used every forced mode."""
    rows = [
        {
            "goal_reached": k < arrived,
            "forced_modes_used": k < used,
            "falls": 0,
            "recoveries": 0,
            "energy_per_cell_J": 60.0,
            "mode_switches": {"driven_per_step": 0.2},
        }
        for k in range(20)
    ]
    rows[0] |= {"falls": falls, "recoveries": up}
    return rows


def test_seventeen_of_twenty_clear_the_bar(verdict):
    good, line = verdict("map", runs(17))
    assert good and line.startswith("map: 17 of 20 arrived, 17 of these") and "clears" in line


@pytest.mark.parametrize(
    "rows", [runs(16), runs(20, used=19), runs(20, up=2), [{"goal_reached": False, "error": "x"}]]
)
def test_too_few_a_mode_not_used_or_a_fall_not_recovered_miss_it(verdict, rows):
    good, line = verdict("map", rows)
    assert not good and "MISSES" in line


def test_a_run_that_did_not_arrive_need_not_have_used_its_modes(verdict):
    assert verdict("map", runs(18, used=18))[0]
