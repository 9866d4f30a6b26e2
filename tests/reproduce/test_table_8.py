"""Table VIII, and the energies of Table VI at measured prices."""

import json
import subprocess
import sys
from dataclasses import replace

import pytest

from mobius import paper
from mobius.plan import Travel
from mobius.reproduce import table_6, table_8
from mobius.reproduce.common import swept
from mobius.types import Mode

OURS = Travel(
    {Mode.CRAWL: 0.3, Mode.BIPED: 0.2},
    {Mode.CRAWL: 120.0, Mode.BIPED: 200.0},
    {(Mode.CRAWL, Mode.BIPED): 6.0},
    {(Mode.CRAWL, Mode.BIPED): 230.0},
    "made up",
)


def test_ours_stands_below_the_papers_where_it_was_measured():
    table = table_8.rows(OURS)
    assert [(row["mode"], row["whose"]) for row in table] == [
        ("biped", "paper"), ("biped", "ours"), ("crawl", "paper"), ("crawl", "ours"),
        ("roll", "paper"), ("crawl to biped", "ours"),
    ]  # fmt: skip
    assert table[0]["J_per_m"] == 104.17 and table[4]["J_per_m"] == 70.0
    assert table[3]["J_per_cell"] == 60.0 and table[3]["cost_of_transport"] == pytest.approx(
        1.2232, abs=1e-3
    )
    assert (table[5]["J"], table[5]["s"]) == (230.0, 6.0)


def test_table_6_at_our_prices_charges_the_way_of_our_plans():
    few = replace(paper.TABLE_VII, W_exp=(50,), W_goal=(-1,), epsilon=(1e-3,), M=(8000,))
    few = replace(few, horizons=(20,)) if hasattr(few, "horizons") else few
    table = table_6.rows(swept(few), OURS)
    crawl = [row for row in table if row["mode"] == "crawl" and row["whose"] != "paper"]
    assert crawl and all(row["energy_ours"] == pytest.approx(60.0) for row in crawl)
    roll = [row for row in table if row["mode"] == "roll"]
    assert all(row["energy_ours"] is None for row in roll)  # it was not measured
    assert all(row["energy_ours"] is None for row in table if row["whose"] == "paper")


def test_it_runs_as_a_module_and_says_what_is_wrong_in_one_line(tmp_path):
    def run(*argv):
        line = [sys.executable, "-m", "mobius.reproduce.table_8", *argv]
        return subprocess.run(line, capture_output=True, text=True, check=False, cwd=tmp_path)

    (tmp_path / "costs.json").write_text(json.dumps(OURS.as_json()))
    done = run("--costs", "costs.json", "--out", "t.csv")
    assert done.returncode == 0 and "104.2" in done.stdout
    assert (tmp_path / "t.csv").read_text().startswith("mode,whose")
    wrong = run("--costs", "none.json")
    assert wrong.returncode == 1 and wrong.stderr.count("\n") == 1
