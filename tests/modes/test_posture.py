"""Postures from belief and encoders, and falls without false alarms."""

import numpy as np
import pytest

from mobius.assemble import Start, build_sim_stack, flat_model
from mobius.model.robot import keyframe_joints
from mobius.modes import FallDetector, Posture, posture, posture_of
from mobius.types import Mode, ModeCommand

CRAWL = keyframe_joints("crawl")[0]
STAND = keyframe_joints("stand")[0]
PRONE = keyframe_joints("prone")[0]


@pytest.mark.parametrize(
    ("pose", "posture"),
    [
        ("crawl", Posture.CRAWLING),
        ("stand", Posture.STANDING),
        ("prone", Posture.PRONE),
        ("supine", Posture.SUPINE),
        ("on_head", Posture.ON_HEAD),
    ],
)
def test_keyframes_are_what_they_are_called(belief_of, pose, posture):
    assert posture_of(belief_of(pose=pose), keyframe_joints(pose)[0]) is posture


def test_sides_by_the_side_that_is_down(belief_of):
    assert posture_of(belief_of(roll=np.pi / 2), PRONE) is Posture.RIGHT_SIDE
    assert posture_of(belief_of(roll=-np.pi / 2), PRONE) is Posture.LEFT_SIDE


def test_in_between_and_upright_without_feet_have_no_name(belief_of):
    assert posture_of(belief_of(pitch=np.pi / 4), CRAWL) is Posture.OTHER
    assert posture_of(belief_of(pitch=-np.pi / 2), PRONE) is Posture.OTHER


def test_a_fall_must_last_to_be_one(belief_of):
    detector = FallDetector()
    said = [detector.fallen(Mode.CRAWL, belief_of(k / 60, pitch=1.2), CRAWL) for k in range(8)]
    assert not any(said[:5]) and "leans 69 deg" in said[5]
    detector.reset()
    for k in range(60):  # every other belief is strange
        assert not detector.fallen(Mode.CRAWL, belief_of(k / 60, pitch=1.2 * (k % 2)), CRAWL)


def test_limbs_that_give_way_are_a_fall(belief_of):
    detector = FallDetector()
    said = [detector.fallen(Mode.CRAWL, belief_of(k / 60), PRONE) for k in range(30)]
    assert not any(said[:21]) and "no limb carries the trunk" in said[-1]
    detector.reset()
    legs = STAND.copy()
    legs[12:20] = PRONE[12:20]
    said = [detector.fallen(Mode.BIPED, belief_of(k / 60, pose="stand"), legs) for k in range(30)]
    assert "no limb carries the trunk" in said[-1]


def test_a_look_at_a_standing_robot_costs_the_kinematics_of_one_limb(belief_of, monkeypatch):
    asked = []
    deep = posture.depth
    monkeypatch.setattr(
        posture, "depth", lambda limb, q, up: asked.append(limb) or deep(limb, q, up)
    )
    detector = FallDetector()
    legs = CRAWL.copy()
    legs[:12] = PRONE[:12]  # the arms hang high: the legs carry it
    for k in range(60):
        assert not detector.fallen(Mode.CRAWL, belief_of(k / 60), legs)
    assert asked[:3] == ["left_arm", "right_arm", "left_leg"]
    assert asked[3:] == ["left_leg"] * 9


def test_other_modes_do_not_fall(belief_of):
    detector = FallDetector()
    assert not any(
        detector.fallen(Mode.ROLL, belief_of(k / 60, pitch=3.0), PRONE) for k in range(60)
    )


@pytest.mark.parametrize(("body", "twist"), [("crawl", [0.5, 0.2, 0.6]), ("biped", [0.15, 0, 0.3])])
def test_no_alarm_while_it_walks(body, twist):
    stack, _ = build_sim_stack(flat_model(), Start(body=body, seed=3))
    mode, detector = Mode(body), FallDetector()
    for _ in range(600):
        sample = stack.turn(lambda b: ModeCommand(mode, twist, b.stamp))
        if sample is not None:
            assert not detector.fallen(mode, sample.belief, sample.frame.q)
            posture = posture_of(sample.belief, sample.frame.q)
            assert posture is (Posture.CRAWLING if body == "crawl" else Posture.STANDING)
