"""An episode: what counts and when, and that commands reach the robot in time."""

import numpy as np
import pytest

from mobius.evaluate.commands import Segment
from mobius.evaluate.episode import Episode, Setup, drive


def build_episode(readings, true, want, *, hold_s=4.0, fallen=False) -> Episode:
    """An episode of 60 Hz rows (n, 3) with as many segments as fit."""
    n = len(true)
    count = max(1, round(n / 60 / hold_s))
    rows = {"t": np.arange(n) / 60, "true_twist_H": true, "cmd_twist_H": want}
    segments = [Segment("forward", tuple(want[0]))] * count
    return Episode(segments, hold_s, fallen, rows, readings(np.ones((2, 2))), 0.0)


STRIDE = 38 / 60
"""The window in whole samples [s]."""


def test_means_over_a_stride_take_the_sway_out_of_the_error(readings):
    t = np.arange(480) / 60
    want = np.tile([0.2, 0.0, 0.0], (480, 1))
    true = want + 0.05 * np.sin(2 * np.pi * t / STRIDE)[:, None] * [0.0, 1.0, 0.0]
    true[:, 0] += 0.01
    episode = build_episode(readings, true, want)
    assert episode.error() == pytest.approx([0.01, 0.0, 0.0], abs=1e-12)
    assert episode.raw_error()[1] == pytest.approx(0.05 * 2 / np.pi, rel=0.01)


def test_the_first_second_after_a_command_does_not_count(readings):
    want = np.repeat([[0.2, 0.0, 0.0], [-0.2, 0.0, 0.0]], 240, axis=0)
    true = want.copy()
    late = np.arange(480) % 240 < 40
    true[late] = 9.0
    episode = build_episode(readings, true, want)
    assert episode.error() == pytest.approx(np.zeros(3), abs=1e-12)
    assert not episode.counted()[late].any()


def test_a_robot_that_fell_at_once_is_not_let_off(readings):
    want = np.tile([0.2, 0.0, 0.0], (20, 1))
    episode = build_episode(readings, np.zeros((20, 3)), want, fallen=True)
    assert episode.error()[0] > 0.15
    assert episode.fell_in == 0


def test_a_fall_belongs_to_the_command_during_which_it_happened(readings):
    want = np.tile([0.2, 0.0, 0.0], (360, 1))
    episode = build_episode(readings, want, want, hold_s=2.0, fallen=True)
    assert len(episode.segments) == 3 and episode.fell_in == 2  # 359 / 60 = 5.98 s
    episode.rows["t"] = episode.rows["t"][:230]
    assert episode.fell_in == 1  # 229 / 60 = 3.82 s
    episode.fallen = False
    assert episode.fell_in is None


def test_commands_follow_the_schedule_and_the_seed_repeats_to_the_last_bit():
    segments = [Segment("stand", (0.0, 0.0, 0.0)), Segment("forward", (0.1, 0.0, 0.0))]
    runs = [drive(Setup("biped", 3, "zero"), segments, hold_s=0.5) for _ in range(2)]
    commanded = runs[0].rows["cmd_twist_H"][:, 0]
    assert (commanded[:30] == 0.0).all() and (commanded[30:] == 0.1).all()
    assert len(runs[0].readings.tick) == 300
    np.testing.assert_array_equal(runs[0].rows["true_p"], runs[1].rows["true_p"])
    np.testing.assert_array_equal(runs[0].readings.force, runs[1].readings.force)


def test_the_way_over_the_floor_leaves_the_sway_out(readings):
    n = 5 * 38 + 1
    p = np.zeros((n, 3))
    p[:, 0] = np.linspace(0.0, 0.3, n)
    p[:, 1] = 0.02 * np.sin(2 * np.pi * np.arange(n) / 38)
    episode = build_episode(readings, np.zeros((n, 3)), np.zeros((n, 3)))
    episode.rows["true_p"] = p
    assert episode.distance() == pytest.approx(0.3)
