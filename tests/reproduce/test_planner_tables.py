"""Tables VI and VII and Fig. 12 on a grid of a few settings."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace

import pytest

from mobius import paper
from mobius.reproduce import table_6, table_7
from mobius.reproduce.common import as_text, swept
from mobius.reproduce.fig_12 import plan_of_fig_12
from mobius.types import Mode

FEW = replace(paper.TABLE_VII, W_exp=(1, 50), W_goal=(-1,), epsilon=(1e-3, 1e-2), M=(8000,))


@pytest.fixture(scope="module")
def rows():
    return swept(FEW)


def test_table_6_has_the_papers_rows_and_ours_beside_them(rows):
    table = table_6.rows(rows)
    printed = [row for row in table if row["whose"] == "paper"]
    assert [row["energy"] for row in printed] == [34.91, 35.41, 26.89, 5.11, 21.96]
    assert [row["failed"] for row in printed[2:]] == ["270/324", "160/324", "135/324"]
    ours = {(row["mode"], row["whose"]): row for row in table if row["whose"] != "paper"}
    for mode, row in paper.TABLE_VI_SINGLE.items():
        assert ours[mode, "ours, best"]["energy"] == pytest.approx(row.energy)
    # T = 10, 15, 20 are too short for 38 cells of biped; at T = 40 all reach the goal
    assert ours["biped", "ours, best"]["failed"] == "12/16"
    assert len(as_text(table).splitlines()) == 1 + len(table)


def test_the_best_setting_is_of_least_energy_and_ends_at_the_goal(rows):
    alone = [row for row in rows if row["modes"] == "biped"]
    (best,) = table_6.best(alone, 1)
    assert best["goal_cells_away"] == 0 and best["horizon"] == 40
    assert len(table_6.best(alone, 99)) == 2  # epsilon does not make two of one


def test_table_7_shows_that_epsilon_does_nothing_and_the_horizon_much(rows):
    table = table_7.rows(rows)
    by = {(row["parameter"], row["value"]): row for row in table}
    assert by["epsilon", 1e-2]["changes"] == 0.0
    assert by["T", 40]["changes"] == 1.0
    assert by["T", 10]["biped failed"] == "4/4" and by["T", 40]["biped failed"] == "0/4"


def test_fig_12_is_the_first_setting_of_table_6():
    problem, plan = plan_of_fig_12()
    assert (problem.weights.W_exp, problem.weights.W_goal, problem.horizon) == (20.0, 20.0, 20)
    assert problem.weights.P[Mode.ROLL] == 4.0 and plan.status == "optimal"


def test_fig_12_runs_as_a_module_and_says_what_is_wrong_in_one_line(tmp_path):
    def run(*argv):
        line = [sys.executable, "-m", "mobius.reproduce.fig_12", *argv]
        return subprocess.run(line, capture_output=True, text=True, check=False, cwd=tmp_path)

    done = run("--horizon", "10", "--out", "f.png")
    assert done.returncode == 0 and "reconstructed map" in done.stdout
    assert (tmp_path / "f.png").read_bytes().startswith(b"\x89PNG")
    wrong = run("--horizon", "10", "--out", "f.jpg")
    assert wrong.returncode == 1 and wrong.stderr.count("\n") == 1 and ".png" in wrong.stderr
