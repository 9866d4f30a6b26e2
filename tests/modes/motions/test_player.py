"""Playing a motion: smooth targets, conditions, feedback, and giving up."""

import numpy as np
import pytest

from mobius.model import JOINTS
from mobius.model.robot import keyframe_joints
from mobius.modes.motions import (
    Feedback,
    Guard,
    MotionPlayer,
    Stage,
    Until,
    Window,
    load_motion,
    motion_names,
)
from mobius.types import Mode, ModeCommand

PRONE, CRAWL = (keyframe_joints(k)[0] for k in ("prone", "crawl"))
STILL = ModeCommand(Mode.RECOVER, np.zeros(3), 0.0)
DT = 1 / 300


@pytest.fixture
def play(belief_of, frame_of):
    """Play ``seconds`` with the trunk's pitch by time; joints follow unless told otherwise."""

    def run(player, seconds, pitch=lambda t: 0.0, *, stuck=None, rate=0.0, t0=0.0):
        sent, q = [], PRONE
        for k in range(round(seconds / DT)):
            t = t0 + k * DT
            belief = belief_of(t, pitch=pitch(t), w=(0.0, rate, 0.0))
            frame = frame_of(t, q if stuck is None else stuck)
            q = player.act(STILL, belief, frame).q
            sent.append(q)
        return np.array(sent)

    return run


def test_targets_go_from_what_was_sent_last_to_the_pose_without_a_jerk(play, motion_of):
    player = MotionPlayer(motion_of(Stage(CRAWL, 0.5)))
    player.begin(PRONE)
    sent = play(player, 0.6)
    np.testing.assert_allclose(sent[0], PRONE, atol=1e-12)
    np.testing.assert_allclose(sent[-1], CRAWL)
    speed = np.diff(sent, axis=0) / DT
    span = np.abs(CRAWL - PRONE).max()
    assert np.abs(speed).max() == pytest.approx(1.875 * span / 0.5, rel=1e-3)
    # a quintic step has 5.77 span / T^2 at most; a few samples from the ends, a share of it
    assert np.abs(speed[[0, 148]]).max() < 1e-2 * np.abs(speed).max()
    assert np.abs(np.diff(speed, axis=0)[[0, 147]] / DT).max() < 0.15 * 5.77 * span / 0.5**2
    assert player.state == "done" and player.progress == 1.0


def test_without_targets_it_begins_at_the_measured_angles(play, motion_of):
    sent = play(MotionPlayer(motion_of(Stage(CRAWL, 0.5))), 0.1, stuck=PRONE)
    np.testing.assert_allclose(sent[0], PRONE)


def test_a_stage_holds_before_the_next(play, motion_of):
    player = MotionPlayer(motion_of(Stage(CRAWL, 0.1, hold=0.2), Stage(PRONE, 0.1), end="prone"))
    player.begin(PRONE)
    sent = play(player, 0.45)
    np.testing.assert_allclose(sent[32:90], np.tile(CRAWL, (58, 1)), atol=1e-9)
    assert player.state == "done"
    assert player.elapsed == pytest.approx(0.45 - DT)


def test_until_ends_the_move_early_and_the_next_goes_on_from_there(play, motion_of):
    stages = Stage(CRAWL, 1.0, until=Until("pitch_B", below=-0.5)), Stage(PRONE, 0.5)
    player = MotionPlayer(motion_of(*stages))
    player.begin(PRONE)
    sent = play(player, 0.6, lambda t: -2.0 * t)  # -0.5 at 0.25 s
    turn = int(np.argmax(np.abs(sent - PRONE).max(axis=1)))
    assert turn * DT == pytest.approx(0.25, abs=0.01)
    assert np.abs(np.diff(sent, axis=0)).max() < 0.05  # no jump
    assert player.stage == 1


def test_a_condition_that_does_not_come_fails_the_motion_and_targets_stay(play, motion_of):
    stage = Stage(CRAWL, 0.2, until=Until("pitch_B", below=-0.5), timeout=0.3)
    player = MotionPlayer(motion_of(stage))
    sent = play(player, 0.7)
    assert player.state == "failed"
    assert player.reason == "prone_to_crawl, stage 0: pitch_B did not come in 0.3 s"
    np.testing.assert_array_equal(sent[-1], sent[-10])


def test_feedback_moves_its_joint_with_pitch_and_rate_and_enters_without_a_jump(play, motion_of):
    k = JOINTS.index("left_ankle_pitch")
    feedback = (Feedback("left_ankle_pitch", 0.5, 0.1, pitch=-0.2),)
    player = MotionPlayer(motion_of(Stage(CRAWL, 0.2, hold=0.5, feedback=feedback)))
    player.begin(PRONE)
    sent = play(player, 0.4, lambda t: 0.1, rate=0.3)
    # 0.5 * (0.1 + 0.2) + 0.1 * 0.3 = 0.18
    assert sent[-1, k] - CRAWL[k] == pytest.approx(0.18)
    np.testing.assert_allclose(sent[0], PRONE, atol=1e-12)
    others = np.delete(np.arange(22), k)
    np.testing.assert_allclose(sent[-1, others], CRAWL[others])


def test_it_gives_up_when_the_trunk_leaves_the_window(play, motion_of):
    player = MotionPlayer(motion_of(Stage(CRAWL, 1.0, window=Window(within=0.4))))
    play(player, 0.5, lambda t: 2.0 * t)
    assert player.state == "failed" and "trunk at pitch 0.4" in player.reason


def test_it_gives_up_when_joints_do_not_follow_for_long(play, motion_of):
    motion = motion_of(Stage(CRAWL, 0.2, hold=2.0), guard=Guard(error=0.5, seconds=0.3))
    player = MotionPlayer(motion)
    play(player, 0.4, stuck=PRONE)
    assert player.state == "running"
    play(player, 0.3, stuck=PRONE, t0=0.4)
    assert player.state == "failed" and "more than 0.5 rad off for 0.3 s" in player.reason


def test_reset_plays_it_again(play, motion_of):
    player = MotionPlayer(motion_of())
    play(player, 0.3)
    assert player.state == "done"
    player.reset()
    assert player.state == "running" and player.progress == 0.0
    play(player, 0.3, t0=5.0)
    assert player.state == "done"


def test_a_motion_that_ends_in_another_posture_has_failed(play, motion_of):
    player = MotionPlayer(motion_of(Stage(PRONE, 0.1), end="crawling"))
    play(player, 0.2)
    assert player.state == "failed"
    assert "ended prone, not crawling" in player.reason


def test_every_stage_that_ships_is_guarded():
    """By a window that can be left, or a condition with a time-out. Only what stirs a heap may lie
    anyhow: the first stage of a way up from back or belly."""
    stirs = {"supine_to_crawl", "supine_recovery", "prone_to_crawl"}
    for name in motion_names():
        for k, stage in enumerate(load_motion(name).stages):
            if k == 0 and name in stirs:
                continue
            w = stage.window
            bounded = w is not None and bool(np.isfinite([w.within, w.lean]).any())
            assert bounded or stage.until is not None, f"{name}, stage {k}"
