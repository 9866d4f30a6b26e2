"""Putting a robot together: who drives, which robot, on which ground."""

import numpy as np
import pytest

from mobius.assemble import Start, build_sim_stack, flat_model, ground_model, variation_of
from mobius.control.peers import PeerController
from mobius.robot.variation import Variation
from mobius.stack import Judge
from mobius.types import Mode, ModeCommand
from mobius.world.ground import Ground


def test_a_ready_controller_is_taken_as_it_is():
    mine = PeerController("crawl", spread=0.0)
    stack, _ = build_sim_stack(flat_model(), Start(), policy=mine)
    assert stack.controllers[Mode.CRAWL] is mine


def test_a_name_makes_a_controller():
    stack, _ = build_sim_stack(flat_model(), Start(body="biped"), policy="zero")
    assert isinstance(stack.controllers[Mode.BIPED], PeerController)


def test_a_given_variation_goes_before_the_draw():
    mine = Variation(friction=0.33)
    assert variation_of(Start(variation=mine)) is mine
    assert variation_of(Start(randomised=False)) == Variation()
    assert variation_of(Start(seed=1)) == variation_of(Start(seed=1)) != variation_of(Start(seed=2))


@pytest.mark.parametrize("body", ["crawl", "biped"])
def test_a_robot_starts_on_top_of_the_ground_under_its_soles(body):
    height = np.full((81, 81), 0.1)
    height[:, 41:] = 0.16  # a step of 6 cm just ahead of the middle
    ground = Ground(height, (-2.0, -2.0))
    start = Start(body=body, randomised=False)
    _, robot = build_sim_stack(ground_model(ground), start, policy="zero", ground=ground.at)
    _, flat = build_sim_stack(flat_model(), start, policy="zero")
    lift = robot.truth().p_OB[2] - flat.truth().p_OB[2]
    assert lift == pytest.approx(0.16, abs=1e-6)
    floor = robot.model.geom("floor").id
    pairs = robot.data.contact.geom
    assert (robot.data.contact.dist[(pairs == floor).any(axis=1)] > -1e-3).all()


@pytest.mark.parametrize(
    ("lift", "told", "fallen"), [(0.0, True, False), (-0.1, True, True), (-0.1, False, False)]
)
def test_a_fall_is_judged_over_the_local_ground(lift, told, fallen):
    """On a hill of 0.4 m a trunk at 0.57 m has fallen; who takes the floor for 0 does not see."""
    ground = Ground(np.full((41, 41), 0.4), (-1.0, -1.0))
    start = Start(randomised=False)
    stack, robot = build_sim_stack(ground_model(ground), start, policy="zero", ground=ground.at)
    judge = Judge(robot, ground=ground.at if told else None)
    sample = stack.turn(lambda b: ModeCommand(Mode.CRAWL, np.zeros(3), b.stamp))
    robot.data.qpos[2] += lift
    judge.see(sample)
    assert judge.fallen is fallen
