"""The pilot, with a point robot that obeys: when it plans anew, and from where."""

import numpy as np
import pytest

from mobius.errors import MapError
from mobius.geometry import rpy_to_quat
from mobius.mission.pilot import Pilot
from mobius.mission.prepare import open_world, plan_mission
from mobius.types import Mode, StateEstimate
from mobius.world import with_obstacles
from mobius.world.shapes import Rectangle

DT = 0.1


@pytest.fixture(scope="module")
def world():
    return open_world("arena")


class Point:
    """Crawls exactly as told."""

    def __init__(self, pilot, xy):
        self.pilot, self.p, self.yaw, self.t = pilot, np.array(xy, dtype=float), 0.0, 0.0
        self.track = []

    def step(self, actual=Mode.CRAWL):
        q, zero = rpy_to_quat(0.0, 0.0, self.yaw), np.zeros(3)
        belief = StateEstimate(self.t, [*self.p, 0.27], q, zero, zero, np.ones(4))
        command = self.pilot.command(belief, DT, actual)
        if actual is Mode.CRAWL:
            c, s = np.cos(self.yaw), np.sin(self.yaw)
            self.p = self.p + np.array([[c, -s], [s, c]]) @ command.twist_H[:2] * DT
            self.yaw += command.twist_H[2] * DT
        self.t += DT
        self.track.append(self.p)
        return command

    def until(self, t):
        while self.t < t and not self.pilot.arrived:
            self.step()


def set_out(world):
    plan = plan_mission(world, [Mode.CRAWL])
    pilot = Pilot(world, plan, [Mode.CRAWL])
    return pilot, Point(pilot, world.grid.start)


def why(pilot):
    return [r.why for r in pilot.replans]


def test_it_stands_first_and_then_arrives_without_a_new_plan(world):
    pilot, robot = set_out(world)
    robot.until(1.4)
    np.testing.assert_array_equal(robot.p, world.grid.start)
    robot.until(60.0)
    assert pilot.arrived and pilot.replans == []
    assert np.linalg.norm(robot.p - world.grid.goal) < 0.1


def test_a_robot_that_was_carried_off_plans_from_there(world):
    pilot, robot = set_out(world)
    robot.until(5.0)
    corners = np.array([[1.25, -0.75], [-1.25, 0.75]])
    away = max(corners, key=pilot.follower.off_plan)
    robot.p = away
    robot.until(60.0)
    assert why(pilot) == ["off plan"] and pilot.arrived
    np.testing.assert_allclose(pilot.replans[0].plan.xy_M[0], away, atol=0.4)


def test_a_changed_map_is_planned_on_at_once_and_kept_clear_of(world):
    pilot, robot = set_out(world)
    robot.until(2.0)
    side = np.sign(pilot.follower.legs[0].xy[:, 1].sum() + pilot.follower.legs[0].xy[:, 0].sum())
    block = Rectangle((0.0, -1.2), (0.4, 0.8)) if side > 0 else Rectangle((0.0, 1.2), (0.4, 0.8))
    changed = with_obstacles(world, [block])
    pilot.know(changed)
    robot.step()
    assert why(pilot) == ["map"]
    robot.until(80.0)
    assert pilot.arrived and not block.contains(np.array(robot.track), grown=0.3).any()


def test_where_there_is_no_way_it_stands_until_there_is_one(world):
    pilot, robot = set_out(world)
    robot.until(2.0)
    walls = [Rectangle((0.0, 1.1), (0.2, 1.0)), Rectangle((0.0, -1.1), (0.2, 1.0))]
    pilot.know(with_obstacles(world, walls))
    before = robot.p
    robot.until(8.0)
    assert pilot.stuck and not pilot.arrived and pilot.replans[0].plan is None
    assert pilot.replans[0].problem and len(pilot.replans) == 1
    assert np.linalg.norm(robot.p - before) < 0.05
    pilot.know(world)
    robot.until(80.0)
    assert pilot.arrived and why(pilot) == ["map", "map"]


def test_after_a_fall_it_waits_for_the_recovery_and_plans_anew(world):
    pilot, robot = set_out(world)
    robot.until(4.0)
    for _ in range(30):
        command = robot.step(Mode.RECOVER)
        assert command.mode is Mode.CRAWL and not command.twist_H.any()
    assert pilot.replans == []
    robot.step()
    assert why(pilot) == ["fall"]
    robot.until(80.0)
    assert pilot.arrived


def test_from_a_blocked_cell_it_plans_from_the_nearest_free_one(world):
    pilot, robot = set_out(world)
    robot.until(2.0)
    blocked = np.argwhere(world.grid.blocked)
    near = np.linalg.norm(world.grid.center_of(blocked) - robot.p, axis=1)
    robot.p = world.grid.center_of(blocked[near.argmin()])
    pilot.know(world)
    robot.step()
    plan = pilot.replans[0].plan
    assert plan is not None and not world.grid.blocked[tuple(plan.cells[0])]


def test_a_planning_that_fails_is_told_in_its_words(world):
    def planning(*_, **__):
        raise MapError("no map today")

    pilot = Pilot(world, plan_mission(world, [Mode.CRAWL]), [Mode.CRAWL], planning=planning)
    robot = Point(pilot, world.grid.start)
    robot.until(2.0)
    pilot.know(world)
    robot.step()
    assert pilot.stuck and pilot.replans[0].problem == "no map today"
