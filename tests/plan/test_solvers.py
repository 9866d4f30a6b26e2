"""Independent solvers agree with the exact search, and are found by name."""

from __future__ import annotations

import json
import sys
import tomllib
from dataclasses import dataclass, replace
from importlib import metadata
from pathlib import Path

import numpy as np
import pytest

from mobius.cli import main
from mobius.errors import InvalidInput, MissingDependency, MobiusError, PlanError, UnknownName
from mobius.plan import (
    NoPlan,
    Problem,
    Weights,
    build_problem,
    check,
    literal_problem,
    objective_of,
    reconstructed_map,
    solve,
)
from mobius.plan.solvers import BUILT_IN, GROUP, solver_names, solver_of
from mobius.plan.solvers.brute import number_of_paths
from mobius.plan.solvers.covers import discs_over, rectangles_over
from mobius.plan.solvers.scip import scip
from mobius.plan.solvers.table_iv import table_iv
from mobius.types import GridMap, Plan

MAX_PATHS = 800


def value_of(name: str, problem: Problem) -> float:
    """The proven optimum, -inf where there is no plan."""
    try:
        plan = solver_of(name)(problem, None)
    except NoPlan:
        return -np.inf
    check(problem, plan)
    assert plan.status == "optimal"
    return plan.objective


def small(rng: np.random.Generator, random_problem) -> Problem:
    """A random problem with the largest T <= 6 that leaves few paths."""
    p = replace(random_problem(rng), horizon=6)
    while number_of_paths(p) > MAX_PATHS:
        p = replace(p, horizon=p.horizon - 1)
    return p


@pytest.mark.parametrize("seed", range(4))
def test_exact_didp_and_brute_force_agree_on_all_options(seed, random_problem):
    pytest.importorskip("didppy")
    rng = np.random.default_rng(100 + seed)
    feasible = 0
    for _ in range(12):
        p = small(rng, random_problem)
        truth = value_of("brute", p)
        assert value_of("exact", p) == pytest.approx(truth, abs=1e-6)
        assert value_of("didp", p) == pytest.approx(truth, abs=1e-6)
        feasible += truth > -np.inf
    assert feasible > 4


def test_repaired_table_iv_agrees_on_all_options(random_problem):
    pytest.importorskip("pyscipopt")
    rng = np.random.default_rng(7)
    for _ in range(8):
        p = small(rng, random_problem)
        p = replace(p, horizon=min(p.horizon, 4))
        assert value_of("scip", p) == pytest.approx(value_of("exact", p), abs=1e-6)


@pytest.mark.parametrize(("name", "maps"), [("didp", 14), ("scip", 8)])
def test_prices_changes_of_mode_and_footprints_agree(name, maps, random_problem, dressed):
    pytest.importorskip({"didp": "didppy", "scip": "pyscipopt"}[name])
    rng = np.random.default_rng(11)
    for n in range(maps):
        p = dressed(rng, random_problem(rng, side=(3, 4)))
        p = replace(p, horizon=4, seen=rng.random(p.grid.shape) < 0.2 if n % 2 else None)
        assert value_of(name, p) == pytest.approx(value_of("exact", p), abs=1e-5)


def test_what_moves_is_refused_by_name_where_it_cannot_be_stated(picture):
    p = build_problem(picture("S..G"), horizon=1, closed=np.ones((1, 4, 1)))
    for name in ("didp", "scip", "gurobi"):
        with pytest.raises(PlanError, match=rf"'{name}' cannot state the option Problem.closed"):
            solver_of(name)(p, None)


LITERAL = {
    "axis": "..rr\n.##.\n.c..\ncc..",
    "box": ".#..\n.b..\n..#.\n....",
    "diagonal": "....x\n..c..\n.ccc.\n..c#.\n.....",
}


@pytest.mark.parametrize("connectivity", LITERAL)
def test_table_iv_as_printed_agrees(connectivity, picture):
    pytest.importorskip("pyscipopt")
    grid = picture(LITERAL[connectivity])
    ends = grid.center_of([[0, 0], [grid.shape[0] - 1, grid.shape[1] - 2]])
    grid = GridMap("drawing", grid.cell, np.zeros(3), grid.blocked, grid.allowed, *ends)
    p = literal_problem(grid, horizon=3, connectivity=connectivity)
    truth = solve(p)
    for reading in ("literal", "repaired"):
        plan = scip(p, None, reading=reading)
        check(p, plan)
        assert (plan.status, plan.objective) == ("optimal", pytest.approx(truth.objective))


@pytest.mark.parametrize("name", ["didp", "scip"])
def test_a_deadline_is_kept_and_the_bound_is_honest(name):
    pytest.importorskip({"didp": "didppy", "scip": "pyscipopt"}[name])
    n = 9
    blocked = np.zeros((n, n), dtype=bool)
    blocked[1::2, 1:] = True
    p = Problem(GridMap("comb", 0.5, np.zeros(3), blocked, np.full((n, n), 7)), (0, 0), (8, 8), 30)
    best = solve(p, deadline_s=None)
    try:
        plan = solver_of(name)(p, 0.3)
    except PlanError as error:
        assert "more time" in str(error)
        return
    check(p, plan)
    assert plan.objective <= best.bound + 1e-6
    assert plan.bound >= best.objective - 1e-6


@pytest.mark.parametrize("name", ["exact", "didp", "scip", "brute"])
def test_no_plan_is_proven_and_said(name, picture):
    library = {"didp": "didppy", "scip": "pyscipopt"}.get(name)
    if library:
        pytest.importorskip(library)
    p = build_problem(picture("S.#.G"), horizon=2, must_reach=True)
    with pytest.raises(NoPlan):
        solver_of(name)(p, None)


def test_brute_force_refuses_what_would_take_too_long():
    p = build_problem(reconstructed_map(8), horizon=8)
    with pytest.raises(PlanError, match=r"at most 200000; this problem has .*e\+"):
        solver_of("brute")(p, None)


def test_brute_force_out_of_time_has_no_answer():
    p = build_problem(reconstructed_map(5), horizon=4)
    with pytest.raises(PlanError, match="within 0 s"):
        solver_of("brute")(p, 0.0)


# --- the table ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (dict(count="sweep"), "count='sweep'"),
        (dict(check="swept"), "check='swept'"),
        (dict(early_stop=True), "early_stop"),
        (dict(cell_cost=np.ones((4, 4))), "cell_cost"),
        (dict(switch_cost={("crawl", "roll"): 1.0}), "switch_cost"),
        (dict(footprint=((1, 0),)), "footprint"),
        (dict(seen=np.ones((4, 4))), "seen"),
        (dict(weights=Weights(per_s=1.0)), "per_s"),
    ],
)
def test_the_printed_table_says_what_it_cannot_state(options, says):
    p = replace(literal_problem(reconstructed_map(4), horizon=2), **options)
    with pytest.raises(PlanError, match=says):
        table_iv(p, "literal")
    table_iv(p, "repaired")


def test_bad_arguments_of_the_table_are_refused():
    p = literal_problem(reconstructed_map(4), horizon=2)
    with pytest.raises(UnknownName, match="literal"):
        table_iv(p, "litteral")
    with pytest.raises(InvalidInput, match="epsilon"):
        table_iv(p, "literal", epsilon=0.0)
    with pytest.raises(InvalidInput, match="M: expected"):
        table_iv(p, "literal", M=-1.0)
    with pytest.raises(PlanError, match="has no M"):
        table_iv(p, "repaired", M=100.0)


def test_an_M_that_is_too_small_cuts_off_every_plan():
    pytest.importorskip("pyscipopt")
    p = literal_problem(reconstructed_map(4), horizon=3)
    assert solve(p).status == "optimal"
    with pytest.raises(NoPlan):
        scip(p, None, reading="literal", M=2.0)


def test_a_repaired_table_has_no_quadratic_and_a_literal_one_has():
    p = literal_problem(reconstructed_map(8), horizon=2)
    assert not table_iv(p, "repaired").model.quadratic
    # the goal, and one disc at T = 2 departures
    assert len(table_iv(p, "literal").model.quadratic) == 1 + 2 * len(discs_of(p))


def discs_of(p: Problem) -> list:
    return [d for b in (1, 2) for d in discs_over(p.grid.allowed == b, spare=p.grid.blocked)]


def test_a_drawn_disc_is_found_again_as_one():
    i, j = np.indices((12, 12))
    inside = (i - 6) ** 2 + (j - 5) ** 2 <= 9
    assert discs_over(inside, spare=np.zeros_like(inside)) == [((6, 5), 9)]


def test_covers_hold_exactly_the_set(rng):
    i, j = np.indices((9, 7))
    for _ in range(20):
        cells, spare = rng.random((2, 9, 7)) < 0.4
        held = np.zeros((9, 7), dtype=bool)
        for (x, y), r2 in discs_over(cells, spare=spare & ~cells):
            held |= (i - x) ** 2 + (j - y) ** 2 <= r2
        assert np.array_equal(held & ~(spare & ~cells), cells)
        held[:] = False
        for (x0, y0), (x1, y1) in rectangles_over(cells):
            held[x0 : x1 + 1, y0 : y1 + 1] = True
        assert np.array_equal(held, cells)


# --- by name -----------------------------------------------------------------------------


def test_the_package_declares_the_solvers_it_knows():
    pyproject = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text())
    assert pyproject["project"]["entry-points"][GROUP] == BUILT_IN


def declare(monkeypatch, *points: tuple[str, str]) -> None:
    """Let installed packages declare these entry points, and no others."""
    found = metadata.EntryPoints(metadata.EntryPoint(n, v, GROUP) for n, v in points)
    monkeypatch.setattr(metadata, "entry_points", lambda group: found.select(group=group))


def lazy(problem: Problem, deadline_s: float | None) -> Plan:
    """A user's solver: stay where you are."""
    cells = [problem.start]
    value = objective_of(problem, cells, [])
    return Plan(np.array(cells), (), problem.grid.center_of(cells), "feasible", value, 1e9, 0.0)


def test_a_users_entry_point_is_a_solver(monkeypatch, picture):
    module = type(sys)("my_solvers")
    module.lazy = lazy
    monkeypatch.setitem(sys.modules, "my_solvers", module)
    declare(monkeypatch, ("lazy", "my_solvers:lazy"), ("exact", BUILT_IN["exact"]))
    assert "lazy" in solver_names()
    p = build_problem(picture("S..G"), horizon=3, early_stop=True)
    plan = solver_of("lazy")(p, None)
    check(p, plan)
    with pytest.raises(UnknownName, match="Did you mean 'lazy'"):
        solver_of("lasy")
    assert solver_of("exact")(p, None).status == "optimal"


@pytest.mark.parametrize(
    ("name", "value", "says"),
    [
        ("gone", "no_such_package:solver", "no_such_package"),
        ("gone", "mobius.plan:no_such_function", "no_such_function"),
        ("data", "mobius.plan.solvers:BUILT_IN", "expected a function"),
        ("exact", "my_solvers:mine", "claimed by"),
    ],
)
def test_a_broken_entry_point_says_so(monkeypatch, name, value, says):
    declare(monkeypatch, (name, value))
    with pytest.raises(PlanError, match=says):
        solver_of(name)


def test_an_unknown_solver_lists_those_there_are():
    with pytest.raises(UnknownName, match=r"Did you mean 'scip'\? Known: brute, didp, exact"):
        solver_of("scipp")


@pytest.mark.parametrize(
    ("name", "library", "says"),
    [
        ("didp", "didppy", r"pip install 'mobius\[exact\]'"),
        ("scip", "pyscipopt", r"pip install 'mobius\[baseline\]'"),
        ("gurobi", "gurobipy", "pip install gurobipy; .*20 x 20"),
    ],
)
def test_a_missing_library_says_what_to_install(monkeypatch, picture, name, library, says):
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(MobiusError, match=says) as caught:
        solver_of(name)(build_problem(picture("S..G"), horizon=1), None)
    assert name == "gurobi" or caught.type is MissingDependency


@dataclass(frozen=True, eq=False)
class NewProblem(Problem):
    """A problem with an option that came after these solvers."""

    novelty: float = 0.0


@pytest.mark.parametrize("name", ["didp", "scip", "gurobi", "brute"])
def test_an_option_a_solver_does_not_know_is_refused_not_ignored(name, picture):
    p = build_problem(picture("S..G"), horizon=1)
    new = NewProblem(p.grid, p.start, p.goal, 1, novelty=1.0)
    with pytest.raises(PlanError, match=rf"'{name}' cannot state .*novelty"):
        solver_of(name)(new, None)


# --- on the command line -----------------------------------------------------------------


def test_the_command_line_takes_a_solver_and_a_count(capsys):
    argv = ["plan", "demo", "--horizon", "3", "--count", "endpoint", "--json"]
    shown = []
    for name in ("exact", "brute"):
        assert main([*argv, "--solver", name]) == 0
        shown.append(capsys.readouterr().out)
    one, two = (s.split('"objective": ')[1].split(",")[0] for s in shown)
    assert one == two


def test_the_command_line_prices_time_energy_changes_and_sight(capsys, tmp_path):
    costs = tmp_path / "costs.json"
    modes = {name: {"m_per_s": 0.5, "J_per_m": 10.0} for name in ("biped", "crawl", "roll")}
    costs.write_text(json.dumps({"format": "mobius travel 1", "modes": modes}))

    def objective(*argv: str) -> float:
        assert main(["plan", "demo", "--horizon", "4", "--json", *argv]) == 0
        return json.loads(capsys.readouterr().out)["objective"]

    plain = objective()
    assert objective("--costs", str(costs), "--per-s", "2", "--per-j", "0.1") < plain
    assert objective("--footprint", "2", "--switch-cost", "3") > plain


@pytest.mark.parametrize(
    ("argv", "says"),
    [
        (("--solver", "exat"), "Did you mean 'exact'"),
        (("--count", "swep"), "Did you mean 'sweep'"),
        (("--solver", "brute", "--horizon", "30"), "tries every path"),
        (("--switch-cost", "-1"), "--switch-cost: expected points >= 0, got -1"),
        (("--per-s", "nan"), "--per-s: expected points >= 0, got nan"),
        (("--costs", "none.json"), "add --per-s or --per-j"),
        (("--costs", "none.json", "--per-j", "1"), "there is no such file"),
        (("--footprint", "-2"), "radius of 0 to 30 cells"),
    ],
)
def test_a_mistake_on_the_command_line_is_one_line(capsys, argv, says):
    assert main(["plan", "demo", *argv]) == 2
    out, err = capsys.readouterr()
    assert out == "" and err.startswith("mobius: ") and err.count("\n") == 1
    assert says in err


def test_weights_with_fractions_are_solved_too(picture):
    pytest.importorskip("didppy")
    p = build_problem(
        picture("S..\n...\n..G"),
        horizon=4,
        weights=Weights(W_exp=1.7, W_goal=0.3, P={"biped": 0.1, "crawl": 0.9, "roll": 2.5}),
    )
    assert value_of("didp", p) == pytest.approx(value_of("exact", p))
