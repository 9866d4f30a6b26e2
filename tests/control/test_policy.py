"""The shipped policy: what it says of itself, and that the loop feeds it as training did."""

from dataclasses import replace

import numpy as np
import pytest

from mobius.control.policy import PolicyController, load_policy, shipped_policy
from mobius.errors import PolicyError
from mobius.model.poses import Stance, stance_keyframe
from mobius.model.robot import keyframe_joints
from mobius.types import Mode, ModeCommand, SensorFrame, StateEstimate


@pytest.fixture(scope="module")
def policy():
    return load_policy(shipped_policy("crawl"))


def belief() -> StateEstimate:
    zero = np.zeros(3)
    return StateEstimate(0.0, [0, 0, 0.275], [1, 0, 0, 0], zero, zero, np.ones(4))


def frame() -> SensorFrame:
    q = keyframe_joints("crawl")[0]
    zero = np.zeros(22)
    return SensorFrame(0.0, q, zero, zero, np.zeros((2, 6)), np.zeros(3), [0, 0, 9.81])


def test_metadata_names_what_is_needed_to_run(policy):
    for key in ("body", "frame", "history", "clock", "joints", "default", "scale", "kp"):
        assert key in policy.metadata
    for key in ("preset", "git", "seed", "curve"):
        assert key in policy.metadata
    assert shipped_policy("crawl").stat().st_size < 1_000_000


def test_default_is_the_stance_of_the_model(policy):
    """A policy of an older model would stand wrong: its Theta_default must be today's."""
    stance = policy.metadata["config"]["env"].get("stance")
    own = keyframe_joints("crawl") if stance is None else stance_keyframe(Stance(**stance))
    np.testing.assert_allclose(policy.default, own[1], atol=0.01)


def test_a_policy_stands_apart_from_the_keyframe_or_not_by_its_default(policy):
    at_home = replace(policy, default=keyframe_joints("crawl")[1])
    wide = Stance(arm_r=0.24, arm_turn=0.30, leg_r=0.19, leg_turn=0.20)
    apart = replace(policy, default=stance_keyframe(wide)[1])
    assert (at_home.apart, apart.apart) == (False, True)
    assert PolicyController(apart).apart and not PolicyController(at_home).apart
    assert not load_policy(shipped_policy("biped")).apart


def test_only_actuated_joints_move(policy):
    controller = PolicyController(policy)
    command = ModeCommand(Mode.CRAWL, [0.3, 0, 0], 0.0)
    out = controller.act(command, belief(), frame()).q
    held = np.setdiff1d(np.arange(22), policy.body.index)
    np.testing.assert_allclose(out[held], policy.default[held])
    assert np.abs(out[policy.body.index] - policy.default[policy.body.index]).max() > 1e-3


def test_same_inputs_same_targets(policy):
    runs = []
    for _ in range(2):
        controller = PolicyController(policy)
        command = ModeCommand(Mode.CRAWL, [0.3, 0.1, 0.2], 0.0)
        runs.append([controller.act(command, belief(), frame()).q for _ in range(5)])
    np.testing.assert_array_equal(runs[0], runs[1])


def test_policy_is_symmetric(policy):
    """Mirrored command from a symmetric state gives mirrored targets."""
    from mobius.control.observation import mirror_joints

    index, sign = mirror_joints(policy.body)
    outs = []
    for twist in ([0.0, 0.2, 0.0], [0.0, -0.2, 0.0]):
        controller = PolicyController(policy)
        controller._clock.phase[0] = 0.25 if twist[1] > 0 else 0.75
        q = controller.act(ModeCommand(Mode.CRAWL, twist, 0.0), belief(), frame()).q
        outs.append((q - policy.default)[policy.body.index])
    # the stance itself is symmetric to about a tenth of a millirad (settled targets)
    np.testing.assert_allclose(outs[1], sign * outs[0][index], atol=5e-3)


def test_wrong_files_are_refused(tmp_path):
    with pytest.raises(PolicyError, match="no such policy"):
        load_policy(tmp_path / "none.onnx")
    with pytest.raises(PolicyError, match="no such policy"):
        load_policy(str(tmp_path / "none.onnx"))
    bad = tmp_path / "bad.onnx"
    bad.write_bytes(b"not a model")
    with pytest.raises(PolicyError, match="not an ONNX model"):
        load_policy(bad)
