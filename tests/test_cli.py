"""The command line: one line for a mistake, an exit code, nothing left behind."""

import ast
import inspect
import json
import re
import textwrap
from dataclasses import fields
from itertools import pairwise

import pytest

from mobius.cli import VERBS, main


def run(capsys, *argv: str) -> tuple[int, str, str]:
    try:
        code = main(list(argv))
    except SystemExit as stop:  # the parser's own errors
        code = int(stop.code or 0)
    out, err = capsys.readouterr()
    return code, out, err


def test_plan_prints_one_json_object(capsys):
    code, out, _ = run(capsys, "plan", "demo", "--modes", "crawl", "--json")
    assert code == 0
    plan = json.loads(out)
    assert set(plan) == {"status", "objective", "bound", "gap", "solve_ms", "steps"}
    assert plan["status"] == "optimal" and plan["gap"] == pytest.approx(0.0)
    assert set(plan["steps"][0]) == {"t", "x", "y", "mode"}
    assert [s["t"] for s in plan["steps"]] == list(range(len(plan["steps"])))


def test_plan_with_a_horizon(capsys):
    code, out, _ = run(capsys, "plan", "demo", "--horizon", "20", "--json")
    assert code == 0
    plan = json.loads(out)
    assert len(plan["steps"]) == 21
    assert plan["bound"] >= plan["objective"]


@pytest.mark.parametrize(
    ("argv", "says"),
    [
        (("plan", "dmeo"), "Did you mean 'demo'"),
        (("plan", "nowhere/map.yaml"), "nowhere/map.yaml"),
        (("plan", "demo", "--modes", "crwl"), "crawl"),
        (("plan", "demo", "--horizon", "-1"), "--horizon"),
        (("plan", "demo", "--start", "0.05", "0.05"), "start"),
        (("plan", "demo", "--png", "p.jpg"), "--png"),
        (("plan", "demo", "--png", "."), "--png"),
        (("plan", "demo", "--gap-png", "p.jpg"), "--gap-png"),
        (("plan", "demo", "--gap-png", "p.png", "--solver", "didp"), "only the solver 'exact'"),
        (("plan", "demo", "--solver", "exakt"), "Did you mean 'exact'"),
        (("plan", "demo", "--count", "sweeep"), "Did you mean 'sweep'"),
        (("plan", "demo", "--deadline", "nan"), "--deadline"),
        (("plan", "demo", "--start", "nan", "1"), "--start"),
        (("plan", "demo", "--goal", "1e300", "1"), "--goal"),
        (("plan", "demo", "--modes"), "no modes to plan with"),
        (("plan", "demo", "--horizon", "1000000000"), "too large"),
        (("run", "demo", "--start", "inf", "1"), "--start"),
        (("sweep", "tabel-6", "--out", "s"), "Did you mean 'table-6'"),
        (("sweep", "table-6", "--out", "s", "--workers", "-1"), "--workers"),
        (("sweep", "lost.yaml", "--out", "s"), "there is no such file"),
        (("run", "demo", "--modes", "biped"), "--modes crawl,biped"),
        (("run", "demo", "--modes", "crawl,bipde"), "Did you mean 'biped'"),
        (("run", "demo", "--scenario", "no.yaml"), "there is no such file"),
        (("run", "demo", "--regions", "no.yaml"), "there is no such file"),
        (("eval", "energy", "--modes", "crwl"), "Did you mean 'crawl'"),
        (("eval", "energy", "--seeds", "0"), "--seeds"),
        (("run", "demo", "--modes", "craw"), "Did you mean 'crawl'"),
        (("run", "--modes", "crawl,biped", "dem"), "Did you mean 'demo'"),
        (("run", "--modes", "crawl,biped"), "expected a map"),
        (("run", "demo", "--costs", "costs.json"), "add --per-s or --per-j"),
        (("run", "demo", "--per-j", "-1"), "--per-j: expected points >= 0"),
        (("run", "demo", "--seed", "-3"), "--seed"),
        (("eval", "crwl"), "Did you mean 'crawl'"),
        (("eval", "crawl", "trackng"), "Did you mean 'tracking'"),
        (("eval", "motions", "rol"), "Did you mean 'roll'"),
        (("eval", "motions", "prone_to_crawl", "--seeds", "0"), "--seeds: expected a whole number"),
        (("eval", "motions", "--seed", "-1"), "--seed: expected a whole number >= 0"),
        (("eval", "crawl", "--seeds", "0"), "--seeds"),
        (("eval", "crawl", "tracking", "--speed", "0"), "speed factor > 0"),
        (("eval", "crawl", "push", "--speed", "0.5"), "--speed goes with tracking"),
        (("eval", "biped", "tracking", "--as-force"), "--as-force goes with push"),
        (("eval", "crawl", "terrain", "--kind", "slop", "--out", "t"), "Did you mean 'slope'"),
        (("eval", "crawl", "robustness", "--sweep", "dely"), "Did you mean 'delay'"),
        (("eval", "crawl", "push", "--policy", "zerro", "--out", "p"), "Did you mean 'zero'"),
        (("eval", "crawl", "push", "--policy", "lost.onnx"), "no such policy"),
        (("train", "crwl"), "Did you mean 'crawl'"),
        (("train", "crawl", "--preset", "fats"), "Did you mean 'fast'"),
    ],
)
def test_a_mistake_is_one_line_and_exit_code_two(capsys, tmp_path, monkeypatch, argv, says):
    monkeypatch.chdir(tmp_path)
    code, out, err = run(capsys, *argv)
    assert code == 2
    assert out == ""
    assert err.startswith("mobius: ") and err.count("\n") == 1
    assert says in err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("verb", [("run", "demo"), ("eval", "crawl", "push", "--seeds", "1")])
def test_a_full_folder_is_not_overwritten(capsys, tmp_path, verb):
    (tmp_path / "precious").write_text("data")
    code, _, err = run(capsys, *verb, "--out", str(tmp_path))
    assert code == 2 and "not empty" in err
    assert (tmp_path / "precious").read_text() == "data"


def test_eval_prints_one_json_object_and_leaves_a_folder(capsys, tmp_path):
    """With the random peer, which falls within a second or two."""
    out = tmp_path / "result"
    options = ("--policy", "random", "--seeds", "1", "--workers", "1", "--out", str(out))
    code, printed, _ = run(capsys, "eval", "biped", "terrain", "--kind", "soft", *options, "--json")
    assert code == 0
    result = json.loads(printed)
    assert printed.count("\n") == 1 and set(result["kinds"]) == {"soft"}
    assert result["falls"] == 1 and result["kinds"]["soft"]["survived"] == 0
    names = {"terrain.json", "terrain.png", "terrain_kinds.csv", "terrain_runs.csv"}
    assert {p.name for p in out.iterdir()} == names
    assert json.loads((out / "terrain.json").read_text()) == result
    assert [p.name for p in tmp_path.iterdir()] == ["result"]


def test_a_sweep_over_a_file_leaves_a_table_and_goes_on(capsys, tmp_path):
    file, out = tmp_path / "s.yaml", tmp_path / "out"
    file.write_text("map: demo\nhorizon: [5, 6]\nmodes: [crawl, biped]\n")
    code, printed, _ = run(capsys, "sweep", str(file), "--out", str(out), "--workers", "1")
    assert code == 0 and printed.startswith("4 settings; 0 without a plan")
    assert (out / "rows.jsonl").read_text().count("\n") == 5
    code, _, err = run(capsys, "sweep", str(file), "--out", str(out))
    assert code == 2 and "--resume" in err
    code, printed, _ = run(capsys, "sweep", str(file), "--out", str(out), "--resume")
    assert code == 0 and "4 of them from before" in printed


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("map: dmeo\nhorizon: 4\n", "Did you mean 'demo'"),
        ("map: demo\nhorizn: 4\n", "Did you mean 'horizon'"),
        ("map: demo\nhorizon: []\n", "empty list"),
    ],
)
def test_a_mistake_in_a_sweep_file_is_one_line_and_leaves_nothing(capsys, tmp_path, text, says):
    file = tmp_path / "s.yaml"
    file.write_text(text)
    code, out, err = run(capsys, "sweep", str(file), "--out", str(tmp_path / "out"))
    assert code == 2 and out == ""
    assert err.startswith("mobius: ") and err.count("\n") == 1 and says in err
    assert list(tmp_path.iterdir()) == [file]


def test_plan_draws_the_plan_that_it_prints(capsys, tmp_path):
    picture = tmp_path / "p.png"
    code, _, _ = run(capsys, "plan", "demo", "--horizon", "9", "--png", str(picture))
    assert code == 0 and picture.read_bytes().startswith(b"\x89PNG")


def test_unknown_verb_and_option_stop_with_a_hint(capsys):
    code, _, err = run(capsys, "pln", "demo")
    assert code == 2 and "Did you mean 'plan'" in err
    code, _, err = run(capsys, "plan", "demo", "--horizn", "3")
    assert code == 2 and "--horizon" in err


def test_a_goal_out_of_reach_is_infeasible_in_json_too(capsys):
    code, out, err = run(capsys, "plan", "demo", "--modes", "roll", "--json")
    assert code == 1 and err.startswith("mobius: ")
    plan = json.loads(out)
    assert plan["status"] == "infeasible" and plan["steps"] == [] and plan["objective"] is None


def attribute_docs(verb: str) -> dict[str, str]:
    """The docstring below each field of a verb's class."""
    tree = ast.parse(textwrap.dedent(inspect.getsource(VERBS[verb]))).body[0]
    docs = {}
    for field, doc in pairwise(tree.body):  # type: ignore[attr-defined]
        if isinstance(field, ast.AnnAssign) and isinstance(doc, ast.Expr):
            docs[field.target.id] = doc.value.value  # type: ignore[union-attr, attr-defined]
    return docs


@pytest.mark.parametrize("verb", sorted(VERBS))
def test_help_explains_every_option(capsys, verb):
    code, out, _ = run(capsys, verb, "--help")
    assert code == 0
    told = "".join(re.sub(r"[│╭╰─╮╯|]", " ", out).split())
    docs = attribute_docs(verb)
    assert set(docs) == {f.name for f in fields(VERBS[verb])}  # type: ignore[arg-type]
    for name, doc in docs.items():
        assert "".join(doc.split()) in told, f"{verb}: --{name} is not explained"
