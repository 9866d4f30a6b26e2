"""What a metre costs: means of trials, a short walk, and the file the planner reads."""

import json

import numpy as np
import pytest

from mobius.errors import InvalidInput, MobiusError, UnknownName
from mobius.evaluate import energy as room
from mobius.evaluate.energy import Trial, cells_entered, energy, summary_of
from mobius.plan import read_costs
from mobius.types import Mode

TRIALS = [
    Trial("crawl", 0, seconds=10.0, metres=4.0, joules=400.0, mass=10.0, cells=8),
    Trial("crawl", 1, seconds=10.0, metres=2.0, joules=320.0, mass=10.0, cells=4),
    Trial("crawl", 2, seconds=10.0, metres=0.1, joules=999.0, mass=10.0, failed=True),
    Trial("roll", 0, seconds=4.0, metres=1.2, joules=180.0, mass=10.0),
    Trial("crawl>biped", 0, seconds=5.0, metres=0.0, joules=200.0, mass=10.0),
    Trial("crawl>biped", 1, seconds=7.0, metres=0.0, joules=260.0, mass=10.0),
]


def test_means_are_weighted_by_the_way_and_failures_only_counted():
    result = summary_of(TRIALS, seed=0, seeds=3)
    crawl = result.modes["crawl"]
    assert crawl.J_per_m == pytest.approx(720.0 / 6.0) and crawl.m_per_s == pytest.approx(0.3)
    assert crawl.J_per_cell == pytest.approx(60.0)
    assert crawl.cost_of_transport == pytest.approx(120.0 / 98.1)
    assert (crawl.trials, crawl.failures) == (3, 1)
    assert result.switches["crawl>biped"].s == pytest.approx(6.0)


def test_a_cell_costs_what_was_spent_per_cell_visited_not_per_half_metre():
    slant = [Trial("crawl", 0, seconds=10.0, metres=4.0, joules=400.0, mass=10.0, cells=10)]
    assert summary_of(slant, seed=0, seeds=1).modes["crawl"].J_per_cell == pytest.approx(40.0)
    short = [Trial("crawl", 0, seconds=1.0, metres=0.2, joules=20.0, mass=10.0)]
    assert summary_of(short, seed=0, seeds=1).modes["crawl"].J_per_cell is None


def test_cells_are_counted_once_and_without_the_first():
    straight = np.column_stack([np.linspace(0.1, 2.1, 50), np.full(50, 0.2)])
    assert cells_entered(straight) == 4
    assert cells_entered(np.vstack([straight, straight[::-1]])) == 4
    assert cells_entered(straight[:1]) == 0


def test_a_mode_that_always_failed_is_an_error():
    with pytest.raises(MobiusError, match="'crawl' failed in all of 1"):
        summary_of([TRIALS[2]], seed=2, seeds=1)


def test_the_planner_reads_what_was_measured(tmp_path):
    result = summary_of(TRIALS, seed=0, seeds=3)
    file = tmp_path / "costs.json"
    file.write_text(json.dumps(result.travel().as_json()))
    travel = read_costs(file)
    assert travel.J_per_m == {Mode.CRAWL: 120.0, Mode.ROLL: pytest.approx(150.0)}
    assert travel.switch_J[Mode.CRAWL, Mode.BIPED] == pytest.approx(230.0)


def test_a_short_crawl_is_measured_in_physics(monkeypatch):
    monkeypatch.setattr(room, "WALK_S", 1.6)
    monkeypatch.setattr(room, "RAMP_S", 1.0)
    result = energy(modes=["crawl"], seeds=1, randomised=False)
    crawl = result.modes["crawl"]
    assert 0.2 < crawl.m_per_s < 0.5 and 30.0 < crawl.J_per_m < 400.0
    assert result.switches == {} and crawl.failures == 0


def test_a_wrong_mode_is_named():
    with pytest.raises(UnknownName, match="Did you mean 'roll'"):
        energy(modes=["rol"])
    with pytest.raises(InvalidInput, match="at least one mode"):
        energy(modes=[])
