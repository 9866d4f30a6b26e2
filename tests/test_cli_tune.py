"""``mobius tune`` and ``mobius eval tuning``."""

import json

import pytest

from mobius.cli import main


def test_tune_prints_gains_before_and_after_and_draws(tmp_path, capsys):
    png = tmp_path / "run.png"
    assert main(["tune", "two_arms", "--png", str(png)]) == 0
    told = capsys.readouterr().out
    assert "before: a grip broke at" in told and "after: held" in told
    assert "gain      before     after" in told
    assert png.stat().st_size > 20_000


def test_tune_as_json_is_one_object(capsys):
    assert main(["tune", "bar", "--stiffness", "3000", "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["force_rmse_after_N"] < 0.55 * result["force_rmse_before_N"]
    assert not result["unstable"]
    assert result["windows"][-1]["gains"] == result["gains_after"]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["tune", "walls"], "Did you mean 'wall'"),
        (["tune", "wall", "--start", "best"], "one_for_all"),
        (["tune", "wall", "--stiffness", "-1"], "--stiffness: expected N/m > 0"),
        (["tune", "two_arms", "--start", "guess"], "does not go with two_arms"),
        (["tune", "wall", "--png", "a.jpg"], ".png"),
        (["eval", "tuning", "--seeds", "0"], "--seeds"),
        (["eval", "tuning", "--start", "best"], "one_for_all"),
    ],
)
def test_mistakes_are_one_line_and_exit_code_2(words, told, capsys):
    assert main(words) == 2
    error = capsys.readouterr().err
    assert told in error and error.count("\n") == 1
