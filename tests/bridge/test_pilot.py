"""Who holds the controls, for how long, and what is refused."""

import numpy as np
import pytest

from mobius.bridge.pilot import SILENCE, Gamepad, Remote
from mobius.errors import InvalidInput
from mobius.modes import ModeMachine
from mobius.types import Mode, ModeCommand, StateEstimate

LIMITS = {
    Mode.CRAWL: (np.array([-0.5, -0.5, -1.0]), np.array([0.7, 0.5, 1.0])),
    Mode.BIPED: (np.array([-0.25, -0.15, -0.5]), np.array([0.25, 0.15, 0.5])),
}
ALL = frozenset(
    {Mode.CRAWL, Mode.BIPED, Mode.STAND_UP, Mode.LIE_DOWN, Mode.ROLL, Mode.PUSH_UPS, Mode.RECOVER}
)
STILL = np.zeros(3)


class Clock:
    now = 50.0

    def __call__(self) -> float:
        return self.now


class Errands:
    """Drives at 0.2 m/s as soon as it has a goal."""

    def __init__(self) -> None:
        self.goal = None

    def go(self, goal, at, actual) -> None:
        self.goal = goal

    def cancel(self) -> None:
        self.goal = None

    def command(self, belief, actual):
        if self.goal is None:
            return None
        return ModeCommand(Mode.BIPED, np.array([0.2, 0.0, 0.0]), belief.stamp)


def belief(stamp: float = 1.0) -> StateEstimate:
    return StateEstimate(stamp, STILL, [1, 0, 0, 0], STILL, STILL, np.ones(4))


def build(**options):
    clock = Clock()
    machine = ModeMachine(options.pop("available", ALL))
    return Remote(machine, LIMITS, clock=clock, **options), clock


def now(remote) -> ModeCommand:
    remote.attend(belief())
    return remote.command(belief())


def pad(*, held: bool, stop: bool = False, forward: float = 0.0, left: float = 0.0):
    axes, buttons = np.zeros(8), np.zeros(11, dtype=np.int64)
    axes[1], axes[0] = forward, left
    buttons[4], buttons[1] = held, stop
    return axes, buttons


def test_it_stands_until_somebody_wants_something():
    remote, _ = build()
    command = now(remote)
    assert command.mode is Mode.CRAWL
    np.testing.assert_array_equal(command.twist_H, STILL)


def test_a_twist_counts_until_half_a_second_of_silence():
    """At 60 Hz the last command that moves comes before 0.5 s, the first zero by then."""
    remote, clock = build()
    remote.take_twist(np.array([0.3, 0.1, -0.2]))
    np.testing.assert_array_equal(now(remote).twist_H, [0.3, 0.1, -0.2])
    clock.now += SILENCE - 1 / 60 - 1e-6
    np.testing.assert_array_equal(now(remote).twist_H, [0.3, 0.1, -0.2])
    clock.now += 1 / 60
    np.testing.assert_array_equal(now(remote).twist_H, STILL)
    assert clock.now - 50.0 <= SILENCE


def test_twists_are_clipped_to_what_the_body_can_do():
    remote, _ = build()
    remote.take_twist(np.array([9.0, -9.0, 0.5]))
    np.testing.assert_array_equal(now(remote).twist_H, [0.7, -0.5, 0.5])
    remote.machine.mode = Mode.BIPED
    np.testing.assert_array_equal(now(remote).twist_H, [0.25, -0.15, 0.5])
    remote.machine.mode = Mode.STAND_UP
    np.testing.assert_array_equal(now(remote).twist_H, STILL)


def test_the_speed_limit_is_a_share_of_that():
    remote, _ = build(speed=0.5)
    remote.take_twist(np.array([9.0, 0.0, 0.0]))
    np.testing.assert_array_equal(now(remote).twist_H, [0.35, 0.0, 0.0])
    for wrong in (0.0, 1.1, -1.0, np.nan):
        with pytest.raises(InvalidInput, match="speed: expected a share"):
            build(speed=wrong)


def test_a_stick_moves_nothing_unless_the_button_is_held():
    remote, clock = build()
    remote.take_joy(pad(held=False, forward=1.0))
    np.testing.assert_array_equal(now(remote).twist_H, STILL)
    remote.take_joy(pad(held=True, forward=1.0, left=-1.0))
    np.testing.assert_array_equal(now(remote).twist_H, [0.7, -0.5, 0.0])
    remote.take_joy(pad(held=True, forward=-0.5))
    np.testing.assert_array_equal(now(remote).twist_H, [-0.25, 0.0, 0.0])
    remote.take_joy(pad(held=False, forward=-0.5))  # let go: at once, not after the silence
    np.testing.assert_array_equal(now(remote).twist_H, STILL)
    remote.take_joy(pad(held=True, forward=1.0))
    clock.now += SILENCE
    np.testing.assert_array_equal(now(remote).twist_H, STILL)


def test_the_stick_comes_before_the_topic():
    remote, _ = build()
    remote.take_twist(np.array([0.1, 0.0, 0.0]))
    remote.take_joy(pad(held=True, forward=1.0))
    assert now(remote).twist_H[0] == 0.7


def test_a_pad_with_too_few_axes_or_buttons_is_refused():
    remote, _ = build()
    for axes, buttons in ((np.zeros(2), np.zeros(11)), (np.zeros(8), np.zeros(3))):
        with pytest.raises(InvalidInput, match="at least 4 axes and 5 buttons"):
            remote.take_joy((axes, buttons.astype(np.int64)))
    assert Gamepad().held == 4


def test_a_mode_is_asked_of_the_machine_and_one_that_is_not_there_refused():
    remote, _ = build(available=frozenset({Mode.CRAWL}))
    with pytest.raises(InvalidInput, match="expected one of crawl, stop, got 'biped'"):
        remote.take_mode(Mode.BIPED)
    remote, _ = build()
    for transition in (Mode.STAND_UP, Mode.RECOVER, Mode.CLIMB):
        with pytest.raises(InvalidInput, match="expected one of crawl, biped, roll, push_ups, st"):
            remote.take_mode(transition)
    remote.take_mode(Mode.BIPED)
    assert now(remote).mode is Mode.BIPED


def test_a_roll_is_wanted_once():
    remote, _ = build()
    remote.take_mode(Mode.ROLL)
    assert now(remote).mode is Mode.ROLL
    remote.machine.mode = Mode.ROLL
    assert now(remote).mode is Mode.CRAWL
    remote.machine.mode = Mode.CRAWL
    assert now(remote).mode is Mode.CRAWL


def test_a_mode_that_the_check_is_against_is_not_wanted_and_told_why():
    seen = []

    def check(mode, at):
        seen.append((mode, at.stamp))
        if mode is Mode.ROLL:
            raise InvalidInput("a wall is behind")

    remote, _ = build(check=check)
    remote.machine.mode = Mode.LIE_DOWN
    remote.take_mode(Mode.ROLL)
    assert now(remote).mode is Mode.ROLL and not seen  # looked at where it would begin
    remote.machine.mode = Mode.CRAWL
    assert now(remote).mode is Mode.CRAWL
    assert remote.refused == {"/mobius/mode_request": "a wall is behind"}
    remote.take_mode(Mode.PUSH_UPS)
    assert now(remote).mode is Mode.PUSH_UPS
    assert [mode for mode, _ in seen] == [Mode.ROLL, Mode.PUSH_UPS]


def test_a_stop_overtakes_a_goal_that_waits_for_the_first_sample():
    errands = Errands()
    remote, _ = build(errands=errands)
    remote.take_goal(np.ones(2))
    remote.take_stop(True)
    remote.attend(None)
    assert remote.machine.stopped and errands.goal is None
    remote.attend(belief())
    assert errands.goal is None  # nor is the goal of before it gone to afterwards


def test_a_stop_is_carried_out_before_any_sample_and_held_until_its_release():
    remote, _ = build()
    remote.take_stop(True)
    remote.attend(None)
    assert remote.machine.stopped
    remote.take_twist(np.array([0.3, 0.0, 0.0]))
    remote.take_mode(Mode.BIPED)
    remote.attend(belief())
    assert remote.machine.stopped  # nothing but the release ends it
    remote.take_stop(False)
    remote.attend(belief())
    assert remote.machine.mode is Mode.RECOVER
    assert remote.wanted is Mode.CRAWL


@pytest.mark.parametrize("how", ["mode", "button"])
def test_the_mode_stop_and_the_pads_button_stop_too(how):
    remote, _ = build()
    if how == "mode":
        remote.take_mode(Mode.STOP)
    else:
        remote.take_joy(pad(held=False, stop=True))
    remote.attend(belief())
    assert remote.machine.stopped


def test_a_held_stop_button_stops_once():
    remote, _ = build()
    remote.take_joy(pad(held=False, stop=True))
    remote.attend(belief())
    remote.take_stop(False)
    remote.take_joy(pad(held=False, stop=True))
    remote.attend(belief())
    assert not remote.machine.stopped


def test_a_goal_is_driven_to_until_somebody_takes_the_controls():
    errands = Errands()
    remote, _ = build(errands=errands)
    remote.take_goal(np.array([3.0, 1.0]))
    command = now(remote)
    assert (command.mode, command.twist_H[0]) == (Mode.BIPED, 0.2)
    remote.take_twist(np.array([0.1, 0.0, 0.0]))
    assert now(remote).twist_H[0] == 0.1
    assert errands.goal is None


@pytest.mark.parametrize("take", ["mode", "stop", "joy"])
def test_anything_else_ends_the_errand_as_well(take):
    errands = Errands()
    remote, _ = build(errands=errands)
    remote.take_goal(np.array([3.0, 1.0]))
    now(remote)
    {
        "mode": lambda: remote.take_mode(Mode.CRAWL),
        "stop": lambda: remote.take_stop(True),
        "joy": lambda: remote.take_joy(pad(held=True)),
    }[take]()
    remote.attend(belief())
    assert errands.goal is None


def test_a_goal_given_while_a_twist_is_fresh_waits_for_its_silence():
    errands = Errands()
    remote, clock = build(errands=errands)
    remote.take_twist(np.array([0.1, 0.0, 0.0]))
    now(remote)
    remote.take_goal(np.array([3.0, 1.0]))
    assert now(remote).twist_H[0] == 0.1
    clock.now += SILENCE
    assert now(remote).twist_H[0] == 0.2


def test_a_goal_without_a_map_is_refused():
    remote, _ = build()
    with pytest.raises(InvalidInput, match="no map to plan on; start with --map"):
        remote.take_goal(np.zeros(2))


def test_a_flood_of_requests_pushes_no_stop_out():
    remote, _ = build()
    remote.take_stop(True)
    with pytest.raises(InvalidInput, match="100 orders wait already"):
        for _ in range(200):
            remote.take_mode(Mode.BIPED)
    remote.attend(belief())
    assert remote.machine.stopped
    for _ in range(100):
        remote.take_mode(Mode.CRAWL)
    remote.take_stop(False)  # the 101st
    remote.attend(belief())
    assert not remote.machine.stopped
