"""The follower of plans in several modes, with a point robot and a machine that obeys."""

import numpy as np
import pytest

from mobius.errors import InvalidInput
from mobius.geometry import quat_mul, rpy_to_quat, wrap_angle
from mobius.modes import ModalFollower, TaskConfig, check_roll
from mobius.modes.legs import legs_of
from mobius.types import Mode, Plan, StateEstimate

DT = 1 / 60
UPRIGHT = rpy_to_quat(0.0, -np.pi / 2, 0.0)
"""Trunk of a standing robot with heading 0."""


def plan_of(*steps) -> Plan:
    """From ``(x, y)`` and then ``(x, y, mode)``."""
    xy = np.array([s[:2] for s in steps], dtype=float)
    modes = tuple(Mode(s[2]) for s in steps[1:])
    return Plan(np.round(2 * xy).astype(int), modes, xy, "optimal", 0.0, 0.0, 0.0)


class FakeRobot:
    """Moves as told; changes of body take time; a roll goes ``reach`` m towards the tail."""

    def __init__(self, xy=(0.0, 0.0), yaw=0.0, *, reach=1.2, swerve=0.15, fail=()):
        self.p, self.yaw, self.t = np.array(xy, dtype=float), yaw, 0.0
        self.mode, self.until = Mode.CRAWL, 0.0
        self.reach, self.swerve, self.fail = reach, swerve, list(fail)
        self.track, self.modes, self.begun = [], [], []

    def belief(self):
        q = rpy_to_quat(0.0, 0.0, self.yaw)
        if self.mode is Mode.BIPED:
            q = quat_mul(q, UPRIGHT)
        return StateEstimate(self.t, [*self.p, 0.27], q, np.zeros(3), np.zeros(3), np.ones(4))

    def _begin(self, mode, seconds):
        self.mode, self.until = mode, self.t + seconds
        self.begun.append((mode, self.p.copy(), self.yaw, self.speed))

    def step(self, command):
        self.speed = float(np.linalg.norm(command.twist_H[:2]))
        c, s = np.cos(self.yaw), np.sin(self.yaw)
        if self.mode in (Mode.CRAWL, Mode.BIPED):
            if command.mode is self.mode:
                self.p = self.p + np.array([[c, -s], [s, c]]) @ command.twist_H[:2] * DT
                self.yaw += command.twist_H[2] * DT
            elif command.mode is Mode.BIPED:
                self._begin(Mode.STAND_UP, 3.0)
            elif command.mode is Mode.ROLL:
                self._begin(Mode.ROLL, 2.0)
            else:
                self._begin(Mode.LIE_DOWN, 3.0)
        elif self.mode is Mode.ROLL:
            self.p = self.p - np.array([c, s]) * self.reach * DT / 2.0
        if self.mode not in (Mode.CRAWL, Mode.BIPED) and self.t >= self.until:
            self._end()
        self.t += DT
        self.track.append(self.p)
        self.modes.append(self.mode)

    def _end(self):
        if self.mode in self.fail:
            self.fail.remove(self.mode)
            self._begin(Mode.RECOVER, 3.0)
            return
        if self.mode is Mode.ROLL:
            self.yaw += self.swerve
        self.mode = Mode.BIPED if self.mode is Mode.STAND_UP else Mode.CRAWL


def go(plan, robot=None, *, seconds=200.0, **options):
    robot = robot or FakeRobot(plan.xy_M[0])
    follower, commands = ModalFollower(plan, **options), []
    while robot.t < seconds and not follower.arrived:
        command = follower.command(robot.belief(), DT, robot.mode)
        commands.append(command)
        robot.step(command)
    return follower, robot, commands


def order(robot):
    """The modes it was in, each once per stretch."""
    return [m for k, m in enumerate(robot.modes) if k == 0 or m is not robot.modes[k - 1]]


CRAWL_WALK_CRAWL = plan_of(
    (0, 0), (1, 0, "crawl"), (1.5, 0, "biped"), (2, 0, "biped"), (2, 1, "crawl")
)


def test_a_plan_is_cut_where_its_mode_changes_and_rests_are_left_out():
    plan = plan_of((0, 0), (0, 0, "crawl"), (1, 0, "crawl"), (1.5, 0, "biped"), (2, 0, "crawl"))
    legs = legs_of(plan)
    assert [leg.mode for leg in legs] == [Mode.CRAWL, Mode.BIPED, Mode.CRAWL]
    assert [leg.length for leg in legs] == pytest.approx([1.0, 0.5, 0.5])
    assert legs[0].distance(np.array([0.4, 0.3])) == pytest.approx(0.3)


def test_it_changes_body_where_the_plan_does_and_arrives():
    follower, robot, _ = go(CRAWL_WALK_CRAWL)
    assert follower.arrived and np.linalg.norm(robot.p - [2, 1]) < 0.12
    assert order(robot) == [Mode.CRAWL, Mode.STAND_UP, Mode.BIPED, Mode.LIE_DOWN, Mode.CRAWL]
    (up, at_up, _, _), (down, at_down, _, _) = robot.begun
    assert (up, down) == (Mode.STAND_UP, Mode.LIE_DOWN)
    assert np.linalg.norm(at_up - [1, 0]) < 0.15 and np.linalg.norm(at_down - [2, 0]) < 0.15


def test_it_stands_still_before_it_asks_for_another_body():
    _, robot, commands = go(CRAWL_WALK_CRAWL)
    assert [speed for *_, speed in robot.begun] == [0.0, 0.0]
    moved = [c for c, mode in zip(commands, robot.modes, strict=True) if c.mode is not mode]
    assert moved and all(not c.twist_H.any() for c in moved)


def test_it_walks_within_the_range_of_the_walking_body():
    _, _, commands = go(plan_of((0, 0), (1, 0, "biped"), (1, 1, "biped"), (0, 1, "biped")))
    twists = np.abs([c.twist_H for c in commands if c.mode is Mode.BIPED])
    assert (twists <= [0.25, 0.15, 0.5]).all() and twists[:, 0].max() > 0.15


def test_a_roll_goes_tail_first_and_the_rest_of_its_step_is_crawled():
    follower, robot, _ = go(plan_of((0, 0), (1.5, 0, "roll"), (3, 0, "roll"), (3.5, 0, "crawl")))
    rolls = [b for b in robot.begun if b[0] is Mode.ROLL]
    assert len(rolls) == follower.rolls == 2 and follower.failures == 0
    for _, _, yaw, _ in rolls:
        assert abs(wrap_angle(yaw - np.pi)) < 0.1  # the tail points along the step
    assert [at[0] for _, at, _, _ in rolls] == pytest.approx([0.0, 1.5], abs=0.13)
    assert follower.arrived and np.linalg.norm(robot.p - [3.5, 0]) < 0.12
    assert np.abs(np.array(robot.track)[:, 1]).max() < 0.25  # the swerve does not add up


def test_it_rolls_once_per_planned_roll_even_if_the_roll_falls_short():
    follower, robot, _ = go(plan_of((0, 0), (1.5, 0, "roll")), FakeRobot(yaw=np.pi, reach=0.7))
    assert follower.rolls == 1 and np.linalg.norm(robot.p - [1.5, 0]) < 0.13


def test_without_room_behind_it_does_not_roll_but_crawls():
    plan = plan_of((0, 0), (1.5, 0, "roll"))
    follower, robot, _ = go(plan, room=lambda p: 1.0 if p[0] < 1.0 else 0.3)
    assert follower.rolls == 0 and follower.rolls_refused == 1
    assert Mode.ROLL not in robot.modes and np.linalg.norm(robot.p - [1.5, 0]) < 0.13


def test_a_failed_change_is_counted_and_asked_for_again():
    robot = FakeRobot(fail=[Mode.STAND_UP])
    follower, robot, _ = go(CRAWL_WALK_CRAWL, robot)
    assert follower.failures == 1 and follower.arrived
    assert order(robot)[:5] == [
        Mode.CRAWL, Mode.STAND_UP, Mode.RECOVER, Mode.CRAWL, Mode.STAND_UP,
    ]  # fmt: skip


def test_a_change_that_ends_in_a_recovery_is_counted_once_and_while_it_lasts():
    follower, robot = ModalFollower(plan_of((0, 0), (1, 0, "biped"))), FakeRobot()
    robot.fail = [Mode.STAND_UP]
    while robot.mode is not Mode.RECOVER:
        robot.step(follower.command(robot.belief(), DT, robot.mode))
    for _ in range(3):
        follower.command(robot.belief(), DT, Mode.RECOVER)
        assert follower.failures == 1 and follower.failed == [Mode.BIPED]
    follower.command(robot.belief(), DT, Mode.CRAWL)
    assert follower.failures == 1


def test_a_new_plan_in_the_same_body_does_not_halt_the_robot():
    plan, robot = plan_of((0, 0), (3, 0, "crawl")), FakeRobot()
    before, after = ModalFollower(plan), ModalFollower(plan)
    while robot.t < 2.0:
        command = before.command(robot.belief(), DT, robot.mode)
        robot.step(command)
    after.take_over(before)
    on = after.command(robot.belief(), DT, robot.mode)
    np.testing.assert_allclose(on.twist_H, command.twist_H, atol=0.02)
    assert on.twist_H[0] > 0.3


def test_a_new_plan_in_another_body_begins_at_rest():
    before, robot = ModalFollower(plan_of((0, 0), (3, 0, "crawl"))), FakeRobot()
    while robot.t < 2.0:
        robot.step(before.command(robot.belief(), DT, robot.mode))
    after = ModalFollower(plan_of((0, 0), (3, 0, "biped"), (3, 3, "crawl")))
    after.take_over(before)
    while robot.mode is Mode.CRAWL and robot.t < 10.0:
        command = after.command(robot.belief(), DT, robot.mode)
        robot.step(command)
    assert robot.begun and robot.begun[-1][0] is Mode.STAND_UP and robot.speed == 0.0


def test_after_a_failed_roll_it_crawls_the_step():
    follower, robot, _ = go(plan_of((0, 0), (1.5, 0, "roll")), FakeRobot(fail=[Mode.ROLL]))
    assert follower.failures == 1 and follower.rolls == 0
    assert follower.arrived and np.linalg.norm(robot.p - [1.5, 0]) < 0.13


def test_while_it_recovers_it_asks_to_stand_in_the_body_it_needs():
    follower = ModalFollower(plan_of((0, 0), (2, 0, "crawl")))
    robot = FakeRobot()
    for _ in range(120):
        robot.step(follower.command(robot.belief(), DT, robot.mode))
    command = follower.command(robot.belief(), DT, Mode.RECOVER)
    assert command.mode is Mode.CRAWL and not command.twist_H.any()


def test_it_knows_how_far_it_is_and_how_far_off():
    follower, robot, _ = go(CRAWL_WALK_CRAWL, seconds=2.0)
    assert 0.0 < follower.progress < 1.0 and follower.length == pytest.approx(3.0)
    assert follower.off_plan(robot.p + [0.0, 0.7]) == pytest.approx(0.7, abs=0.05)
    done, *_ = go(CRAWL_WALK_CRAWL)
    assert done.progress == pytest.approx(done.length)


def test_a_plan_that_begins_on_two_legs_begins_by_standing_up():
    _, robot, _ = go(plan_of((0, 0), (0, 1, "biped")))
    assert order(robot)[:3] == [Mode.CRAWL, Mode.STAND_UP, Mode.BIPED]
    assert abs(robot.begun[0][2] - np.pi / 2) < 0.3  # it faced its way first


def test_a_roll_is_checked_along_its_line_tail_first_and_beyond_its_end():
    wall = 2.05  # an obstacle everywhere at x <= -2.05 m

    def room(p):
        return float(p[0] + wall)

    def at(x, yaw):
        still = np.zeros(3)
        return StateEstimate(0.0, [x, 0, 0], rpy_to_quat(0, 0, yaw), still, still, np.ones(4))

    narrow = TaskConfig(roll_room=0.2)
    check_roll(at(0.0, 0.0), room, narrow)  # ends at -1.4
    check_roll(at(-1.0, np.pi), room, narrow)  # rolls away
    with pytest.raises(InvalidInput, match=r"0\.14 m at \(-1\.91, -?0\.00\) m; turn the tail"):
        check_roll(at(-0.4, 0.0), room, narrow)
    with pytest.raises(InvalidInput, match="where it stands; move away first"):
        check_roll(at(-1.9, np.pi), room, narrow)
