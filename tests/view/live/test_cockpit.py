"""Keys, gamepad and focus become beats and requests."""

import numpy as np
import pytest

from mobius.view.live.cockpit import FRAME_STALE, Cockpit, twist_of
from mobius.view.live.nouns import Halt, Release, WantMode
from mobius.view.live.pulse import Pulse


class Clock:
    now = 50.0

    def __call__(self):
        return self.now


def at_a_page(driving=True):
    clock = Clock()
    pulse = Pulse(clock)
    pulse.enter("a")
    cockpit = Cockpit(pulse, clock)
    cockpit.driving = driving
    return cockpit, pulse, clock


def say(pulse, keys=(), focus=True, pad=None):
    import json

    pulse.hear("a", json.dumps({"focus": focus, "keys": list(keys), "pad": pad}))


def test_keys_against_each_other_cancel():
    assert twist_of(frozenset({"ArrowUp", "KeyQ", "ArrowLeft"})) == (1.0, 1.0, 1.0)
    assert twist_of(frozenset({"ArrowUp", "ArrowDown", "KeyE"})) == (0.0, -1.0, 0.0)


def test_keys_move_the_robot_only_while_drive_is_on():
    cockpit, pulse, _ = at_a_page(driving=False)
    say(pulse, ["ArrowUp"])
    assert cockpit.beat().share == (0.0, 0.0, 0.0) and not cockpit.beat().driving
    cockpit.driving = True
    assert cockpit.beat().share == (1.0, 0.0, 0.0) and cockpit.beat().driving


def test_a_tap_shorter_than_a_look_is_not_lost():
    cockpit, pulse, _ = at_a_page()
    for keys in (["Space"], [], ["KeyR"], [], ["Digit2"], []):
        say(pulse, keys)
    cockpit.beat()
    kinds = {type(request) for request in cockpit.requests}
    assert kinds == {Halt, Release, WantMode}
    assert WantMode("biped") in cockpit.requests
    cockpit.requests.clear()
    cockpit.beat()
    assert not cockpit.requests


def test_digits_that_are_typed_into_a_field_are_no_commands():
    cockpit, pulse, _ = at_a_page()
    cockpit.typing = True
    say(pulse, ["Digit2", "ArrowUp"])
    beat = cockpit.beat()
    assert not cockpit.requests and beat.share == (0.0, 0.0, 0.0)
    say(pulse, ["Space"])  # but a stop is a stop
    cockpit.beat()
    assert [type(r) for r in cockpit.requests] == [Halt]


def test_losing_the_focus_while_driving_stops_once():
    cockpit, pulse, _ = at_a_page()
    say(pulse, focus=True)
    cockpit.beat()
    say(pulse, focus=False)
    cockpit.beat()
    cockpit.beat()
    assert [type(r) for r in cockpit.requests] == [Halt]
    cockpit, pulse, _ = at_a_page(driving=False)
    say(pulse, focus=False)
    cockpit.beat()
    assert not cockpit.requests


def test_a_page_that_hangs_with_a_key_down_lets_go_first_and_is_gone_then():
    cockpit, pulse, clock = at_a_page()
    say(pulse, ["ArrowUp"])
    clock.now += 0.5
    beat = cockpit.beat()
    assert beat.page and beat.share == (0.0, 0.0, 0.0)
    clock.now += 1.0
    assert not cockpit.beat().page


def test_a_window_speaks_with_its_frames():
    clock = Clock()
    cockpit = Cockpit(None, clock)
    cockpit.driving = True
    cockpit.press(frozenset({"ArrowDown", "Digit3"}))
    assert cockpit.beat().share == (-1.0, 0.0, 0.0)
    assert cockpit.requests.popleft() == WantMode("roll")
    clock.now += FRAME_STALE + 0.01
    assert not cockpit.beat().page


def test_the_gamepad_drives_only_while_its_dead_mans_button_is_held():
    cockpit, pulse, _ = at_a_page(driving=False)
    axes, held = [0.0, -1.0, 0.5, 0.0], [0] * 16
    say(pulse, pad={"axes": axes, "buttons": held})
    assert not cockpit.beat().driving
    held[4] = 1
    say(pulse, pad={"axes": axes, "buttons": held})
    beat = cockpit.beat()
    assert beat.driving and beat.share[0] == 1.0 and beat.share[1] == 0.0
    assert beat.share[2] == pytest.approx(-(0.5 - 0.15) / 0.85)
    say(pulse, pad={"axes": [0.1, 0.1, 0.1, 0.0], "buttons": held})
    assert np.allclose(cockpit.beat().share, 0.0)


def test_the_gamepads_stop_button_stops_without_the_dead_mans():
    cockpit, pulse, _ = at_a_page(driving=False)
    say(pulse, pad={"axes": [0.0] * 4, "buttons": [0, 1, 0, 0]})
    cockpit.beat()
    cockpit.beat()
    assert [type(r) for r in cockpit.requests] == [Halt]
