"""The clock that follows the feet, and a student that learns what it is shown."""

from dataclasses import replace

import numpy as np
import pytest

from mobius.control.clock import Gait, GaitClock
from mobius.control.policy import load_policy, shipped_policy
from mobius.train.distill import Distiller, follow_feet
from mobius.train.env import LocomotionEnv
from mobius.train.presets import preset_of

GAIT = Gait(period=0.64, offsets=(0.0, 0.5), swing=(0.08, 0.42), height=0.03)


def test_a_touchdown_pulls_the_phase_half_way_to_where_that_foot_lands():
    clock = GaitClock(GAIT, 4)
    clock.phase[:] = [0.40, 0.98, 0.30, 0.30]
    clock.moving[:] = [True, True, True, False]
    follow_feet(clock, np.array([[1, 0], [0, 1], [0, 0], [1, 0]]))
    # the left foot lands at 0.42, the right, half a stride ahead, when the clock is at 0.92
    np.testing.assert_allclose(clock.phase, [0.41, 0.95, 0.30, 0.30])


def test_the_pull_goes_the_short_way_round():
    clock = GaitClock(replace(GAIT, swing=(0.5, 1.0)), 1)
    clock.phase[:], clock.moving[:] = 0.9, True
    follow_feet(clock, np.array([[1, 0]]))
    assert clock.phase[0] == pytest.approx(0.95)


def test_the_student_sees_the_paper_s_numbers_and_learns_what_it_is_shown():
    env = LocomotionEnv(preset_of("biped", "smoke").env, 16, seed=0, nthread=1)
    d = Distiller(env, load_policy(shipped_policy("biped")))
    assert d.observe().shape == (16, 416)
    d.history.reset()
    figures = d.collect(12, share=1.0)
    assert np.isfinite(list(figures.values())).all()
    first = d.learn(1, 64, 240)
    for _ in range(20):
        last = d.learn(1, 64, 240)
    assert last < 0.5 * first
