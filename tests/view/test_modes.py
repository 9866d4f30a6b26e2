"""The report's section on modes."""

import re

import numpy as np
import pytest

from mobius.view.modes import modes_section
from mobius.view.palette import MODE_COLOURS
from mobius.view.report import build_report


@pytest.fixture
def run(record):
    record.summary |= {
        "recoveries": 1,
        "falls": 1,
        "modes": {
            "crawl": {"time_s": 19.0, "path_m": 5.7, "energy_J": 760.0, "cells": 11,
                      "J_per_m": 133.0, "J_per_cell": 69.0},
            "biped": {"time_s": 1.0, "path_m": 0.0, "energy_J": 52.5, "cells": 0,
                      "J_per_m": None, "J_per_cell": None},
        },
        "mode_switches": {"steps": 10, "planned": 2, "planned_per_step": 0.2,
                          "driven": 1, "driven_per_step": 0.1},
        "forced_modes": {"biped": {"planned": 2, "time_s": 1.0, "share": 0.25, "used": False}},
        "rolls": 3,
        "rolls_without_room": 1,
        "motions_failed": 0,
        "replans": [{"t": 4.0, "why": "map", "status": "optimal", "solve_ms": 2.0, "problem": ""}],
    }  # fmt: skip
    return record


def test_it_tells_energy_switches_falls_rolls_and_new_plans(run):
    text = re.sub(r"<[^>]+>", " ", modes_section(run))
    for words in (
        "133 J/m", "760 J", "1 falls, 1 recovered", "3 rolls, 1 left out", "0.200 per step",
        "25 %", "map",
    ):  # fmt: skip
        assert words in text, words


def test_the_strip_is_as_long_as_the_run(run):
    rects = re.findall(r'<rect x="([\d.]+)"[^>]* width="([\d.]+)"', modes_section(run))
    ends = [float(x) + float(w) for x, w in rects]
    assert len(rects) == 2 and ends[0] == pytest.approx(float(rects[1][0]), abs=0.05)
    assert ends[-1] == pytest.approx(1000.0, abs=0.1)


def test_a_run_without_those_figures_has_no_such_section(record):
    assert modes_section(record) == ""
    assert "<h2>Modes</h2>" not in build_report(record)


def test_the_way_gone_is_drawn_in_the_colours_of_its_modes(run):
    page = build_report(run)
    ways = re.findall(r'<polyline points="[^"]*" class="line map" stroke="(#\w+)"', page)
    assert ways == [MODE_COLOURS["crawl"], MODE_COLOURS["biped"]]
    run.modes = ["crawl"] * len(run.t)
    assert 'class="line map" stroke' not in build_report(run)


def test_later_plans_are_drawn_thinner(run):
    page = build_report(run, later=[run.plan])
    assert page.count("stroke-width:3") == len(run.plan.modes)
    assert np.isfinite(run.true_p).all()
