"""Peers hold the stance or shake it; a policy is refused for the wrong body."""

import numpy as np
import pytest

from mobius.control.action import ACTION_CLIP, ACTION_SCALE
from mobius.control.bodies import BODIES, body_of
from mobius.control.peers import PeerController, controller_of
from mobius.control.policy import PolicyController, shipped_policy
from mobius.errors import PolicyError, UnknownName
from mobius.model.robot import joint_limits, keyframe_joints
from mobius.types import ModeCommand, SensorFrame, StateEstimate


def targets(controller, body: str, steps: int = 5) -> np.ndarray:
    zero, joints = np.zeros(3), np.zeros(22)
    belief = StateEstimate(0.0, [0, 0, 0.3], [1, 0, 0, 0], zero, zero, np.ones(4))
    frame = SensorFrame(0.0, joints, joints, joints, np.zeros((2, 6)), zero, [0, 0, 9.81])
    command = ModeCommand(body_of(body).mode, [0.1, 0, 0], 0.0)
    return np.array([controller.act(command, belief, frame).q for _ in range(steps)])


@pytest.mark.parametrize("body", BODIES)
def test_zero_holds_the_stance(body):
    hold = keyframe_joints(body_of(body).keyframe)[1]
    np.testing.assert_allclose(targets(controller_of("zero", body), body), [hold] * 5)


@pytest.mark.parametrize("body", BODIES)
def test_random_moves_only_its_own_joints_within_limits_and_repeats_by_seed(body):
    hold, index = keyframe_joints(body_of(body).keyframe)[1], body_of(body).index
    runs = [targets(controller_of("random", body, seed=s), body) for s in (1, 1, 2)]
    np.testing.assert_array_equal(runs[0], runs[1])
    assert (runs[0][:, index] != runs[2][:, index]).any()
    held = np.setdiff1d(np.arange(22), index)
    np.testing.assert_array_equal(runs[0][:, held], [hold[held]] * 5)
    low, high = joint_limits()
    assert (runs[0] >= low - 1e-9).all() and (runs[0] <= high + 1e-9).all()
    assert np.abs(runs[0] - hold).max() <= ACTION_SCALE * ACTION_CLIP


def test_a_reset_starts_the_draw_anew():
    peer = PeerController("crawl", spread=1.0, seed=3)
    first = targets(peer, "crawl")
    peer.reset()
    np.testing.assert_array_equal(first, targets(peer, "crawl"))


def test_what_names_a_controller():
    assert isinstance(controller_of(None, "biped"), PolicyController)
    for name, ground in (("flat", False), ("rough", True)):
        shipped = controller_of(name, "crawl")
        assert isinstance(shipped, PolicyController)
        assert (shipped.policy.metadata["config"]["env"]["terrain"] is not None) is ground
    assert isinstance(controller_of(shipped_policy("crawl"), "crawl"), PolicyController)
    assert isinstance(controller_of(str(shipped_policy("crawl")), "crawl"), PolicyController)
    with pytest.raises(UnknownName, match="Did you mean 'random'"):
        controller_of("randm", "crawl")
    with pytest.raises(PolicyError, match="no such policy file"):
        controller_of("lost.onnx", "crawl")
    with pytest.raises(UnknownName, match="Did you mean 'crawl'"):
        controller_of("zero", "crwl")


def test_a_policy_does_not_drive_another_body():
    with pytest.raises(PolicyError, match="drives the body 'biped', not 'crawl'"):
        controller_of(shipped_policy("biped"), "crawl")
