"""A short mission in physics: several bodies at hand, and an obstacle that comes on the way."""

import numpy as np
import pytest

from mobius.errors import MapError
from mobius.mission.drive import drive
from mobius.mission.prepare import open_world, plan_mission
from mobius.mission.summary import summarise
from mobius.types import Mode
from mobius.world import Scenario
from mobius.world.scenario import Event, Obstacle
from mobius.world.shapes import Rectangle

MODES = (Mode.CRAWL, Mode.BIPED)
AWAY = Rectangle((1.2, 0.7), (0.3, 0.3))


@pytest.fixture(scope="module")
def driven():
    """Half a metre of the arena; a crate comes, far away, while the robot is on its way."""
    world = open_world("arena", start=(-1.25, -0.75), goal=(-0.75, -0.75))
    scenario = Scenario(
        (Obstacle("crate", (0.3, 0.3)),), (Event("add", "crate", AWAY, 2.0, None, "line 1"),)
    )
    plan = plan_mission(world, MODES)
    return drive(world, plan, modes=MODES, scenario=scenario, seed=1)


def test_an_obstacle_that_comes_is_there_planned_on_and_no_hindrance(driven):
    assert [r.why for r in driven.pilot.replans] == ["map"]
    assert driven.pilot.replans[0].t == pytest.approx(2.0, abs=0.1)
    assert driven.stagehand.log[0]["what"] == "add"
    pose = driven.judge.mocap[-1][0]
    np.testing.assert_allclose(pose[:2], AWAY.center)
    assert driven.judge.mocap[0][0, 2] < -1.0  # before that it was nowhere
    assert driven.record.summary["ended"] == "arrived" and driven.judge.falls == []


def test_a_new_plan_on_the_way_does_not_stop_the_robot(driven):
    t = driven.record.t
    speed = np.linalg.norm(driven.record.cmd_twist_H[:, :2], axis=1)
    at = int(np.argmin(np.abs(t - driven.pilot.replans[0].t)))
    assert speed[at - 3] > 0.1 and speed[at : at + 4].min() > 0.8 * speed[at - 3]


def test_the_summary_counts_steps_of_both_plans(driven):
    s = summarise(driven, seed=1, wall_s=1.0)
    assert s["goal_reached"] and s["mode_switches"]["driven"] == 0
    assert s["mode_switches"]["steps_driven"] > 0.5
    assert [r["why"] for r in s["replans"]] == ["map"]


def test_what_physics_cannot_build_is_a_mistake_in_the_map():
    world = open_world("arena")
    scenario = Scenario((Obstacle("crate", (0.0, 1.0), area=AWAY),))
    with pytest.raises(MapError, match="physics cannot build it"):
        drive(world, plan_mission(world, MODES[:1]), scenario=scenario)
