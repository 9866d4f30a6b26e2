"""Putting a robot together: who drives, which robot, on which ground."""

import numpy as np
import pytest

from mobius.assemble import Start, build_sim_stack, flat_model, ground_model, variation_of
from mobius.control.peers import PeerController
from mobius.errors import InvalidInput, UnknownName
from mobius.geometry import quat_conj, rotate
from mobius.model.robot import keyframe, keyframe_joints
from mobius.modes.motions import Motion, Stage
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


def crude(*names):
    """Motions that go to the crawling stance, whatever their name."""
    stage = Stage(keyframe_joints("crawl")[1], 0.5)
    return {name: Motion(name, "prone", "crawling", (stage,)) for name in names}


def test_a_stack_of_several_modes_has_transitions_and_recovery():
    names = ("crawl_to_stand", "stand_to_crawl", "roll", "prone_to_crawl")
    stack, _ = build_sim_stack(
        flat_model(),
        Start(),
        policy="zero",
        modes=("crawl", "biped", "roll"),
        motions=crude(*names),
    )
    modes = {Mode.CRAWL, Mode.BIPED, Mode.ROLL, Mode.STAND_UP, Mode.LIE_DOWN, Mode.RECOVER}
    modes |= {Mode.GATHER}
    assert stack.machine.available == modes
    assert stack.machine.mode is Mode.CRAWL


@pytest.mark.parametrize("pose", ["prone", "supine", "on_head", "stand"])
def test_a_run_may_begin_in_any_keyframe(pose):
    model, modes = flat_model(), ("crawl", "biped")
    motions = crude("crawl_to_stand", "stand_to_crawl")
    start = Start(keyframe=pose, randomised=False)
    stack, robot = build_sim_stack(model, start, policy="zero", modes=modes, motions=motions)
    up = [rotate(quat_conj(q), [0.0, 0, 1]) for q in (robot.truth().q_OB, keyframe(pose)[0][3:7])]
    np.testing.assert_allclose(*up, atol=1e-6)
    assert stack.machine.mode is (Mode.BIPED if pose == "stand" else Mode.RECOVER)
    assert stack.turn(lambda b: ModeCommand(Mode.CRAWL, np.zeros(3), b.stamp)) is not None


def test_a_run_may_begin_in_any_configuration():
    qpos = keyframe("prone")[0] + 0.0
    qpos[2] += 0.5
    stack, robot = build_sim_stack(
        flat_model(), Start(qpos=qpos), policy="zero", modes=("crawl",), motions=crude()
    )
    np.testing.assert_allclose(robot.truth().p_OB, qpos[:3])
    assert stack.machine.mode is Mode.RECOVER
    with pytest.raises(InvalidInput, match=r"SimRobot.qpos: expected \d+ numbers"):
        build_sim_stack(flat_model(), Start(qpos=qpos[:7]))


@pytest.mark.parametrize(
    ("modes", "error", "message"),
    [
        (("crawl", "roll"), InvalidInput, "mode 'roll' needs the motion 'roll', which is not"),
        (("roll",), InvalidInput, "begins and ends in crawl; give that mode as well"),
        (("crawl", "fly"), UnknownName, "unknown mode 'fly'"),
    ],
)
def test_a_mode_that_cannot_be_is_refused(modes, error, message):
    with pytest.raises(error, match=message):
        build_sim_stack(flat_model(), Start(), policy="zero", modes=modes, motions=crude())


def test_friction_may_be_that_of_all_surfaces():
    model = flat_model()
    Variation(friction=0.6, everywhere=True).apply(model)
    trunk = model.body("base_link").id
    robot = model.body_rootid[model.geom_bodyid] == trunk
    solid = robot & (model.geom_contype > 0)
    assert (model.geom_friction[solid, 0] == 0.6).all() and (model.geom_priority[solid] == 1).all()
    soles = flat_model()
    Variation(friction=0.6).apply(soles)
    assert 0 < (soles.geom_friction[:, 0] == 0.6).sum() < solid.sum()
