"""The mode machine: transitions in between, hysteresis, time-outs, falls, stop and release."""

from itertools import pairwise

import numpy as np
import pytest

from mobius.errors import InvalidInput
from mobius.model.poses import Stance, stance_keyframe
from mobius.model.robot import keyframe_joints
from mobius.modes import SUCCESSORS, ModeMachine, Seen, Trust, TrustWatch
from mobius.modes.machine import LEADS_TO, TOWARDS
from mobius.types import Mode, ModeCommand, StateEstimate

M = Mode
ALL = frozenset({M.CRAWL, M.BIPED, M.ROLL, M.GATHER, M.STAND_UP, M.LIE_DOWN, M.RECOVER, M.PUSH_UPS})
POSES = {M.CRAWL: "crawl", M.BIPED: "stand"}


OUT = stance_keyframe(Stance(arm_r=0.24, arm_turn=0.30, leg_r=0.19, leg_turn=0.20))[0]
"""Where a policy may stand; its feet are 0.07 to 0.11 m from those of the keyframe."""


class World:
    """Time goes on; motions are done after ``motion_s``."""

    def __init__(self, belief_of, machine, motion_s=1.0):
        self.belief_of, self.machine, self.motion_s = belief_of, machine, motion_s
        self.t, self.since, self.mode = 0.0, 0.0, machine.mode
        self.state, self.pose, self.v = None, None, (0.0, 0.0, 0.0)
        self.apart, self.joints = False, None

    def go(self, wanted, seconds, twist=(0.1, 0.0, 0.0)):
        """The modes that were on, without repeats."""
        modes = []
        for _ in range(round(seconds * 60)):
            done = self.t - self.since >= self.motion_s
            state = self.state or ("done" if done else "running")
            pose = self.pose or POSES.get(self.machine.mode, "crawl")
            seen = Seen(
                self.belief_of(self.t, pose=pose, v=self.v),
                keyframe_joints_of(pose) if self.joints is None else self.joints,
                state,
                apart=self.apart and self.machine.mode is M.CRAWL,
                home=_JOINTS["crawl"],
            )
            command = self.machine.step(ModeCommand(wanted, twist, self.t), seen)
            if command.mode is not self.mode:
                self.mode, self.since = command.mode, self.t
            if not modes or modes[-1] is not command.mode:
                modes.append(command.mode)
            self.command, self.t = command, self.t + 1 / 60
        return modes


_JOINTS = {k: keyframe_joints(k)[0] for k in ("crawl", "stand", "prone")}


def keyframe_joints_of(pose):
    return _JOINTS[pose]


@pytest.fixture
def world(belief_of):
    def build(available=ALL, mode=M.CRAWL, **more):
        return World(belief_of, ModeMachine(available, mode=mode), **more)

    return build


@pytest.mark.parametrize(
    ("mode", "wanted", "way"),
    [
        (M.CRAWL, M.BIPED, [M.CRAWL, M.STAND_UP, M.BIPED]),
        (M.BIPED, M.CRAWL, [M.BIPED, M.LIE_DOWN, M.CRAWL]),
        (M.BIPED, M.ROLL, [M.BIPED, M.LIE_DOWN, M.CRAWL, M.ROLL, M.CRAWL]),
        (M.CRAWL, M.ROLL, [M.CRAWL, M.ROLL, M.CRAWL]),
        (M.CRAWL, M.PUSH_UPS, [M.CRAWL, M.PUSH_UPS, M.CRAWL]),
    ],
)
def test_it_inserts_what_lies_between(world, mode, wanted, way):
    w = world(mode=mode)
    seconds = 2.2 * (len(way) // 2)
    assert w.go(wanted, seconds)[: len(way)] == way
    assert all(b in SUCCESSORS[a] for a, b in pairwise(way))
    assert [(e.before, e.after) for e in w.machine.events][: len(way) - 1] == list(pairwise(way))


@pytest.mark.parametrize(
    ("wanted", "way"),
    [
        (M.BIPED, [M.CRAWL, M.GATHER, M.STAND_UP, M.BIPED]),
        (M.ROLL, [M.CRAWL, M.GATHER, M.ROLL, M.CRAWL]),
        (M.PUSH_UPS, [M.CRAWL, M.GATHER, M.PUSH_UPS, M.CRAWL]),
    ],
)
def test_a_policy_that_stands_apart_gathers_first(world, wanted, way):
    w = world()
    w.apart, w.joints = True, OUT
    assert w.go(wanted, 3.2)[: len(way)] == way
    assert all(b in SUCCESSORS[a] for a, b in pairwise(way))


def test_a_policy_that_does_not_or_a_robot_that_cannot_gather_goes_straight_on(world):
    assert world().go(M.BIPED, 1.0) == [M.CRAWL, M.STAND_UP]
    without = world(ALL - {M.GATHER})
    without.apart, without.joints = True, OUT
    assert without.go(M.BIPED, 1.0) == [M.CRAWL, M.STAND_UP]


def test_feet_that_are_there_already_need_no_gathering(world):
    w = world()
    w.apart = True  # the policy would stand elsewhere, but the robot has not walked yet
    assert w.go(M.BIPED, 1.0) == [M.CRAWL, M.STAND_UP]


def test_what_it_gathered_for_follows_whatever_is_wanted_then(world):
    """Sources ask for a roll until the robot is no longer crawling, and then to crawl."""
    w = world()
    w.apart, w.joints = True, OUT
    assert w.go(M.ROLL, 0.9)[-1] is M.GATHER
    assert w.go(M.CRAWL, 2.5) == [M.GATHER, M.ROLL, M.CRAWL]


@pytest.mark.parametrize("state", ["failed", "running"])
def test_gathering_that_fails_or_never_ends_leads_to_recovery(world, state):
    w = world(motion_s=1e9)
    w.apart, w.joints = True, OUT
    w.go(M.BIPED, 0.9)
    w.state = state
    w.go(M.BIPED, w.machine.config.timeout + 0.1)
    assert [e.after for e in w.machine.events[:2]] == [M.GATHER, M.RECOVER]


def test_a_short_request_changes_nothing_but_stops_the_twist(world):
    w = world()
    w.go(M.CRAWL, 0.5)
    assert w.command.twist_H[0] == 0.1
    assert w.go(M.BIPED, 0.25) == [M.CRAWL]
    assert not w.command.twist_H.any()
    assert w.go(M.CRAWL, 2.0) == [M.CRAWL] and not w.machine.events


def test_it_stands_still_before_it_switches(world):
    w = world()
    config = w.machine.config
    assert w.go(M.BIPED, config.persist + config.settle - 0.05) == [M.CRAWL]
    assert w.go(M.BIPED, 0.1)[-1] is M.STAND_UP
    moving = world()
    moving.v = (0.3, 0.0, 0.0)
    assert moving.go(M.BIPED, config.persist + config.settle_most - 0.05) == [M.CRAWL]
    assert moving.go(M.BIPED, 0.1)[-1] is M.STAND_UP


def test_a_roll_that_is_wanted_on_is_followed_by_another(world):
    w = world()
    modes = w.go(M.ROLL, 4.0)
    assert modes == [M.CRAWL, M.ROLL, M.CRAWL, M.ROLL, M.CRAWL]


def test_a_fall_leads_over_recovery_to_crawl(world):
    w = world(mode=M.BIPED)
    w.pose = "prone"
    assert w.go(M.BIPED, 0.3)[-1] is M.RECOVER
    assert "fall" in w.machine.events[-1].why
    w.pose = None
    assert w.go(M.CRAWL, 1.5) == [M.RECOVER, M.CRAWL]


def test_without_recovery_nobody_looks_for_falls(world):
    w = world(frozenset({M.CRAWL}))
    w.pose = "prone"
    assert w.go(M.CRAWL, 1.0) == [M.CRAWL]


@pytest.mark.parametrize("state", ["failed", "running"])
def test_a_motion_that_fails_or_never_ends_leads_to_recovery(world, state):
    w = world(motion_s=1e9)
    w.go(M.BIPED, 0.9)
    w.state = state
    modes = w.go(M.BIPED, w.machine.config.timeout + 0.1)
    assert modes[-1] is M.RECOVER or M.RECOVER in modes
    assert w.machine.events[1].after is M.RECOVER


def test_a_recovery_that_fails_stops_the_robot(world):
    w = world(mode=M.RECOVER)
    w.state = "failed"
    assert w.go(M.CRAWL, 0.2) == [M.STOP]
    assert w.machine.stopped and "release" in w.machine.notice


def test_a_recovery_that_ends_standing_goes_on_as_biped(world):
    w = world(mode=M.RECOVER, motion_s=0.2)
    w.pose = "stand"
    assert w.go(M.BIPED, 0.5) == [M.RECOVER, M.BIPED]


@pytest.mark.parametrize("mode", sorted(ALL))
def test_the_emergency_stop_works_from_every_mode_until_release(world, mode):
    w = world(mode=mode, motion_s=0.5)
    w.go(M.CRAWL, 0.1)
    w.machine.emergency_stop()
    for wanted in (M.CRAWL, M.BIPED, M.ROLL):
        assert w.go(wanted, 1.0) == [M.STOP]
        assert not w.command.twist_H.any()
    w.machine.release()
    assert w.go(M.CRAWL, 1.0) == [M.RECOVER, M.CRAWL]


def test_release_without_recovery_goes_on_as_before(world):
    w = world(frozenset({M.BIPED}), mode=M.BIPED)
    w.machine.emergency_stop()
    w.go(M.BIPED, 0.5)
    w.machine.release()
    assert w.go(M.BIPED, 0.1) == [M.BIPED]


def test_an_impossible_request_is_explained_once_and_the_robot_stands(world):
    w = world(frozenset({M.CRAWL, M.BIPED}))
    assert w.go(M.BIPED, 2.0) == [M.CRAWL]
    assert not w.command.twist_H.any()
    assert w.machine.notice == (
        "mode 'biped' may not follow 'crawl' without a motion 'stand_up'; legal: crawl"
    )
    assert len(w.machine.events) == 1 and w.machine.events[0].after is M.CRAWL
    w.go(M.CRAWL, 0.1)
    assert w.machine.notice == ""


def test_a_transition_is_not_to_be_asked_for(world):
    w = world()
    assert w.go(M.LIE_DOWN, 2.0) == [M.CRAWL]
    assert "'lie_down' may not follow 'crawl'" in w.machine.notice


def test_a_mode_without_controller_is_a_mistake_of_the_program(world):
    with pytest.raises(InvalidInput, match="no controller yet; available: crawl"):
        world(frozenset({M.CRAWL})).go(M.ROLL, 0.1)


def test_the_tables_agree():
    assert all(via in SUCCESSORS[a] for (a, _), via in TOWARDS.items())
    assert all(b in SUCCESSORS[a] for a, b in LEADS_TO.items())


def _at(pitch, rate=0.0):
    """A belief of a trunk at a pitch [rad] that turns at a rate [rad/s] about its side axis."""
    q = [np.cos(pitch / 2), 0.0, np.sin(pitch / 2), 0.0]
    zero = np.zeros(3)
    return StateEstimate(
        stamp=0.0, p_OB=zero, q_OB=q, v_B=zero, w_B=(0.0, rate, 0.0), contact=np.zeros(4)
    )


def test_trust_by_mode():
    watch = TrustWatch()
    level = _at(0.0)
    assert watch.see(M.CRAWL, level) == watch.see(M.BIPED, level) == Trust()
    for mode in (M.STAND_UP, M.LIE_DOWN, M.RECOVER, M.STOP):
        assert not watch.see(mode, level).ground


def test_a_roll_is_believed_by_limbs_and_camera_until_it_goes_over_and_by_the_camera_after():
    watch = TrustWatch()
    rearing = watch.see(M.ROLL, _at(-0.8))
    assert rearing.vio and rearing.legs
    over = [watch.see(M.ROLL, _at(a, -6.0)) for a in (-1.4, -2.5, 2.8, 1.6, 0.2)]
    assert not any(t.vio or t.legs or t.ground for t in over)
    landed = watch.see(M.ROLL, _at(0.1))
    assert landed.vio and not landed.legs
    assert watch.see(M.ROLL, _at(-0.3)) == landed
    assert watch.see(M.CRAWL, _at(0.0)) == Trust()
    assert watch.see(M.ROLL, _at(0.0)).legs


def test_a_robot_that_falls_again_and_again_stops(world):
    w = world()
    w.pose = "prone"
    modes = w.go(M.CRAWL, 40.0)
    assert modes[-1] is M.STOP
    assert modes.count(M.RECOVER) == w.machine.config.tries
    assert "fallen 5 times in a row" in w.machine.notice


def test_falls_far_apart_are_not_counted_together(world):
    w = world()
    for _ in range(6):
        w.pose = "prone"
        assert M.RECOVER in w.go(M.CRAWL, 1.5)
        w.pose = None
        w.go(M.CRAWL, w.machine.config.calm + 4.0)
    assert not w.machine.stopped
