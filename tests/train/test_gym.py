"""Gymnasium's own checker, the vector contract, and what the adapter must not change."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")

from gymnasium.utils.env_checker import check_env  # noqa: E402
from gymnasium.vector import AutoresetMode  # noqa: E402

from mobius.control.action import ACTION_CLIP  # noqa: E402
from mobius.train.gym import (  # noqa: E402
    EpisodicEnv,
    RobotEnv,
    RobotVectorEnv,
    observation_limit,
    register,
)
from mobius.train.presets import Randomisation, preset_of  # noqa: E402

SHORT = replace(preset_of("crawl", "smoke").env, episode_s=0.1)
QUIET = replace(SHORT, randomisation=Randomisation().off())


@pytest.mark.parametrize("name", ["Biped", "Crawl"])
def test_check_env_passes_without_a_warning(name):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env = gymnasium.make(f"mobius.train.gym:mobius/{name}-v0")
        check_env(env.unwrapped)


def test_registering_twice_is_silent():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        register()
    assert {"mobius/Biped-v0", "mobius/Crawl-v0"} <= set(gymnasium.registry)


@pytest.mark.parametrize("preset", ["fast", "paper", "fast-rough"])
@pytest.mark.parametrize("body", ["crawl", "biped"])
def test_limits_are_as_wide_as_the_observation_and_not_reached(body, preset):
    env = EpisodicEnv(preset_of(body, preset).env, 4, nthread=1)
    limit = observation_limit(env.layout)
    assert limit.shape == (env.layout.size,)
    rng = np.random.default_rng(0)
    for _ in range(20):
        seen = env.step(rng.uniform(-1, 1, (4, env.layout.actions))).observation
        assert (np.abs(seen) <= limit * (1 + 1e-6)).all()


def test_an_episode_ends_with_what_was_last_seen_not_with_the_next_start():
    env = RobotEnv("crawl", cfg=QUIET)
    env.reset(seed=0)
    for i in range(6):
        action = np.full(14, 0.5, np.float32)
        observation, _, fallen, late, _ = env.step(action)
        assert (fallen, late) == (False, i == 5)
    k = 14
    last_action = observation[9 + k : 9 + 2 * k]  # part of the newest frame; a start has zeros
    np.testing.assert_allclose(last_action, ACTION_CLIP * 0.5)
    start, _ = env.reset()
    np.testing.assert_array_equal(start[9 + k : 9 + 2 * k], 0.0)


def test_a_fall_is_termination_not_truncation():
    env = RobotEnv("crawl", cfg=replace(QUIET, episode_s=20.0))
    env.reset(seed=0)
    env._env.sim.qpos[0, 2] = 0.05
    _, _, fallen, late, _ = env.step(np.zeros(14, np.float32))
    assert (fallen, late) == (True, False)


def test_a_command_can_be_held():
    env = RobotEnv("crawl", cfg=replace(QUIET, command_s=(0.01, 0.02)))
    observation, info = env.reset(seed=0, options={"command": (0.3, 0.0, -0.2)})
    for _ in range(4):
        np.testing.assert_allclose(info["command"], [0.3, 0.0, -0.2])
        observation, *_, info = env.step(np.zeros(14, np.float32))
    np.testing.assert_allclose(observation[37:40], [0.3, 0.0, -0.2], rtol=1e-6)


def test_the_vector_env_resets_in_the_same_step():
    envs = gymnasium.make_vec(
        "mobius.train.gym:mobius/Crawl-v0",
        num_envs=3,
        vectorization_mode="vector_entry_point",
        cfg=QUIET,
        nthread=1,
    )
    assert isinstance(envs, RobotVectorEnv)
    assert envs.metadata["autoreset_mode"] is AutoresetMode.SAME_STEP
    observation, _ = envs.reset(seed=5)
    assert observation in envs.observation_space
    action = np.full(envs.action_space.shape, 0.25, np.float32)
    for i in range(6):
        observation, reward, fallen, late, info = envs.step(action)
        assert observation in envs.observation_space and reward.shape == (3,)
        assert ("final_obs" in info) == (i == 5)
    assert late.all() and not fallen.any() and info["_final_obs"].all()
    newest = slice(9 + 14, 9 + 28)
    for last, first in zip(info["final_obs"], observation, strict=True):
        assert last in envs.single_observation_space
        np.testing.assert_allclose(last[newest], ACTION_CLIP * 0.25)
        np.testing.assert_array_equal(first[newest], 0.0)


def test_the_vector_env_repeats_itself_for_a_seed():
    def roll(nthread: int) -> np.ndarray:
        envs = RobotVectorEnv(4, "crawl", cfg=SHORT, nthread=nthread)
        out = [envs.reset(seed=3)[0]]
        envs.action_space.seed(1)
        out += [envs.step(envs.action_space.sample())[0] for _ in range(9)]
        return np.stack(out)

    np.testing.assert_array_equal(roll(1), roll(2))


def test_looking_at_an_end_leaves_the_other_robots_alone():
    """Without noise the robots that go on see the same whether or not others end."""
    alone, crowd = (EpisodicEnv(replace(QUIET, episode_s=20.0), 2, nthread=1) for _ in range(2))
    for env in (alone, crowd):
        env.begin(np.random.default_rng(0))
        env.hold((0.2, 0.0, 0.0))
    crowd.steps[1] = crowd.max_steps - 3
    rng = np.random.default_rng(1)
    for _ in range(6):
        action = rng.normal(0, 0.5, (2, 14))
        a, b = alone.step(action).observation, crowd.step(action).observation
        np.testing.assert_array_equal(a[0], b[0])
    assert (crowd.steps < 6).any()
