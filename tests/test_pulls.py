"""Table IX's pulls: drawn from the seed alone, the same wherever they run, near the paper."""

import json

import pytest

from mobius import paper
from mobius.cli import main
from mobius.errors import InvalidInput
from mobius.pulls import AXES, pull_once, pull_to_failure, pulling_machine
from mobius.reproduce import table_9


@pytest.fixture(scope="module")
def eight():
    """Eight pulls along each axis."""
    return pull_to_failure(seeds=8, seed=5, workers=1)


def test_a_seed_pulls_the_same_alone_and_among_others(eight):
    rig = pulling_machine()
    for axis in AXES:
        assert pull_once(rig, axis, 9) == eight.by_axis[axis][4]


def test_physics_holds_what_was_drawn(eight):
    """The sensor's peak is the grasp's own limit, within inertia (up) and tilted pulls (down)."""
    for axis in AXES:
        assert len({p.drawn for p in eight.by_axis[axis]}) == 8
        for pull in eight.by_axis[axis]:
            assert 0.94 * pull.drawn < pull.peak < 1.03 * pull.drawn
    assert {p.end for p in eight.by_axis["z"]} == {"broken"}
    assert {p.end for p in eight.by_axis["x"]} == {"slipping"}


def test_figures_stand_beside_the_papers(eight):
    figures = eight.as_json()
    json.dumps(figures, allow_nan=False)
    assert figures["seeds"] == 8 and figures["seed"] == 5
    for axis in AXES:
        assert figures["paper_mean_N"][axis] == paper.TABLE_IX[axis].mean
        near = 4 * paper.TABLE_IX[axis].std / 8**0.5  # four standard errors
        assert figures["mean_N"][axis] == pytest.approx(paper.TABLE_IX[axis].mean, abs=near)
    rows = eight.rows()
    assert [row["axis"] for row in rows] == list(AXES) and rows[1]["pulls"] == 8


def test_no_pull_at_all_is_refused():
    with pytest.raises(InvalidInput, match="seeds >= 1"):
        pull_to_failure(seeds=0)


def test_the_verb_prints_json_and_refuses_nonsense(capsys):
    verb = ["eval", "grasp", "--seed", "3", "--workers", "1", "--seeds"]
    assert main([*verb, "1", "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert set(figures["mean_N"]) == {"x", "z"} == set(figures["std_N"])
    assert main([*verb, "0"]) == 2
    assert "--seeds: expected a whole number >= 1" in capsys.readouterr().err


def test_table_9_prints_ours_beside_the_papers(capsys, monkeypatch, tmp_path):
    out = tmp_path / "table_9.csv"
    argv = ["table_9", "--pulls", "1", "--workers", "1", "--out", str(out)]
    monkeypatch.setattr("sys.argv", argv)
    table_9.main()
    printed = capsys.readouterr().out
    assert "124.2" in printed and "23.6" in printed and "By construction" in printed
    assert out.read_text().startswith("axis,")
    monkeypatch.setattr("sys.argv", ["table_9", "--pulls", "0"])
    with pytest.raises(SystemExit, match="seeds >= 1"):
        table_9.main()
