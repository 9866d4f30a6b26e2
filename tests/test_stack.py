"""The loop: rates, order, and that controllers see the belief and never the truth."""

import numpy as np
import pytest

from mobius.errors import InvalidInput
from mobius.model.robot import keyframe_joints
from mobius.modes import ModeMachine
from mobius.robot import GhostRobot
from mobius.stack import Stack
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
        self.calls = 0

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
