"""The loop: rates, order, and that controllers see the belief and never the truth."""

import numpy as np
import pytest

from mobius.errors import InvalidInput
from mobius.model.robot import keyframe_joints
from mobius.modes import ModeMachine
from mobius.robot import GhostRobot
from mobius.stack import ACT_EVERY, Stack
from mobius.types import JointCommand, Mode, ModeCommand, StateEstimate

STANCE, _ = keyframe_joints("crawl")


class Senses:
    def __init__(self) -> None:
        self.calls = 0

    def corrupt(self, frame):
        self.calls += 1
        return frame


class Belief:
    """An estimator that believes something false on purpose."""

    def __init__(self) -> None:
        self.calls, self.told = 0, []

    def trust(self, **sources):
        self.told.append(sources)

    def take(self, frame):
        self.calls += 1
        self.stamp = frame.stamp

    def belief(self):
        zero = np.zeros(3)
        return StateEstimate(self.stamp, [7.0, 8.0, 9.0], [1, 0, 0, 0], zero, zero, np.ones(4))


class Hold:
    def __init__(self) -> None:
        self.seen, self.resets = [], 0

    def reset(self):
        self.resets += 1

    def act(self, command, belief, frame):
        self.seen.append((command, belief))
        return JointCommand(STANCE, frame.stamp)


def build():
    parts = Senses(), Belief(), Hold()
    stack = Stack(
        GhostRobot(STANCE),
        senses=parts[0],
        estimator=parts[1],
        machine=ModeMachine(frozenset({Mode.CRAWL})),
        controllers={Mode.CRAWL: parts[2]},
    )
    return stack, *parts


def still(belief):
    return ModeCommand(Mode.CRAWL, [0.1, 0, 0], belief.stamp)


def test_rates_over_one_second():
    stack, senses, belief, hold = build()
    samples = [s for s in (stack.turn(still) for _ in range(600)) if s is not None]
    assert senses.calls == belief.calls == 300
    assert len(samples) == len(hold.seen) == 60
    assert [s.tick for s in samples[:3]] == [0, 10, 20]
    assert hold.resets == 1


def test_source_and_controller_see_the_belief():
    stack, _, _, hold = build()
    places = []

    def source(belief):
        places.append(belief.p_OB.tolist())
        return still(belief)

    for _ in range(30):
        stack.turn(source)
    assert places == [[7.0, 8.0, 9.0]] * 3
    assert all(b.p_OB[0] == 7.0 for _, b in hold.seen)


def test_a_mode_without_controller_is_refused():
    with pytest.raises(InvalidInput, match="no controller for mode crawl"):
        Stack(
            GhostRobot(STANCE),
            senses=Senses(),
            estimator=Belief(),
            machine=ModeMachine(frozenset({Mode.CRAWL})),
            controllers={},
        )


class Quick(Hold):
    """A controller at 300 Hz that learns what was sent before."""

    every = 2
    state, reason = "running", ""

    def begin(self, targets):
        self.began = targets


def roll_stack(quick):
    belief = Belief()
    stack = Stack(
        GhostRobot(STANCE),
        senses=Senses(),
        estimator=belief,
        machine=ModeMachine(frozenset({Mode.CRAWL, Mode.ROLL})),
        controllers={Mode.CRAWL: Hold(), Mode.ROLL: quick},
    )
    return stack, belief


def want(mode):
    return lambda belief: ModeCommand(mode, np.zeros(3), belief.stamp)


def turn(stack, mode, seconds):
    samples = (stack.turn(want(mode)) for _ in range(round(600 * seconds)))
    return [s for s in samples if s is not None]


def test_a_motion_acts_at_300_hz_and_samples_stay_at_60():
    quick = Quick()
    stack, _ = roll_stack(quick)
    samples = turn(stack, Mode.ROLL, 0.8) + turn(stack, Mode.ROLL, 1.0)
    assert [s.tick for s in samples] == list(range(0, 1080, 10))
    rolling = sum(s.command.mode is Mode.ROLL for s in samples)
    assert rolling > 50 and len(quick.seen) == 5 * rolling
    np.testing.assert_array_equal(quick.began, STANCE)


def test_the_machine_hears_that_a_motion_is_done_and_the_estimator_whom_to_trust():
    quick = Quick()
    stack, belief = roll_stack(quick)
    turn(stack, Mode.ROLL, 1.0)
    assert stack.machine.mode is Mode.ROLL
    quick.state = "done"
    turn(stack, Mode.CRAWL, 0.1)
    assert stack.machine.mode is Mode.CRAWL
    assert belief.told == [
        dict(vio=True, legs=True, ground=False),  # level still: it has not gone over
        dict(vio=True, legs=True, ground=True),
    ]


def test_an_emergency_stop_makes_the_servos_soft_then_holds():
    stack, _, _, hold = build()
    for _ in range(60):
        stack.turn(still)
    stack.machine.emergency_stop()
    seen = len(hold.seen)
    sample = stack.turn(still)
    assert sample.command.mode is Mode.STOP
    np.testing.assert_array_equal(sample.sent.q, sample.frame.q)
    assert len(hold.seen) == seen


def test_an_emergency_stop_in_a_motion_waits_neither_for_the_next_sample_nor_for_the_source():
    stack, _ = roll_stack(Quick())
    turn(stack, Mode.ROLL, 1.0)
    assert stack.machine.mode is Mode.ROLL
    while stack.tick % ACT_EVERY != 3:
        stack.turn(want(Mode.ROLL))
    stack.machine.emergency_stop()

    def broken(belief):
        raise RuntimeError("the source is gone")

    stack.turn(broken)
    assert stack._active is Mode.STOP
    for _ in range(2 * ACT_EVERY):
        sample = stack.turn(broken)
    assert sample is None or sample.command.mode is Mode.STOP
    assert stack.machine.stopped


def test_a_controller_out_of_step_is_refused():
    quick = Quick()
    quick.every = 3
    stack, _ = roll_stack(quick)
    with pytest.raises(InvalidInput, match="expected every = 2 or 10 ticks, got 3"):
        turn(stack, Mode.ROLL, 1.0)
