"""Contacts between policy steps: seen and counted, and a physics that looking does not change."""

from dataclasses import replace

import numpy as np
import pytest

from mobius.control.action import POLICY_DT
from mobius.train.env import LocomotionEnv
from mobius.train.presets import Randomisation, preset_of

BLIND = preset_of("crawl", "smoke").env
WATCHING = replace(BLIND, watch_contacts=True)


def test_looking_at_every_physics_step_changes_no_bit_of_the_motion():
    rng = np.random.default_rng(0)
    actions = rng.normal(0.0, 1.0, (40, 4, 14))
    a, b = (LocomotionEnv(cfg, 4, seed=2, nthread=1) for cfg in (BLIND, WATCHING))
    for action in actions:
        np.testing.assert_array_equal(
            a.step(action).observation[:, :38], b.step(action).observation[:, :38]
        )
        np.testing.assert_array_equal(a.sim.qpos, b.sim.qpos)


def contacts(*touch: list[int], air: float = 0.0, down: float = 0.0):
    """One robot whose first foot touches as told at three looks a policy step."""
    env = LocomotionEnv(replace(WATCHING, randomisation=Randomisation().off()), 1, nthread=1)
    env.air[:], env.down[:] = air, down
    out = []
    for looks in touch:
        env.touch = np.repeat(np.array(looks, dtype=float)[:, None, None], 4, axis=2)
        out.append([float(x[0, 0]) for x in env._contacts()])
    return env, out


def test_a_touch_between_two_policy_steps_is_a_short_contact():
    env, [(now, began, early, aloft)] = contacts([0, 1, 0], air=0.2)
    assert (now, began, early) == (0, 1, 1)
    assert env.air[0, 0] == pytest.approx(POLICY_DT / 3)
    assert aloft == pytest.approx(0.2 + 2 / 3 * POLICY_DT)


def test_a_step_is_a_long_contact():
    _, out = contacts([1, 1, 1], [1, 1, 1], [0, 0, 0], [0, 0, 1], down=0.2)
    assert [early for _, _, early, _ in out] == [0, 0, 0, 0]
    assert [began for _, began, _, _ in out] == [0, 0, 0, 1]
    assert out[-1][3] == pytest.approx(2 * POLICY_DT)


def test_two_touches_in_a_row_are_two():
    _, [(_, _, early, _)] = contacts([1, 0, 1], down=0.05)
    assert early == 1
    _, out = contacts([1, 0, 1], [0, 0, 0], down=0.05)
    assert [early for _, _, early, _ in out] == [1, 1]
