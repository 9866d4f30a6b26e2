"""Settings of the planner as rows, and the paper's own grid of them."""

from __future__ import annotations

import numpy as np
import pytest

from mobius import paper
from mobius.plan import reconstructed_map
from mobius.sweep import plan_row
from mobius.sweep.paper_grids import (
    MAP,
    OPEN_MAP,
    paper_settings,
    paper_work,
    switch_settings_matter,
)
from mobius.sweep.planner import ALL_MODES, SETTING_KEYS

SETTING = next(s for s in paper_settings() if s["modes"] == "crawl" and s["horizon"] == 20)


def test_a_row_says_what_the_plan_is_like():
    row = plan_row(SETTING, reconstructed_map())
    assert row["status"] == "optimal" and row["gap"] == 0.0 and row["why"] == ""
    assert row["steps"] == 20 and row["goal_cells_away"] == 0
    # 19 steps of 2 cells make the 38 cells of both axes, one step is of 1 + 1 cells
    assert row["cells_seen"] == 39
    assert row["energy_per_cell_J"] == pytest.approx(paper.TABLE_VI_SINGLE["crawl"].energy)


def test_a_setting_without_a_plan_is_a_row_with_the_reason_and_the_same_names():
    small = reconstructed_map(2)
    row = plan_row({**SETTING, "modes": "roll"}, small)
    assert row["status"] == "infeasible" and "shut in" in row["why"]
    assert row["energy_J"] is None
    assert list(row) == list(plan_row(SETTING, reconstructed_map()))


def test_the_papers_grid_is_four_times_324_and_the_two_printed_settings():
    settings = paper_settings()
    assert len(settings) == 4 * paper.PLAN_COMBINATIONS + 2
    assert len({tuple(s.items()) for s in settings}) == len(settings)
    problems = {tuple(s[k] for k in SETTING_KEYS) for s in settings}
    assert len(problems) == 4 * 36 + 2
    assert {s["map"] for s in settings if s["modes"] == ALL_MODES} == {MAP}


def test_single_modes_plan_without_forced_regions_but_with_the_obstacles():
    maps = paper_work().maps
    assert (maps[OPEN_MAP].allowed == 7).all() and not (maps[MAP].allowed == 7).all()
    assert np.array_equal(maps[OPEN_MAP].blocked, maps[MAP].blocked)


def test_no_tested_epsilon_and_M_says_more_than_inside_or_outside():
    grid, table = reconstructed_map(), paper.TABLE_VII
    assert not any(switch_settings_matter(grid, e, M) for e in table.epsilon for M in table.M)
    # M must exceed the greatest squared distance, 18^2 + 19^2 = 685 less r^2 of 6.25
    assert switch_settings_matter(grid, 1e-3, 100)
    # d = 10 lies next outside r^2 = 9, so epsilon = 2 leaves it neither inside nor outside
    assert switch_settings_matter(grid, 2.0, 1000)


def test_the_stamp_knows_the_map():
    assert paper_work().stamp == paper_work().stamp != paper_work(n=19).stamp
