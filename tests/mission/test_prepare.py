"""Plans in several modes on the shipped map, and what is told where there is none."""

import itertools
import json
from dataclasses import replace

import numpy as np
import pytest

from mobius.errors import InvalidInput, PlanError
from mobius.mission.prepare import open_world, path_heading, plan_mission, with_ends
from mobius.mission.prices import read_prices
from mobius.plan.travel import FORMAT
from mobius.types import Mode, Plan

ALL = (Mode.CRAWL, Mode.BIPED, Mode.ROLL)


@pytest.fixture(scope="module")
def world():
    return open_world("multimodal")


def test_the_shipped_map_needs_every_body(world):
    plan = plan_mission(world, ALL)
    assert plan.status == "optimal" and set(plan.modes) == set(ALL)
    for without in (Mode.BIPED, Mode.ROLL):
        with pytest.raises(PlanError):
            plan_mission(world, [m for m in ALL if m is not without])


def test_where_a_forced_body_has_no_room_the_error_says_so(world):
    biped = world.grid.allowed == Mode.BIPED.bit
    cramped = replace(world, clearance=np.where(biped, 0.5, world.clearance))
    with pytest.raises(PlanError, match=r"biped needs 0\.58 m to obstacles, there are 0\.50 m"):
        plan_mission(cramped, ALL)


def test_plans_pay_for_what_was_measured(world, tmp_path):
    file = tmp_path / "costs.json"
    rows = {m.value: {"m_per_s": 0.3, "J_per_m": 100.0} for m in ALL}
    change = [{"from": "crawl", "to": "biped", "s": 5.0, "J": 200.0}]
    text = {"format": FORMAT, "modes": rows, "switches": change}
    file.write_text(json.dumps(text))
    free, paid = (
        plan_mission(world, ALL),
        plan_mission(world, ALL, prices=read_prices(file, per_J=0.01)),
    )
    changes = sum(a is Mode.CRAWL and b is Mode.BIPED for a, b in itertools.pairwise(paid.modes))
    metres = np.linalg.norm(np.diff(paid.xy_M, axis=0), axis=1).sum()
    assert changes >= 1
    assert free.objective - paid.objective == pytest.approx(metres + 2.0 * changes)
    with pytest.raises(InvalidInput, match="add --per-s or --per-j"):
        read_prices(file)


def test_a_plan_may_begin_where_the_robot_is(world):
    start = np.array([8.7, 1.8])
    plan = plan_mission(world, ALL, start=start, last_mode=Mode.BIPED)
    path = with_ends(plan, world.grid, start=start)
    np.testing.assert_array_equal(path.xy_M[0], start)
    np.testing.assert_array_equal(path.xy_M[-1], world.grid.goal)


def test_the_ends_are_never_rolled(world):
    xy = np.array([[8.0, 6.0], [8.0, 7.5]])
    plan = Plan(world.grid.cell_of(xy), (Mode.ROLL,), xy, "optimal", 0.0, 0.0, 0.0)
    assert with_ends(plan, world.grid).modes == (Mode.CRAWL, Mode.ROLL, Mode.CRAWL)
    assert path_heading(plan) == pytest.approx(-np.pi / 2)  # tail first


def test_a_plan_without_steps_ends_in_the_body_the_robot_is_in(world):
    xy = np.array([world.grid.goal])
    plan = Plan(world.grid.cell_of(xy), (), xy, "optimal", 0.0, 0.0, 0.0)
    assert set(with_ends(plan, world.grid, start=xy[0] + 0.1, body=Mode.BIPED).modes) == {"biped"}
