"""Falls and recoveries as the mission counts them."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from mobius.control.bodies import BODIES
from mobius.geometry import rpy_to_quat
from mobius.mission.floor import floor_of
from mobius.mission.judge import LOST_S, MissionJudge
from mobius.types import Mode, StateEstimate
from mobius.world.shapes import Rectangle, RoughPatch

FLAT, UPRIGHT = rpy_to_quat(0.0, 0.0, 0.0), rpy_to_quat(0.0, -np.pi / 2, 0.0)
ON_ITS_SIDE = rpy_to_quat(np.pi / 2, 0.0, 0.0)


class Robot:
    """What a judge asks of a simulated robot."""

    def __init__(self):
        self.q, self.z = FLAT, 0.27
        self.data = SimpleNamespace(
            qpos=np.zeros(7), mocap_pos=np.zeros((0, 3)), mocap_quat=np.zeros((0, 4))
        )

    def truth(self):
        return StateEstimate(0.0, [0.0, 0.0, self.z], self.q, np.zeros(3), np.zeros(3), np.ones(4))

    def obstacle_force(self):
        return 0.0

    def trunk_grounded(self):
        return False

    def loop_residual(self):
        return 0.0

    def torque(self):
        return np.zeros(22)

    def contact_force(self):
        return np.zeros(4)


@pytest.fixture
def watch():
    """Judge a robot that is in a mode, with an attitude, at a time [s]."""

    def make(recovers=True):
        robot = Robot()
        judge = MissionJudge(robot, recovers=recovers)

        def see(t, mode, q=FLAT, z=0.27):
            robot.q, robot.z = q, z
            judge.see(SimpleNamespace(tick=round(t * 600), command=SimpleNamespace(mode=mode)))

        return judge, see

    return make


def test_standing_up_is_no_fall(watch):
    judge, see = watch()
    see(0.0, Mode.CRAWL)
    see(1.0, Mode.STAND_UP, rpy_to_quat(0.0, -0.8, 0.0), 0.15)
    see(2.0, Mode.BIPED, UPRIGHT, 0.47)
    see(3.0, Mode.ROLL, rpy_to_quat(np.pi, 0.0, 0.0), 0.15)
    assert judge.falls == [] and not judge.fallen


def test_a_fall_is_recovered_when_the_robot_crawls_again(watch):
    judge, see = watch()
    see(0.0, Mode.BIPED, UPRIGHT, 0.47)
    see(1.0, Mode.BIPED, ON_ITS_SIDE, 0.15)
    see(1.1, Mode.RECOVER, ON_ITS_SIDE, 0.15)
    assert judge.falls == [1.0] and judge.down and not judge.fallen
    see(6.0, Mode.RECOVER, FLAT)
    assert judge.down  # not before it crawls
    see(6.1, Mode.CRAWL, FLAT)
    assert judge.recoveries == pytest.approx([6.1], abs=0.01) and not judge.down


def test_who_lies_too_long_is_lost(watch):
    judge, see = watch()
    see(0.0, Mode.RECOVER, ON_ITS_SIDE)
    see(LOST_S - 1, Mode.RECOVER, ON_ITS_SIDE)
    assert not judge.fallen
    see(LOST_S + 1, Mode.RECOVER, ON_ITS_SIDE)
    assert judge.fallen


def test_height_is_counted_from_the_floor_below():
    patch = RoughPatch(Rectangle((1.0, 2.0), (2.0, 1.0), 0.4), amplitude=0.1)
    ground = floor_of(SimpleNamespace(rough=(patch,)))
    assert floor_of(SimpleNamespace(rough=())) is None
    assert float(ground(np.array([9.0, 9.0]))) == 0.0
    points = patch.area.to_map(np.random.default_rng(0).uniform(-0.5, 0.5, (4000, 2)) * [2, 1])
    heights = ground(points)
    assert 0.08 < heights.max() <= 0.1 and heights.min() >= 0.0
    robot, top = Robot(), points[heights.argmax()]
    robot.z = BODIES["crawl"].fallen_below + 0.05
    truth = robot.truth
    robot.truth = lambda: replace(truth(), p_OB=np.array([*top, robot.z]))
    for floor, falls in ((None, 0), (ground, 1)):
        judge = MissionJudge(robot, recovers=True, ground=floor)
        judge.see(SimpleNamespace(tick=1, command=SimpleNamespace(mode=Mode.CRAWL)))
        assert len(judge.falls) == falls


def test_a_robot_that_cannot_get_up_is_lost_at_once(watch):
    judge, see = watch(recovers=False)
    see(0.0, Mode.CRAWL, ON_ITS_SIDE)
    assert judge.fallen and judge.falls == [0.0]
