"""The pilot, with a point robot that obeys: when it plans anew, and from where."""

import numpy as np
import pytest

from mobius.errors import MapError
from mobius.geometry import rpy_to_quat
from mobius.mission.pilot import AGAIN, AGAIN_S, GIVE_UP, GIVE_UP_AT_LAST, Pilot, footholds
from mobius.mission.prepare import open_world, plan_mission, room_of
from mobius.plan import NoPlan
from mobius.types import Mode, Plan, StateEstimate
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


def test_without_a_way_after_a_fall_it_looks_again_a_few_times(world):
    made = []

    def planning(*_, **__):
        made.append(1)
        raise NoPlan("not from here")

    pilot = Pilot(world, plan_mission(world, [Mode.CRAWL]), [Mode.CRAWL], planning=planning)
    robot = Point(pilot, world.grid.start)
    robot.until(2.0)
    robot.step(Mode.RECOVER)
    robot.step()
    assert pilot.stuck and not pilot.hopeless
    robot.until(3.0 + (AGAIN + 3) * AGAIN_S)
    assert why(pilot) == ["fall", *["again"] * AGAIN] and len(made) == 1 + AGAIN
    assert pilot.hopeless


def biped_plan(world):
    """Two legs all the way from the start, over the cells of the crawled plan."""
    plan = plan_mission(world, [Mode.CRAWL])
    modes = (Mode.BIPED,) * len(plan.modes)
    return Plan(plan.cells, modes, plan.xy_M, "feasible", 0.0, 0.0, 0.0)


def fail(robot, pilot):
    """Ask to stand up, fall over, and get up again."""
    for _ in range(300):
        if robot.step().mode is Mode.BIPED:
            break
    robot.step(Mode.STAND_UP)
    for _ in range(3):
        robot.step(Mode.RECOVER)
    robot.step()


def test_a_failed_change_is_a_failed_motion_and_given_up_where_it_failed(world):
    admitted = []

    def planning(there, modes, **_):
        near = np.linalg.norm(
            there.grid.center_of(np.moveaxis(np.indices(there.grid.shape), 0, -1)) - robot.p,
            axis=-1,
        )
        admitted.append((there.grid.allowed[near <= 0.5] & Mode.BIPED.bit).any())
        if not admitted[-1]:
            raise NoPlan("only on two legs")
        return plan

    plan = biped_plan(world)
    pilot = Pilot(world, plan, [Mode.CRAWL, Mode.BIPED], planning=planning)
    robot = Point(pilot, world.grid.start)
    for k in range(1, GIVE_UP_AT_LAST + 1):
        fail(robot, pilot)
        assert pilot.failures == k and why(pilot) == ["motion"] * k
        assert pilot.stuck is (k == GIVE_UP_AT_LAST)
        # it looks for another way first, and goes the same once more where there is none
        assert admitted[-1] is np.True_ or k == GIVE_UP_AT_LAST
        assert (np.False_ in admitted) is (k >= GIVE_UP)
    assert "only on two legs" in pilot.replans[-1].problem


def test_no_foothold_is_behind_a_wall(world):
    pilot, _ = set_out(world)
    wall = Rectangle((-0.6, 0.0), (0.1, 9.0))
    pilot.know(with_obstacles(world, [wall]))
    for side in (-1.0, 1.0):
        at = np.array([-0.6 + side * 0.3, -0.75])
        found = np.array(footholds(pilot.world, at)).reshape(-1, 2)
        assert (side * (found[:, 0] + 0.6) > 0).all()
        assert len(found)


def test_plans_on_the_way_have_no_clock(world, monkeypatch):
    import time

    def plans():
        pilot, robot = set_out(world)
        robot.until(3.0)
        pilot.know(with_obstacles(world, [Rectangle((0.0, 1.2), (0.4, 0.8))]))
        robot.step()
        return pilot.replans[0].plan

    quick, real, jump = plans(), time.perf_counter, [0.0]

    def slow():
        jump[0] += 5.0
        return real() + jump[0]

    monkeypatch.setattr(time, "perf_counter", slow)
    late = plans()
    np.testing.assert_array_equal(quick.cells, late.cells)
    assert (quick.objective, quick.bound) == (late.objective, late.bound)


def test_a_new_plan_does_not_halt_the_robot(world):
    pilot, robot = set_out(world)
    robot.until(4.0)
    before = robot.step().twist_H[:2].copy()
    pilot.know(world)
    after = robot.step().twist_H[:2]
    assert why(pilot) == ["map"] and np.linalg.norm(before) > 0.1
    assert np.linalg.norm(after - before) < 0.1


def test_steps_are_those_of_all_plans(world):
    pilot, robot = set_out(world)
    robot.until(5.0)
    first = pilot.steps
    assert 0.5 < first < len(pilot._planning(world, [Mode.CRAWL]).modes)
    pilot.know(world)
    robot.until(60.0)
    assert pilot.arrived and pilot.steps == pytest.approx(
        first + len(pilot.replans[0].plan.modes) - 2
    )
    assert pilot.switches == 0


def test_the_crawl_between_two_rolls_of_a_stretch_is_no_switch(world):
    xy = np.array([[-1.2, 0.0], [-0.7, 0.0], [0.8, 0.0], [2.3, 0.0]])
    plan = Plan(world.grid.cell_of(xy), ("crawl", "roll", "roll"), xy, "optimal", 0.0, 0.0, 0.0)
    pilot = Pilot(world, plan, [Mode.CRAWL, Mode.ROLL])
    crawl, roll = Mode.CRAWL, Mode.ROLL
    seen, told = [], [crawl, crawl, roll, roll, roll, roll, crawl]
    real = [crawl, crawl, crawl, roll, crawl, roll, crawl]
    for leg, actual in zip(told, real, strict=True):
        pilot.follower = Stub(leg)
        belief = StateEstimate(9.0, [0, 0, 0.27], [1, 0, 0, 0], *np.zeros((2, 3)), np.ones(4))
        pilot.command(belief, DT, actual)
        seen.append(pilot.switches)
    assert seen == [0, 0, 0, 1, 1, 1, 2]


class Stub:
    """A follower that is about a leg of a mode and asks for nothing."""

    arrived, failures, share, rolls = False, 0, 0.0, 0

    def __init__(self, leg):
        self.leg_mode = leg

    def off_plan(self, p):
        return 0.0

    def mode(self):
        return Mode.CRAWL

    def command(self, belief, dt, actual):
        return None


def test_room_is_measured_where_the_robot_is(world):
    room = room_of(world)
    cell = np.argwhere(~world.grid.blocked)[0]
    center, half = world.grid.center_of(cell), 0.5 * world.grid.cell
    assert room(center) == pytest.approx(world.clearance[tuple(cell)], abs=1e-6)
    around = [room(center + half * np.array(d)) for d in ((0.9, 0), (-0.9, 0), (0, 0.9), (0, -0.9))]
    assert min(around) == pytest.approx(room(center) - 0.9 * half, abs=0.01)
    assert room(center + 100.0) == 0.0
