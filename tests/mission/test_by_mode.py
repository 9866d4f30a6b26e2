"""A made-up run of two bodies taken apart by mode."""

from types import SimpleNamespace

import numpy as np
import pytest

from mobius.mission.by_mode import by_mode, cells_of, first_visits, forced_modes
from mobius.types import GridMap, Mode, Plan


@pytest.fixture
def record():
    """2 m along x in 10 s: crawl, stand up at 1 m, on two legs; cells 2 and 3 force biped."""
    n = 600
    modes = ["crawl"] * 240 + ["stand_up"] * 120 + ["biped"] * 240
    x = np.concatenate([np.linspace(0.1, 1.0, 240), np.full(120, 1.0), np.linspace(1.0, 1.95, 240)])
    power = np.concatenate([np.full(240, 20.0), np.full(120, 60.0), np.full(240, 40.0)])
    allowed = np.array([[7], [7], [1], [1]], dtype=np.uint8)
    grid = GridMap("m", 0.5, np.zeros(3), np.zeros((4, 1), bool), allowed)
    cells = np.array([[0, 0], [1, 0], [2, 0], [3, 0]])
    plan = Plan(cells, ("crawl", "biped", "biped"), grid.center_of(cells), "optimal", 0.0, 0.0, 0.0)
    return SimpleNamespace(
        t=np.arange(n) / 60,
        true_p=np.column_stack([x, np.full(n, 0.25), np.full(n, 0.3)]),
        power=power,
        modes=modes,
        grid=grid,
        plan=plan,
    )


def test_time_way_energy_and_cells_of_every_mode(record):
    table = by_mode(record)
    assert list(table) == ["crawl", "stand_up", "biped"]
    assert [table[m]["time_s"] for m in table] == pytest.approx([4.0, 2.0, 4.0])
    assert [table[m]["energy_J"] for m in table] == pytest.approx([80.0, 120.0, 160.0])
    assert table["crawl"]["path_m"] == pytest.approx(0.9)
    assert table["crawl"]["J_per_m"] == pytest.approx(80.0 / 0.9)
    assert table["stand_up"]["J_per_m"] is None  # it went nowhere
    assert sum(table[m]["cells"] for m in table) == first_visits(record).sum() == 4


def test_a_roll_that_leaps_over_a_forcing_cell_plans_with_it(record):
    cells = np.array([[0, 0], [3, 0]])
    plan = Plan(cells, ("roll",), record.grid.center_of(cells), "optimal", 0.0, 0.0, 0.0)
    assert cells_of(plan).tolist() == [[0, 0], [1, 0], [2, 0], [3, 0]]


def test_a_forced_mode_counts_while_the_robot_moves_in_its_cells(record):
    (name, biped), *rest = forced_modes(record).items()
    assert name == "biped" and not rest
    assert biped["planned"] == 2 and biped["used"] and biped["share"] > 0.98
    assert biped["time_s"] == pytest.approx(4.0, abs=0.1)  # standing up is no part of it


def test_crawling_where_two_legs_are_forced_is_not_using_them(record):
    record.modes = ["crawl"] * 600
    assert not forced_modes(record)["biped"]["used"]


def test_a_forced_mode_of_the_plan_that_was_never_reached_is_not_used(record):
    record.true_p[:, 0] = 0.2
    biped = forced_modes(record)["biped"]
    assert biped["planned"] == 2 and biped["time_s"] == 0.0 and not biped["used"]


def test_rolls_need_only_some_of_the_time(record):
    record.grid = GridMap("m", 0.5, np.zeros(3), np.zeros((4, 1), bool), np.full((4, 1), 4))
    record.modes = ["crawl"] * 500 + [Mode.ROLL.value] * 100
    assert forced_modes(record)["roll"]["used"]
