"""``mobius plan``: what a map or a horizon lacks, told in one line, and no half-made files."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image

from mobius.cli import main

PNG = b"\x89PNG"


def run(capsys, *argv: str) -> tuple[int, str, str]:
    code = main(["plan", *argv])
    out, err = capsys.readouterr()
    return code, out, err


@pytest.fixture
def nav2(tmp_path):
    """Writes a map of 0.1 m pixels: free, except what ``walls`` says; returns the yaml."""

    def write(size=(80, 50), walls=(), resolution=0.1, notes="", name="m") -> str:
        pixels = np.full(size[::-1], 254, np.uint8)
        for x0, x1, y0, y1 in walls:
            pixels[y0:y1, x0:x1] = 0
        Image.fromarray(pixels).save(tmp_path / f"{name}.pgm")
        path = tmp_path / f"{name}.yaml"
        path.write_text(
            f"image: {name}.pgm\nresolution: {resolution}\norigin: [0.0, 0.0, 0.0]\nnegate: 0\n"
            "occupied_thresh: 0.65\nfree_thresh: 0.25\n"
            f"mobius:\n  start: [1.25, 1.25]\n  goal: [6.75, 1.25]\n{notes}"
        )
        return str(path)

    return write


def refused(capsys, tmp_path, *argv: str) -> str:
    """Run with every output asked for: an exit code, one line, no file."""
    before = sorted(tmp_path.iterdir())
    files = ("--png", str(tmp_path / "p.png"), "--gap-png", str(tmp_path / "g.png"))
    code, out, err = run(capsys, *argv, *files, "--json")
    assert code in (1, 2)
    assert out == "" or json.loads(out)["status"] == "infeasible"
    assert err.startswith("mobius: ") and err.count("\n") == 1
    assert "Traceback" not in err
    assert sorted(tmp_path.iterdir()) == before
    return err


@pytest.mark.parametrize("what", ["start", "goal"])
def test_a_blocked_place_is_told_with_a_free_one(capsys, tmp_path, nav2, what):
    err = refused(capsys, tmp_path, nav2(walls=[(35, 45, 0, 20)]), f"--{what}", "4.0", "4.0")
    assert f"{what} (4.00, 4.00) m lies in an obstacle" in err and "nearest free cell" in err


def test_a_wall_between_start_and_goal_is_named_in_metres(capsys, tmp_path, nav2):
    err = refused(capsys, tmp_path, nav2(walls=[(39, 41, 0, 50)]))
    assert "cannot be reached" in err and "the wall in between (x " in err


def test_a_gap_for_the_narrower_policy_only_says_which_to_type(capsys, tmp_path, nav2):
    gap = nav2(walls=[(39, 41, 0, 33), (39, 41, 41, 50)])  # 0.8 m wide
    err = refused(capsys, tmp_path, gap)
    assert "cannot be reached" in err and err.rstrip().endswith("add --policy rough")
    code, out, _ = run(capsys, gap, "--policy", "rough", "--modes", "crawl", "--json")
    assert code == 0 and json.loads(out)["status"] == "optimal"
    closed = refused(capsys, tmp_path, nav2(walls=[(39, 41, 0, 50)], name="closed"))
    assert "--policy" not in closed


def test_regions_that_force_different_modes_are_named(capsys, tmp_path, nav2):
    regions = (
        "  shapes:\n"
        "  - {type: circle, center: [3.0, 2.0], radius: 1.0, mode: biped}\n"
        "  - {type: circle, center: [4.0, 2.0], radius: 1.0, mode: roll}\n"
    )
    assert "overlaps" in refused(capsys, tmp_path, nav2(notes=regions))


def test_a_horizon_that_is_too_short_for_the_goal_says_by_how_much(capsys, tmp_path, nav2):
    err = refused(capsys, tmp_path, nav2(), "--horizon", "1", "--must-reach")
    assert "horizon 1 is too short" in err and "smallest horizon is 4" in err
    assert "3 more" in err


def test_a_plan_that_stops_short_of_the_goal_says_so(capsys, nav2):
    code, out, err = run(capsys, nav2(), "--horizon", "1", "--json")
    assert code == 0 and json.loads(out)["status"] == "optimal"
    assert "takes at least 4 steps: horizon 1 is 3 too short" in err and err.count("\n") == 1
    code, _, err = run(capsys, nav2(), "--horizon", "9", "--must-reach")
    assert code == 0 and err == ""


def test_an_empty_map_and_one_that_the_robot_does_not_fit_on(capsys, tmp_path, nav2):
    (tmp_path / "none.map").write_text("type octile\nheight 0\nwidth 0\nmap\n")
    assert "height 0" in refused(capsys, tmp_path, str(tmp_path / "none.map"))
    (tmp_path / "empty.yaml").write_text("")
    assert "empty file" in refused(capsys, tmp_path, str(tmp_path / "empty.yaml"))
    (tmp_path / "one.map").write_text("type octile\nheight 1\nwidth 1\nmap\n.\n")
    place = ("--start", "0.25", "0.25", "--goal", "0.25", "0.25")
    err = refused(capsys, tmp_path, str(tmp_path / "one.map"), *place)
    assert "no cell of this map is free" in err


def test_a_map_of_one_cell_has_a_plan_of_no_steps(capsys, tmp_path, nav2):
    one = nav2(size=(1, 1), resolution=2.0, notes="  cell: 2.0\n")
    place = ("--start", "1.0", "1.0", "--goal", "1.0", "1.0")
    code, out, _ = run(capsys, one, *place, "--json")
    assert code == 0 and len(json.loads(out)["steps"]) == 1
    err = refused(capsys, tmp_path, one, *place, "--horizon", "2")
    assert "the map has no other cell" in err and "--allow-stay or --early-stop" in err
    code, _, _ = run(capsys, one, *place, "--horizon", "2", "--allow-stay")
    assert code == 0


def test_the_verb_as_the_issue_writes_it(capsys, tmp_path):
    plan_png, gap_png = tmp_path / "p.png", tmp_path / "g.png"
    options = ("--deadline", "1", "--horizon", "9", "--count", "sweep", "--solver", "exact")
    pictures = ("--png", str(plan_png), "--gap-png", str(gap_png))
    code, out, _ = run(capsys, "demo", *options, *pictures, "--json")
    assert code == 0 and out.count("\n") == 1
    assert len(json.loads(out)["steps"]) == 10
    assert plan_png.read_bytes().startswith(PNG) and gap_png.read_bytes().startswith(PNG)


@pytest.mark.parametrize(
    ("solver", "package"), [("didp", "didppy"), ("scip", "pyscipopt"), ("gurobi", "gurobipy")]
)
def test_every_solver_answers_or_says_what_to_install(capsys, solver, package):
    from importlib.util import find_spec

    options = ("--deadline", "20", "--horizon", "2", "--count", "sweep", "--solver", solver)
    code, out, err = run(capsys, "demo", *options, "--json")
    if find_spec(package) is None:
        assert code == 2 and f"'{package}'" in err and "pip install" in err
    else:
        assert code == 0 and json.loads(out)["status"] == "optimal"


def test_a_reader_that_has_gone_is_no_error_of_ours():
    """As ``mobius plan ... | head`` does it."""
    argv = [sys.executable, "-m", "mobius.cli", "plan", "demo", "--horizon", "8"]
    process = subprocess.Popen(argv, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None and process.stderr is not None
    process.stdout.close()
    assert "Traceback" not in process.stderr.read()
    assert process.wait() == 128 + 13


def test_the_room_of_a_policy_is_known_where_opengl_is_broken():
    argv = [sys.executable, "-m", "mobius.cli", "plan", "arena", "--policy", "rough", "--json"]
    broken = {**os.environ, "MUJOCO_GL": "osmesa", "PYOPENGL_PLATFORM": "osmesa"}
    done = subprocess.run(argv, env=broken, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(done.stdout)["steps"]
