"""Tracking: per command and over all, and that the shipped policies do it."""

import json

import numpy as np
import pytest

from mobius.errors import InvalidInput, UnknownName
from mobius.evaluate.commands import Segment
from mobius.evaluate.episode import Setup
from mobius.evaluate.tracking import (
    SegmentScore,
    per_command,
    slip_fraction,
    stillness,
    summarise,
    track,
    tracking,
)

FORWARD = Segment("forward", (0.15, 0.0, 0.0))
STAND = Segment("stand", (0.0, 0.0, 0.0))


def score(**changes) -> SegmentScore:
    usual = dict(name="forward", target=[0.2, 0, 0], mean=[0.18, 0, 0], mae=[0.02, 0, 0])
    return SegmentScore(**{**usual, "power_W": 20.0, "fallen": False, **changes})


@pytest.fixture(scope="module")
def run():
    """The shipped biped, forward and then standing."""
    return track(Setup("biped", 1000), segments=[FORWARD, STAND], hold_s=3.0)


def test_the_shipped_policy_walks_on_command_and_stands_still(run):
    assert not run.fallen
    forward, stand = run.segments
    assert forward.mean[0] == pytest.approx(0.15, abs=0.05)
    assert forward.mae[0] < 0.05 and forward.distance_m > 0.2
    assert stand.still_s == pytest.approx(1.5, abs=0.01) and stand.joint_speed_rms < 0.1
    assert stand.distance_m == 0.0, "slip is measured straight on only"
    assert run.loop_residual_mm < 1.0


def test_a_run_and_its_summary_are_plain_values(run):
    result = summarise("biped", 1000, 1.0, [run])
    plain = json.loads(json.dumps(result.as_json(), allow_nan=False))
    keys = {"episodes", "falls", "mae", "commands", "slip_fraction", "chatter_fraction"}
    assert keys | {"max_dq_rpm", "power_W", "saturation", "stand", "runs"} <= set(plain)
    assert set(plain["mae"]) == {"vx", "vy", "wz"}
    assert plain["commands"]["forward"]["segments"] == 1
    assert plain["commands"]["left"] == {
        "target": None, "mean": None, "mae": None, "falls": 0, "segments": 0, "power_W": None,
        "height_error_m": None,
    }  # fmt: skip
    assert len(plain["torque_peak"]) == 20


def test_the_zero_peer_stays_where_it_is():
    run = track(Setup("crawl", 0, "zero"), segments=[FORWARD], hold_s=1.5)
    assert not run.fallen
    assert abs(run.segments[0].mean[0]) < 0.01
    assert run.error[0] == pytest.approx(0.15, abs=0.01)


def test_the_random_peer_falls():
    run = track(Setup("biped", 0, "random"), segments=[FORWARD, STAND], hold_s=2.0)
    assert run.fallen
    assert sum(s.fallen for s in run.segments) == 1 and run.segments[-1].fallen


def test_a_command_is_judged_over_all_its_segments():
    scores = [score(), score(mean=[0.2, 0, 0], mae=[0.04, 0, 0], power_W=30.0)]
    row = per_command([*scores, score(mean=None, mae=None, power_W=None, fallen=True)])
    assert row["mean"][0] == pytest.approx(0.19) and row["mae"][0] == pytest.approx(0.03)
    assert (row["falls"], row["segments"], row["power_W"]) == (1, 3, 25.0)
    assert "slip_fraction" not in row


def test_slip_is_a_share_of_the_whole_way():
    scores = [score(slid_m=0.01, distance_m=0.1), score(slid_m=0.02, distance_m=0.5)]
    assert slip_fraction(scores) == pytest.approx(0.05)
    assert slip_fraction([score(slid_m=0.01, distance_m=0.05)]) is None


def test_stillness_weighs_by_time():
    scores = [
        score(name="stand", still_s=1.0, joint_speed_rms=0.2, lifts=3),
        score(name="stand", still_s=3.0, joint_speed_rms=0.0),
    ]
    still = stillness(scores)
    assert still["joint_speed_rms"] == pytest.approx(0.1)  # sqrt((1 * 0.04 + 3 * 0) / 4)
    assert still["foot_lifts_per_s"] == pytest.approx(0.75)
    assert stillness([])["foot_lifts_per_s"] is None


def test_peaks_are_those_of_robots_that_did_not_fall(run):
    from dataclasses import replace

    wild = replace(run, fallen=True, max_dq_rpm=99.0, height_error_m=0.3)
    assert summarise("biped", 0, 1.0, [run, wild]).max_dq_rpm == run.max_dq_rpm
    assert summarise("biped", 0, 1.0, [wild]).max_dq_rpm == 99.0
    assert summarise("biped", 0, 1.0, [run, wild]).falls == 1
    assert summarise("biped", 0, 1.0, [run, wild]).height_error_p95_m == run.height_error_m


def test_nineteen_of_twenty_episodes_keep_nearer_to_the_height_than_the_worst(run):
    from dataclasses import replace

    runs = [replace(run, height_error_m=0.01 * k) for k in range(1, 22)]
    assert summarise("biped", 0, 1.0, runs).height_error_p95_m == pytest.approx(0.20)
    assert summarise("biped", 0, 1.0, runs).height_error_m == pytest.approx(0.21)


def test_the_height_of_a_command_is_its_worst_that_did_not_fall():
    scores = [score(height_error_m=0.01), score(height_error_m=0.02), score()]
    assert per_command(scores)["height_error_m"] == 0.02
    scores.append(score(height_error_m=0.3, fallen=True))
    assert per_command(scores)["height_error_m"] == 0.02
    assert per_command([score()])["height_error_m"] is None


def test_mistakes_are_refused_before_anything_runs():
    with pytest.raises(UnknownName, match="Did you mean 'crawl'"):
        tracking("crwl", seeds=1)
    for speed in (0.0, -1.0, np.nan):
        with pytest.raises(InvalidInput, match="speed factor > 0"):
            tracking("crawl", seeds=1, speed=speed)
