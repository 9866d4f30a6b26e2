"""The evaluation: what it counts, and that the shipped policy passes on a few seeds."""

import numpy as np

from mobius.control.bodies import body_of
from mobius.evaluate import EPISODE_S, HOLD_S, commands_of, tracking


def test_commands_cover_the_range_and_repeat_by_seed():
    body = body_of("crawl")
    commands = np.concatenate([commands_of("crawl", s) for s in range(60)])
    np.testing.assert_array_equal(commands_of("crawl", 4), commands_of("crawl", 4))
    assert len(commands_of("crawl", 0)) * HOLD_S == EPISODE_S
    assert (commands >= body.command_low).all() and (commands <= body.command_high).all()
    assert (np.abs(commands).max(axis=0) > 0.9 * np.array(body.command_high)).all()
    assert (commands == 0).all(axis=1).any()


def test_shipped_policy_tracks_in_the_whole_stack():
    """Two seeds of the acceptance run (100 seeds: ``mobius eval crawl tracking``)."""
    result = tracking("crawl", seeds=2, seed=1000, workers=1)
    assert result.falls == 0
    assert result.mae["vx"] <= 0.03 and result.mae["vy"] <= 0.03 and result.mae["wz"] <= 0.06
    assert result.loop_residual_mm < 1.0
    assert set(result.as_json()) >= {"episodes", "falls", "mae", "seed"}
