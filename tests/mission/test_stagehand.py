"""Obstacles moved in the scene and made known to the pilot."""

from types import SimpleNamespace

import numpy as np
import pytest

from mobius.mission.body import BIPED_ROOM
from mobius.mission.prepare import open_world
from mobius.mission.stagehand import Stagehand
from mobius.world import Scenario
from mobius.world.scenario import Event, Obstacle
from mobius.world.shapes import Rectangle

HERE, THERE = Rectangle((1.2, -0.1), (0.5, 0.5)), Rectangle((0.0, 1.1), (0.5, 0.5), 0.4)


@pytest.fixture
def stage():
    """A stagehand, a robot in a scene with one obstacle, and a pilot that notes its maps."""
    scenario = Scenario(
        (Obstacle("crate", (0.5, 0.5), 0.4, HERE),),
        (Event("move", "crate", THERE, 2.0, None, "line 1"),),
    )
    robot = SimpleNamespace(
        model=SimpleNamespace(body=lambda name: SimpleNamespace(mocapid=np.array([0]))),
        data=SimpleNamespace(mocap_pos=np.zeros((1, 3)), mocap_quat=np.zeros((1, 4))),
    )
    known: list = []
    return (
        Stagehand(open_world("arena"), scenario),
        robot,
        SimpleNamespace(know=known.append),
        known,
    )


def test_what_is_due_is_moved_logged_and_told(stage):
    hand, robot, pilot, known = stage
    hand.turn(1.9, (-1.2, -0.7), robot, pilot)
    assert known == [] and not robot.data.mocap_pos.any()
    hand.turn(2.0, (-1.2, -0.7), robot, pilot)
    np.testing.assert_allclose(robot.data.mocap_pos[0], [0.0, 1.1, 0.2])
    assert robot.data.mocap_quat[0, 3] == pytest.approx(np.sin(0.2))
    assert hand.log == [{"t": 2.0, "what": "move", "obstacle": "crate"}]
    (world,) = known
    assert world.grid.blocked[tuple(world.grid.cell_of(THERE.center))]
    assert not world.grid.blocked[tuple(world.grid.cell_of(HERE.center))]


def test_nothing_comes_as_near_as_a_robot_that_lies_reaches(stage):
    hand, robot, pilot, known = stage
    beside = (THERE.center[0], THERE.center[1] - 0.25 - BIPED_ROOM)
    hand.turn(2.0, beside, robot, pilot)
    assert known == [] and hand.scenery.pending
    hand.turn(3.0, (-1.2, -0.7), robot, pilot)
    assert len(known) == 1 and hand.log[0]["t"] == 3.0


def test_the_world_begins_with_what_stands_there_at_first(stage):
    hand, *_ = stage
    world = hand.world(check=True)
    assert world.grid.blocked[tuple(world.grid.cell_of(HERE.center))]
