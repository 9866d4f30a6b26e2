"""A user's sweep file: what it may say, and what is wrong with it, in one line."""

from __future__ import annotations

import pytest

from mobius.errors import MobiusError
from mobius.plan import reconstructed_map
from mobius.sweep.grid_file import read_grid_file
from mobius.sweep.paper_grids import MAP


def read(tmp_path, text):
    path = tmp_path / "s.yaml"
    path.write_text(text)
    return read_grid_file(path, lambda source, **ends: reconstructed_map(8))


def test_every_combination_with_defaults_for_the_rest(tmp_path):
    file = read(tmp_path, "map: [small, reconstructed]\nhorizon: [4, 9]\nmodes: roll+crawl\n")
    assert len(file.settings) == 4
    first = file.settings[0]
    assert (first["map"], first["horizon"], first["modes"]) == ("small", 4, "crawl+roll")
    assert (first["W_exp"], first["P_roll"], first["count"]) == (20.0, 10.0, "sweep")
    assert file.settings[-1]["map"] == MAP
    assert file.work(first)["steps"] == 4


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("horizn: 4", "Did you mean 'horizon'"),
        ("map: demo", "add 'horizon"),
        ("horizon: []", "empty list"),
        ("horizon: [4, ten]", "whole numbers >= 0, got 'ten'"),
        ("horizon: [4, 4]", "listed twice"),
        ("horizon: 4\nmodes: [crawl, crwl+biped]", "Did you mean 'crawl'"),
        ("horizon: 4\nmodes: [crawl+roll, roll+crawl]", "listed twice"),
        ("horizon: 4\nconnectivity: boxx", "Did you mean 'box'"),
        ("horizon: 4\ncount: sweeep", "Did you mean 'sweep'"),
        ("horizon: 4\nW_exp: [1, .nan]", "numbers >= 0, got '.nan'"),
        ("horizon: 4\nW_goal: -1", "numbers >= 0, got '-1'"),
        ("horizon: 4\nP_roll: {a: 1}", "got none or a mapping"),
        ("horizon: 99999999", "at most"),
        ("horizon: 4\nstart: [1, 1]", "has its own start"),
        ("horizon: 4\nmap: small\ngoal: [1]", "expected 2 numbers"),
        ("horizon: [4", "not valid yaml"),
        ("- 4", "lines of a sweep"),
    ],
)
def test_a_mistake_names_file_and_key(tmp_path, text, says):
    with pytest.raises(MobiusError) as caught:
        read(tmp_path, text)
    assert says in str(caught.value) and "s.yaml" in str(caught.value)
    assert "\n" not in str(caught.value)
