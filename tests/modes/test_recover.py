"""Recovery: the motion for how it lies, again until it is in its stance, and not for ever."""

import numpy as np
import pytest

from mobius.errors import InvalidInput
from mobius.model.robot import keyframe_joints
from mobius.modes import Posture, Recovery
from mobius.modes.motions import Stage, Window
from mobius.modes.recover import RecoveryConfig
from mobius.types import Mode, ModeCommand

CRAWL, STAND, PRONE = (keyframe_joints(k)[0] for k in ("crawl", "stand", "prone"))
STILL = ModeCommand(Mode.RECOVER, np.zeros(3), 0.0)
STANCE = {Posture.CRAWLING: CRAWL}
LYING = {"crawl": CRAWL, "stand": STAND, "prone": PRONE, "supine": PRONE, "on_head": STAND}


@pytest.fixture
def live(belief_of, frame_of):
    """Run a recovery in a world where each motion that ends well leads to a posture."""

    def run(recovery, pose, leads, seconds=20.0):
        played = 0
        for k in range(round(seconds * 30)):
            t = k / 30
            if len(recovery.log) > played and recovery._player is None:
                pose = leads.get(recovery.log[played][2], pose)
                played += 1
            recovery.act(STILL, belief_of(t, pose=pose), frame_of(t, LYING[pose]))
            if recovery.state != "running":
                break
        return [name for _, _, name in recovery.log]

    return run


@pytest.fixture
def motions(motion_of):
    def named(*names):
        stage = Stage(CRAWL, 0.2)
        ends = {"supine_recovery": "standing", "head_recovery": "prone"}
        return {n: motion_of(stage, name=n, end=ends.get(n, "crawling")) for n in names}

    return named


ALL = ("prone_to_crawl", "supine_recovery", "head_recovery", "stand_to_crawl")
LEADS = {
    "prone_to_crawl": "crawl",
    "supine_recovery": "stand",
    "head_recovery": "prone",
    "stand_to_crawl": "crawl",
}


@pytest.mark.parametrize(
    ("pose", "names"),
    [
        ("prone", ["prone_to_crawl"]),
        ("on_head", ["head_recovery", "prone_to_crawl"]),
        ("supine", ["supine_recovery", "stand_to_crawl"]),
        ("stand", ["stand_to_crawl"]),
        ("crawl", []),
    ],
)
def test_each_posture_has_its_way_to_crawl(live, motions, pose, names):
    recovery = Recovery(motions(*ALL), STANCE)
    assert live(recovery, pose, LEADS) == [*names, "to_crawling"]
    assert recovery.state == "done"


def test_a_robot_that_may_only_stand_is_done_standing(live, motions):
    recovery = Recovery(motions("supine_recovery"), {Posture.STANDING: STAND})
    assert live(recovery, "supine", LEADS) == ["supine_recovery", "to_standing"]


def test_it_is_soft_until_the_trunk_rests(belief_of, frame_of, motions):
    recovery = Recovery(motions(*ALL), STANCE)
    for k in range(100):
        belief = belief_of(k / 300, pose="prone", w=(0, 2.0, 0))
        q = PRONE + 1e-4 * k
        np.testing.assert_array_equal(recovery.act(STILL, belief, frame_of(k / 300, q)).q, q)
    assert not recovery.log


def test_it_tries_again_and_gives_up_after_so_many_motions(live, motions):
    recovery = Recovery(motions(*ALL), STANCE, RecoveryConfig(tries=3))
    assert live(recovery, "prone", {}) == 3 * ["prone_to_crawl"]
    assert recovery.state == "failed" and "not up after 3 motions" in recovery.reason


def test_it_gives_up_in_time(live, motions):
    recovery = Recovery(motions(*ALL), STANCE, RecoveryConfig(tries=100, timeout=3.0))
    live(recovery, "prone", {})
    assert recovery.state == "failed" and "not up after 3 s" in recovery.reason


def test_without_a_motion_for_the_posture_it_says_so(live, motions):
    recovery = Recovery(motions("prone_to_crawl"), STANCE)
    live(recovery, "on_head", {})
    assert recovery.reason == "recovery: no motion for a robot that is 'on_head'"


def test_after_a_failed_motion_it_takes_the_next_for_that_posture(belief_of, frame_of, motion_of):
    """Askew, supine_to_crawl leaves its window at once; prone_to_crawl is next."""
    bad = motion_of(Stage(CRAWL, 0.2, window=Window(within=0.1)), name="supine_to_crawl")
    good = motion_of(Stage(CRAWL, 0.2))
    recovery = Recovery({"supine_to_crawl": bad, "prone_to_crawl": good}, STANCE)
    for k in range(60):
        recovery.act(STILL, belief_of(k / 30, pitch=np.pi / 4), frame_of(k / 30, PRONE))
    assert [name for _, _, name in recovery.log][:2] == ["supine_to_crawl", "prone_to_crawl"]


def test_only_a_stance_may_end_it(motions):
    with pytest.raises(InvalidInput, match="expected targets of 'crawling' or 'standing', got"):
        Recovery(motions(*ALL), {Posture.PRONE: PRONE})


def test_a_motion_that_ends_in_the_wanted_stance_comes_first(belief_of, frame_of, motion_of):
    up = motion_of(Stage(CRAWL, 0.2), name="supine_recovery", end="standing")
    over = motion_of(Stage(CRAWL, 0.2), name="supine_to_crawl")
    there = {"supine_recovery": up, "supine_to_crawl": over}
    for stance, first in (("crawling", "supine_to_crawl"), ("standing", "supine_recovery")):
        recovery = Recovery(there, {Posture(stance): CRAWL})
        for k in range(60):
            recovery.act(STILL, belief_of(k / 30, pitch=np.pi), frame_of(k / 30, PRONE))
        assert recovery.log[0][2] == first
