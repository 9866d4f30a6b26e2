"""Seconds and joules per metre: the paper's, or measured and read from a file."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from mobius import paper
from mobius.errors import InvalidInput, PlanError, UnknownName
from mobius.plan import Problem, Travel, Weights, objective_of, read_costs
from mobius.plan.travel import FORMAT, PAPER_TRAVEL
from mobius.types import Mode

GOOD = {
    "format": FORMAT,
    "source": "run 7",
    "modes": {
        "crawl": {"m_per_s": 0.31, "J_per_m": 142.0},
        "biped": {"m_per_s": 0.09, "J_per_m": 3},
    },
    "switches": [
        {"from": "crawl", "to": "biped", "s": 6.0, "J": 210.0},
        {"from": "biped", "to": "crawl"},
    ],
}


@pytest.fixture
def written(tmp_path):
    def write(**change: object):
        path = tmp_path / "costs.json"
        path.write_text(json.dumps({**GOOD, **change}))
        return path

    return write


def test_a_file_is_read_and_written_back_the_same(written, tmp_path):
    travel = read_costs(written())
    assert travel.source == "run 7"
    assert travel.seconds(Mode.CRAWL, 0.62) == pytest.approx(2.0)
    assert travel.joules(Mode.CRAWL, 0.5) == pytest.approx(71.0)
    assert travel.switch_points(per_s=2.0, per_J=0.1)[Mode.CRAWL, Mode.BIPED] == pytest.approx(33)
    again = tmp_path / "again.json"
    again.write_text(json.dumps(travel.as_json()))
    assert read_costs(again) == travel


def test_the_defaults_are_the_papers_tables():
    assert PAPER_TRAVEL.m_per_s == dict(paper.MAX_SPEED)
    assert PAPER_TRAVEL.J_per_m == {"biped": 104.17, "crawl": 64.86, "roll": 70.0}
    assert Weights().travel == PAPER_TRAVEL


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"format": "costs"}, "format: expected 'mobius travel 1', got 'costs'"),
        ({"modes": {}}, "modes: expected at least one"),
        ({"modes": []}, r"modes: expected an object \{"),
        ({"modes": {"crawl": {"m_per_s": 1.0}}}, "modes.crawl: the key 'J_per_m' is missing"),
        ({"modes": {"crawl": {"m_per_s": 0, "J_per_m": 1}}}, "m_per_s: expected a number > 0"),
        ({"modes": {"crawl": {"m_per_s": 1, "J_per_m": -1}}}, "J_per_m: expected a number >= 0"),
        ({"modes": {"crawl": {"m_per_s": "1", "J_per_m": 1}}}, "m_per_s: expected a number > 0"),
        ({"switches": {}}, "switches: expected a list"),
        ({"switches": [{"from": "crawl"}]}, r"switches\[0\]: the key 'to' is missing"),
        ({"switches": [{"from": "crawl", "to": "crawl", "s": 1}]}, "no change"),
    ],
)
def test_a_wrong_file_says_which_key(written, change, says):
    with pytest.raises(InvalidInput, match=says):
        read_costs(written(**change))


def test_unknown_names_are_corrected(written):
    with pytest.raises(UnknownName, match="Did you mean 'crawl'"):
        read_costs(written(modes={"craw": {}}))
    with pytest.raises(UnknownName, match="Did you mean 'switches'"):
        read_costs(written(swiches=[]))
    with pytest.raises(UnknownName, match="unknown mode 'climb'"):
        read_costs(written(switches=[{"from": "climb", "to": "crawl"}]))


def test_no_file_and_no_json_are_one_line(tmp_path):
    with pytest.raises(InvalidInput, match="there is no such file"):
        read_costs(tmp_path / "none.json")
    (tmp_path / "torn.json").write_text('{"format": ')
    with pytest.raises(InvalidInput, match="expected a JSON file"):
        read_costs(tmp_path / "torn.json")


def test_time_and_energy_enter_the_objective(picture):
    p = Problem(
        picture("......."),
        (0, 0),
        (6, 0),
        4,
        allow_stay=True,
        weights=Weights(W_exp=0.0, W_goal=0.0, per_s=2.0, per_J=0.5),
    )
    # crawl 1 m: 2.5 s, 64.86 J; roll 1.5 m: 1.5 / 0.7 s, 105 J; a rest of one cell's time
    cells, modes = [(0, 0), (2, 0), (5, 0), (5, 0)], [Mode.CRAWL, Mode.ROLL, Mode.CRAWL]
    steps = 1 + 10 + 1
    seconds, joules = 2.5 + 1.5 / 0.7 + 0.5 / 0.4, 64.86 + 105
    assert objective_of(p, cells, modes) == pytest.approx(-steps - 2 * seconds - 0.5 * joules)


def test_a_mode_without_a_measurement_is_missed_only_where_it_has_a_price(written, picture):
    travel, grid = read_costs(written()), picture("....")
    Problem(grid, (0, 0), (3, 0), 1, weights=Weights(travel=travel))
    with pytest.raises(PlanError, match=r"no speed for mode 'roll' \(run 7\)"):
        Problem(grid, (0, 0), (3, 0), 1, weights=Weights(travel=travel, per_s=1.0))
    with pytest.raises(PlanError, match="no energy for mode 'roll'"):
        Problem(grid, (0, 0), (3, 0), 1, weights=Weights(travel=travel, per_J=1.0))
    priced = Weights(travel=travel, per_s=1.0)
    Problem(grid, (0, 0), (3, 0), 1, modes=("crawl",), weights=priced)


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"m_per_s": {"crawl": 0.0}}, r"m_per_s\[crawl\]: expected a number > 0"),
        ({"J_per_m": {"crawl": float("inf")}}, r"J_per_m\[crawl\]: expected a number >= 0"),
        ({"switch_s": {("crawl", "roll"): -1.0}}, r"switch_s\[crawl, roll\]: .* >= 0"),
        ({"switch_s": {"crawl": 1.0}}, "keys .from, to. of two modes"),
    ],
)
def test_wrong_numbers_are_named(wrong, says):
    with pytest.raises(InvalidInput, match=says):
        Travel(**wrong)


def test_prices_are_not_below_zero():
    for name in ("per_s", "per_J"):
        with pytest.raises(InvalidInput, match=name):
            replace(Weights(), **{name: -1.0})
