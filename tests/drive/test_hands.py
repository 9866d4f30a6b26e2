"""The dead man's switch."""

import numpy as np
import pytest

from mobius.control.bodies import BODIES
from mobius.drive.hands import GONE, STALE, Hands
from mobius.errors import InvalidInput
from mobius.types import Mode
from mobius.view.live.nouns import Beat

AHEAD = Beat(page=True, driving=True, share=(1.0, 0.0, 0.0))


def test_a_held_key_asks_for_the_bodys_greatest_speed_and_the_limit_bounds_it():
    hands = Hands()
    hands.take(AHEAD, 10.0)
    assert hands.twist(Mode.CRAWL, 10.0).tolist() == [0.7, 0.0, 0.0]
    assert hands.twist(Mode.BIPED, 10.0)[0] == BODIES["biped"].command_high[0]
    hands.set_limit(0.5)
    assert hands.twist(Mode.CRAWL, 10.0)[0] == pytest.approx(0.35)


def test_backwards_is_bounded_by_the_slowest_command():
    hands = Hands()
    hands.take(Beat(driving=True, share=(-1.0, 0.0, -0.5)), 0.0)
    low = BODIES["crawl"].command_low
    assert np.allclose(hands.twist(Mode.CRAWL, 0.0), [low[0], 0.0, 0.5 * low[2]])


@pytest.mark.parametrize(
    "beat",
    [
        Beat(driving=False, share=(1.0, 0.0, 0.0)),
        Beat(page=False, driving=True, share=(1.0, 0.0, 0.0)),
        Beat(driving=True),
    ],
)
def test_no_key_no_drive_or_no_page_moves_nothing(beat):
    hands = Hands()
    hands.take(beat, 0.0)
    assert not hands.holding(0.0) and not hands.twist(Mode.CRAWL, 0.0).any()


def test_a_beat_that_grows_old_lets_go_though_it_said_that_a_key_is_held():
    hands = Hands()
    hands.take(AHEAD, 0.0)
    assert hands.holding(STALE)
    assert not hands.holding(STALE + 0.01)


def test_motions_between_bodies_take_no_twist():
    hands = Hands()
    hands.take(AHEAD, 0.0)
    assert not hands.twist(Mode.STAND_UP, 0.0).any()


def test_who_drove_and_is_gone_is_noticed_once():
    hands = Hands()
    hands.take(AHEAD, 0.0)
    assert hands.lost(GONE) == ""
    assert hands.lost(GONE + 0.01) == "the viewer is gone"
    assert hands.lost(GONE + 0.02) == ""


def test_a_page_that_is_dropped_is_noticed_at_the_next_beat():
    hands = Hands()
    hands.take(AHEAD, 0.0)
    hands.take(Beat(page=False), 0.02)
    assert hands.lost(0.02) == "the page is gone"


def test_who_only_watched_may_go():
    hands = Hands()
    hands.take(Beat(page=True), 0.0)
    assert hands.lost(100.0) == ""
    hands.take(Beat(page=True), 200.0)
    hands.touch(200.0)  # and asked for a body
    assert hands.lost(300.0) == "the viewer is gone"


@pytest.mark.parametrize("share", [(2.0, 0, 0), (float("nan"), 0, 0), (0.0, 0.0)])
def test_shares_beyond_one_or_no_numbers_are_refused(share):
    with pytest.raises(InvalidInput, match="3 numbers from -1 to 1"):
        Hands().take(Beat(driving=True, share=share), 0.0)


@pytest.mark.parametrize(("beat", "at"), [(Beat(page=False), 0.0), (Beat(), GONE + 0.01)])
def test_where_nobody_is_nothing_can_be_asked(beat, at):
    hands = Hands()
    hands.take(AHEAD, 0.0)
    hands.take(beat, 0.0)
    with pytest.raises(InvalidInput, match="nobody is at the controls"):
        hands.touch(at)
    assert "gone" in hands.lost(at)  # a late click does not disarm the switch


def test_after_a_stop_keys_count_once_they_have_been_let_go():
    hands = Hands()
    hands.take(AHEAD, 0.0)
    hands.let_go()
    hands.take(AHEAD, 0.1)
    assert not hands.holding(0.1) and not hands.twist(Mode.CRAWL, 0.1).any()
    hands.take(Beat(driving=True), 0.2)
    hands.take(AHEAD, 0.3)
    assert hands.holding(0.3)


@pytest.mark.parametrize("limit", [0.0, -1.0, 1.5, float("nan")])
def test_a_speed_limit_is_a_share(limit):
    with pytest.raises(InvalidInput, match="speed limit"):
        Hands().set_limit(limit)
