"""Trials of motions: what is asked, what is judged, and that a bad motion does not pass."""

import json
from dataclasses import replace

import numpy as np
import pytest

from mobius.errors import InvalidInput, UnknownName
from mobius.evaluate.trial_report import TrialRun, as_text, figures_of, gear_lives, summarise
from mobius.evaluate.trial_source import Asks
from mobius.evaluate.trial_watch import Gathering, PushUpCounter
from mobius.evaluate.trials import TRIALS, motion_trials, needed, run_trial
from mobius.geometry import rpy_to_quat
from mobius.model.robot import keyframe_joints
from mobius.modes.motions import Motion, Stage
from mobius.types import Mode, StateEstimate

PRONE, CRAWL = keyframe_joints("prone")[0], keyframe_joints("crawl")[1]


def lazy(name="prone_to_crawl"):
    """A motion that only holds still."""
    return {name: Motion(name, "prone", "crawling", (Stage(PRONE, 0.2),))}


def belief(t, yaw=0.0):
    zero = np.zeros(3)
    return StateEstimate(t, zero, rpy_to_quat(0, 0, yaw), zero, zero, np.ones(4))


def run_of(seed, success, **more):
    peak = [2.0 + seed] * 20
    base = dict(why="" if success else "fell", seconds=4.0 + seed, energy_J=1.0)
    return TrialRun(
        "roll", seed, success, peak_Nm=peak, rms_Nm=[1.0] * 20, position_error_m=0.1,
        yaw_error_deg=1.0, **{**base, **more},
    )  # fmt: skip


def test_the_trials_are_those_of_the_bars():
    assert tuple(TRIALS) == (
        "prone_to_crawl", "stand_to_crawl", "crawl_to_stand", "supine_recovery", "head_recovery",
        "any_fall", "roll", "five_rolls", "push_ups", "gather_stand", "gather_roll",
    )  # fmt: skip
    limits = {t.name: t.limit_s for t in TRIALS.values()}
    assert limits["prone_to_crawl"] == limits["stand_to_crawl"] == limits["crawl_to_stand"] == 6.0
    assert limits["supine_recovery"] == limits["head_recovery"] == 10.0
    assert limits["any_fall"] == 15.0
    assert needed(TRIALS["stand_to_crawl"]) == {"crawl_to_stand", "stand_to_crawl"}


def test_a_motion_that_does_nothing_does_not_pass(monkeypatch):
    short = replace(TRIALS["prone_to_crawl"], limit_s=1.0)
    monkeypatch.setitem(TRIALS, "prone_to_crawl", short)
    run = run_trial(("prone_to_crawl", 0), motions=lazy())
    assert not run.success and run.seconds is None
    assert run.why == "not there after 1 s, but prone in recover"
    assert max(run.peak_Nm) > 0.1


def test_push_ups_are_counted_by_the_trunk():
    counter = PushUpCounter()
    t = np.arange(0.0, 10.0, 0.01)
    for h in 0.28 + 0.03 * np.cos(2 * np.pi * t):  # 6 cm, once a second
        counter.see(float(h))
    assert counter.count in (9, 10)
    small = PushUpCounter()
    for h in 0.28 + 0.02 * np.cos(2 * np.pi * t):
        small.see(float(h))
    assert small.count == 0


def test_the_source_stands_asks_turns_back_between_rolls_and_is_over():
    asks = Asks(Mode.ROLL, Mode.CRAWL, first=Mode.CRAWL, times=2)
    assert asks(belief(0.5)).mode is Mode.CRAWL
    assert asks(belief(1.5)).mode is Mode.ROLL
    asks.entered(Mode.ROLL, Mode.CRAWL, 2.0)
    asks.entered(Mode.CRAWL, Mode.ROLL, 4.0)
    turning = asks(belief(4.1, yaw=0.3))
    assert turning.mode is Mode.CRAWL and turning.twist_H[2] < -0.3
    assert asks(belief(5.0, yaw=0.01)).mode is Mode.ROLL
    assert asks(belief(9.0, yaw=0.3)).mode is Mode.ROLL  # it does not turn for ever
    asks.entered(Mode.CRAWL, Mode.ROLL, 10.0)
    assert asks.over and asks(belief(10.1)).mode is Mode.CRAWL


def test_figures_take_times_from_successes_and_torques_from_all():
    rolled = dict(speed_mps=0.7, average_mps=0.2, heading_error_deg=3.0)
    runs = [run_of(0, True, **rolled), run_of(1, True, **rolled), run_of(2, False)]
    f = figures_of(runs)
    assert (f["trials"], f["successes"], f["median_s"]) == (3, 2, 4.5)
    assert f["peak_torque_Nm"] == 4.0 and f["joints"]["left_hip_yaw"]["rms_Nm"] == 1.0
    assert (f["speed_mps"], f["heading_error_deg"]) == pytest.approx((0.7, 3.0))
    assert f["failures"] == {"2": "fell"}
    result = summarise(runs, seeds=3, seed=0)
    json.dumps(result.as_json(), allow_nan=False)
    assert "speed_mps 0.70" in as_text(result)


def test_figures_of_gathering_are_of_the_runs_that_gathered():
    seen = dict(gather_lean_deg=3.0, gather_slid_m=0.02, gather_force_N=90.0)
    more = dict(gather_lean_deg=5.0, gather_slid_m=0.01, gather_force_N=80.0)
    runs = [run_of(0, True, gathers=(1, 1), **seen), run_of(1, False, gathers=(2, 1), **more)]
    g = figures_of([*runs, run_of(2, True)])["gathers"]
    assert (g["begun"], g["done"]) == (3, 2)
    assert g["lean_deg"] == {"median": 4.0, "most": 5.0}
    assert g["force_N"]["most"] == 90.0 and g["slid_m"]["median"] == pytest.approx(0.015)
    text = as_text(summarise(runs, seeds=2, seed=0))
    assert "gathered 2 of 3  lean_deg 4.0 (most 5.0)  slid_m 0.015 (most 0.020)" in text
    assert "gathers" not in figures_of([run_of(2, True)])


def test_a_gathering_counts_slides_of_pressing_feet_anew_each_time():
    gathering, level = Gathering(), np.array([0.0, 0.0, 1.0])
    tilted = np.array([np.sin(0.1), 0.0, np.cos(0.1)])
    for normal in (level, tilted):  # foot 0 slides at 0.3 m/s for 0.5 s, twice
        gathering.begin()
        for _ in range(150):
            gathering.see(normal, np.array([50.0, 0.5, 20, 20]), np.array([0.3, 9.0, 0, 0]))
    assert gathering.begun == 2 and gathering.force == 50.0
    assert gathering.slid == pytest.approx(0.15)  # not 0.30, and not the foot in the air
    assert gathering.lean == pytest.approx(0.1)


def test_gears_last_less_at_more_torque_and_two_servos_share():
    peak = np.full(20, 2.5)
    lives = gear_lives(peak)
    assert len(lives) == 8
    again = gear_lives(2 * peak)
    assert all(again[j] < lives[j] for j in lives)
    # 2.5 N m on each of two gears of an arm: the printed life
    assert again["left_shoulder_motor_a"] == pytest.approx(7150, rel=0.3)


@pytest.mark.parametrize(
    ("names", "seeds", "error", "message"),
    [
        (["rool"], 1, UnknownName, "unknown motion trial 'rool'. Did you mean 'roll'"),
        (["roll"], 1, InvalidInput, "trial 'roll' needs the motion 'roll', which is not there"),
        (["prone_to_crawl"], 0, InvalidInput, "expected a whole number >= 1, got 0"),
    ],
)
def test_a_mistake_shows_before_the_work_begins(names, seeds, error, message):
    with pytest.raises(error, match=message):
        motion_trials(names, seeds=seeds, motions=lazy())
