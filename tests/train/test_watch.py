"""What is not finite is found in the step in which it arises, in the robot where it arises."""

from dataclasses import replace

import numpy as np
import pytest

from mobius.train.presets import preset_of
from mobius.train.watch import NotFinite, WatchedEnv

CFG = preset_of("crawl", "smoke").env


@pytest.fixture
def env(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # MuJoCo writes a log where it stands
    return WatchedEnv(CFG, 4, seed=1, nthread=1)


def actions(env) -> np.ndarray:
    return np.zeros((env.n, env.layout.actions))


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_poisoned_action_names_its_robot(env, value):
    action = actions(env)
    action[2, 3] = value
    with pytest.raises(NotFinite, match="action of robot 2") as caught:
        env.step(action)
    assert caught.value.robots.tolist() == [2] and caught.value.what == "action"


def test_a_simulation_that_blows_up_is_no_fall(env):
    """MuJoCo alone would reset the robot and go on."""
    env.sim.qvel[1, 3] = 1e12
    with pytest.raises(NotFinite, match="physics of robot 1"):
        env.step(actions(env))


def test_where_a_few_may_blow_up_it_is_a_fall(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    env = WatchedEnv(replace(CFG, blow_ups=0.25), 4, seed=1, nthread=1)
    env.sim.qvel[1, 3] = 1e12
    result = env.step(actions(env))
    assert result.done.tolist() == [False, True, False, False]
    assert np.isfinite(result.observation).all() and np.isfinite(result.reward).all()
    env.sim.qvel[:2, 3] = 1e12
    with pytest.raises(NotFinite, match="physics of robot 0, 1"):
        env.step(actions(env))


def test_a_model_that_is_not_finite_is_found(env):
    env.sim.fields["mass"][3, 1] = np.nan
    with pytest.raises(NotFinite, match="of robot 3"):
        env.step(actions(env))


def test_the_step_can_be_done_again_from_before_it(env):
    rng = np.random.default_rng(0)
    for _ in range(3):
        env.step(rng.normal(0, 0.5, actions(env).shape))
    env.mark()
    for _ in range(4):
        env.step(rng.normal(0, 0.5, actions(env).shape))
    now = env.state()
    poisoned = actions(env)
    poisoned[0] = np.nan
    with pytest.raises(NotFinite):
        env.step(poisoned)
    state, action = env.before()
    np.testing.assert_array_equal(action, poisoned)
    np.testing.assert_array_equal(state["sim"]["state"], now["sim"]["state"])
    np.testing.assert_array_equal(state["robots"]["observation"], now["robots"]["observation"])
    assert state["rng"] == now["rng"]


def test_watching_changes_nothing(env):
    from mobius.train.env import LocomotionEnv

    plain = LocomotionEnv(CFG, 4, seed=1, nthread=1)
    env.mark()
    for _ in range(5):
        a, b = env.step(actions(env)), plain.step(actions(env))
        np.testing.assert_array_equal(a.observation, b.observation)
