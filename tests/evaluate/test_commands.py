"""Commands are drawn by seed, without repeats, and stay where they are asked to."""

import numpy as np
import pytest

from mobius.control.bodies import body_of
from mobius.evaluate.commands import NAMED, STRAIGHT, moving, schedule, segment_of


def test_a_schedule_follows_from_its_seed_and_repeats_no_command():
    first = schedule("crawl", 4)
    assert first == schedule("crawl", 4) != schedule("crawl", 5)
    assert len({s.name for s in first}) == len(first) == 5


def test_every_command_is_drawn_and_any_may_come_first():
    drawn = [schedule("biped", seed) for seed in range(60)]
    assert {s.name for segments in drawn for s in segments} == set(NAMED)
    assert {segments[0].name for segments in drawn} == set(NAMED)


@pytest.mark.parametrize("body", ["crawl", "biped"])
def test_named_commands_are_the_ends_of_the_range_and_speed_scales_them(body):
    rng = np.random.default_rng(0)
    low, high = body_of(body).command_low, body_of(body).command_high
    ends = {name: segment_of(name, body, rng).twist for name in NAMED}
    assert ends["forward"] == (high[0], 0.0, 0.0) and ends["backward"] == (low[0], 0.0, 0.0)
    assert ends["left"] == (0.0, high[1], 0.0) and ends["right"] == (0.0, low[1], 0.0)
    assert ends["turn_left"] == (0.0, 0.0, high[2]) and ends["turn_right"] == (0.0, 0.0, low[2])
    assert ends["stand"] == (0.0, 0.0, 0.0)
    assert (np.array(low) <= ends["mixed"]).all() and (np.array(high) >= ends["mixed"]).all()
    half = segment_of("forward", body, rng, speed=0.5).twist
    assert half[0] == pytest.approx(0.5 * high[0])


def test_straight_commands_do_not_turn():
    rng = np.random.default_rng(0)
    assert all(segment_of(name, "crawl", rng).twist[2] == 0.0 for name in STRAIGHT)


def test_a_moving_command_is_at_its_share_of_the_range_in_one_component():
    rng, high = np.random.default_rng(1), np.array(body_of("biped").command_high)
    for _ in range(50):
        share = np.abs(np.array(moving("biped", rng, share=0.6).twist)) / high
        assert share.max() == pytest.approx(0.6)
