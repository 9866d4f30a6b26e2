"""The gap over time: a whole PNG with both curves, or nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from mobius.errors import InvalidInput
from mobius.plan import build_problem, reconstructed_map, solve
from mobius.types import Plan
from mobius.view.gap_picture import draw_gap
from mobius.view.palette import rgb

TRACE = [(0.002, -np.inf, 900.0), (0.01, -np.inf, 800.0), (0.02, 400.0, 800.0), (0.5, 700.0, 750.0)]
BLUE, ORANGE = "#2a7fd4", "#d9772b"


def plan_of(objective: float, bound: float) -> Plan:
    problem = build_problem(reconstructed_map(4), horizon=2)
    plan = solve(problem)
    return replace(plan, status="feasible", objective=objective, bound=bound, solve_s=1.0)


def pixels_of(path, colour: str) -> int:
    image = np.asarray(Image.open(path).convert("RGB")).astype(int)
    return int((np.abs(image - np.array([255 * v for v in rgb(colour)])).max(axis=-1) < 4).sum())


def test_both_curves_are_drawn_and_nothing_else_is_left(tmp_path):
    draw_gap(tmp_path / "g.png", TRACE, plan_of(700.0, 750.0), title="map")
    assert pixels_of(tmp_path / "g.png", BLUE) > 200
    assert pixels_of(tmp_path / "g.png", ORANGE) > 200
    assert [p.name for p in tmp_path.iterdir()] == ["g.png"]


def test_a_search_that_found_its_optimum_at_once_is_drawn_too(tmp_path):
    plan = replace(plan_of(700.0, 700.0), status="optimal", solve_s=0.002)
    draw_gap(tmp_path / "g.png", [(0.001, -np.inf, 700.0), (0.002, 700.0, 700.0)], plan)
    assert pixels_of(tmp_path / "g.png", ORANGE) > 50


def test_a_gap_that_is_not_closed_says_how_large_it_is():
    from mobius.view.gap_picture import _verdict

    assert _verdict(plan_of(700.0, 750.0)) == "700 points, gap 50 (7.1 %) after 1 s"
    optimal = replace(plan_of(700.0, 700.0), status="optimal", solve_s=0.0125)
    assert _verdict(optimal) == "700 points, proven optimal after 12.5 ms"


@pytest.mark.parametrize(("name", "trace"), [("g.jpg", TRACE), ("g.png", [])])
def test_another_suffix_and_an_empty_trace_are_refused(tmp_path, name, trace):
    with pytest.raises(InvalidInput):
        draw_gap(tmp_path / name, trace, plan_of(700.0, 750.0))
    assert list(tmp_path.iterdir()) == []
