"""The environment: determinism at any thread count, mirror symmetry, randomisation, endings."""

from dataclasses import replace

import numpy as np
import pytest

from mobius.control.observation import mirror_frame, mirror_joints
from mobius.errors import UnknownName
from mobius.model import robot
from mobius.paper import TABLE_II
from mobius.train import rewards
from mobius.train.env import LocomotionEnv
from mobius.train.presets import WIDE, Randomisation, preset_of
from mobius.train.rewards import WEIGHTS

CFG = preset_of("crawl", "smoke").env
BIPED = preset_of("biped", "smoke").env
QUIET = replace(CFG, randomisation=Randomisation().off())


def rollout(cfg, *, nthread: int, n: int = 6, steps: int = 30) -> tuple[np.ndarray, np.ndarray]:
    env = LocomotionEnv(cfg, n, seed=5, nthread=nthread)
    rng = np.random.default_rng(1)
    out = [env.step(rng.normal(0, 0.6, (n, 14))) for _ in range(steps)]
    return np.stack([r.observation for r in out]), np.stack([r.reward for r in out])


def test_one_and_two_threads_agree_bit_for_bit():
    for a, b in zip(rollout(CFG, nthread=1), rollout(CFG, nthread=2), strict=True):
        np.testing.assert_array_equal(a, b)


def test_observations_are_finite_and_sized():
    observation, reward = rollout(CFG, nthread=2)
    env = LocomotionEnv(CFG, 2, nthread=1)
    assert observation.shape[-1] == env.layout.size
    assert np.isfinite(observation).all() and np.isfinite(reward).all()


@pytest.mark.parametrize("cfg", [CFG, BIPED], ids=["crawl", "biped"])
def test_mirrored_state_and_action_give_the_mirrored_next_state(cfg):
    # converged: four iterations of the solver end in different places on the two sides
    quiet = replace(cfg, randomisation=Randomisation().off(), iterations=20)
    env = LocomotionEnv(quiet, 2, seed=3, nthread=1)
    k = len(env.body.joints)
    index, sign = mirror_joints(env.body)
    perm, signs = mirror_frame(env.layout, env.body)
    state = MirroredState(env)
    state.copy_first_to_second()
    rng = np.random.default_rng(2)
    for _ in range(5):
        action = rng.normal(0, 0.7, k)
        env.step(np.stack([action, sign * action[index]]))
        assert np.abs(state.mirror_qpos(env.sim.qpos[0]) - env.sim.qpos[1]).max() < 1e-3
    assert np.abs(signs * env.observation[0][perm] - env.observation[1]).max() < 0.02
    perm, signs = env.mirror_privileged()
    assert sorted(perm) == list(range(env.privileged.shape[1]))
    assert np.abs(signs * env.privileged[0][perm] - env.privileged[1]).max() < 0.02


class MirroredState:
    """The left-right mirror of a whole simulator state."""

    def __init__(self, env: LocomotionEnv) -> None:
        self.env, m = env, env.sim.model
        self.names = [m.joint(i).name for i in range(m.njnt) if m.joint(i).name != "base"]

    @staticmethod
    def twin(name: str) -> tuple[str, float]:
        other = ("right" if name.startswith("left") else "left") + name[name.index("_") :]
        return other, -1.0 if name.endswith(("yaw", "roll")) else 1.0

    def mirror_qpos(self, q: np.ndarray) -> np.ndarray:
        m, out = self.env.sim.model, q.copy()
        out[:7] = q[:7] * [1, -1, 1, 1, -1, 1, -1]
        for name in self.names:
            other, sign = self.twin(name)
            out[m.joint(name).qposadr[0]] = sign * q[m.joint(other).qposadr[0]]
        return out

    def copy_first_to_second(self) -> None:
        env, m = self.env, self.env.sim.model
        q = env.sim.qpos[0].copy()
        q[3:7] = env.home[3:7]
        ctrl = np.tile(env.ctrl0, (2, 1))
        for i in range(m.nu):
            other, sign = self.twin(m.actuator(i).name)
            ctrl[1, i] = sign * ctrl[0, m.actuator(other).id]
        env.sim.place(np.arange(2), np.stack([q, self.mirror_qpos(q)]), np.zeros((2, m.nv)), ctrl)
        env.command[0] = [0.2, 0.1, 0.3]
        env.command[1] = env.command[0] * [1, -1, -1]
        env.command_left[:] = 1e9
        env.clock.phase[:] = [0.2, 0.7]
        env.history.reset()
        env.late[:] = False
        env.yaw0[:] = 0.0
        env.reset_observation()


def test_episodes_end_by_time_as_truncation():
    env = LocomotionEnv(replace(QUIET, episode_s=0.5), 3, nthread=1)
    ends = [env.step(np.zeros((3, 14))) for _ in range(30)]
    assert ends[-1].done.all() and ends[-1].time_out.all()
    assert not any(r.done.any() for r in ends[:-1])
    assert (env.steps == 0).all()


def test_episodes_end_by_a_fall_not_as_truncation():
    env = LocomotionEnv(QUIET, 2, nthread=1)
    env.sim.qpos[0, 2] = 0.05
    result = env.step(np.zeros((2, 14)))
    assert result.done.tolist() == [True, False]
    assert result.time_out.tolist() == [False, False]
    assert result.reward[0] < result.reward[1]


def test_delayed_frames_are_older_frames():
    """Alg. 1 with p = 1 and N_delay = 1: what is seen is the frame of the step before."""
    cfg = replace(QUIET, history=1, clock=False)
    cfg = replace(cfg, randomisation=replace(cfg.randomisation, delay_chance=1.0, delay_steps=1))
    late = LocomotionEnv(cfg, 1, seed=4, nthread=1)
    now = LocomotionEnv(replace(cfg, randomisation=Randomisation().off()), 1, seed=4, nthread=1)
    for env in (late, now):
        env.sim.place(
            np.arange(1), env.home[None], np.zeros((1, env.sim.model.nv)), env.ctrl0[None]
        )
        env.reset_observation()
    rng, previous = np.random.default_rng(0), None
    for _ in range(5):
        action = rng.normal(0, 0.5, (1, 14))
        seen, true = late.step(action).observation, now.step(action).observation
        if previous is not None:
            np.testing.assert_allclose(seen[:, :9], previous[:, :9], atol=1e-9)
        previous = true


def test_unknown_presets_are_named():
    with pytest.raises(UnknownName, match="Did you mean 'fast'"):
        preset_of("crawl", "fst")
    with pytest.raises(UnknownName, match="body"):
        preset_of("crwl", "fast")


def test_a_saved_environment_goes_on_bit_for_bit():
    for cfg in (preset_of("crawl", "fast-rough").env, BIPED):
        env = LocomotionEnv(replace(cfg, episode_s=1.0), 4, seed=5, nthread=1)
        actions = np.random.default_rng(1).normal(0, 0.6, (50, 4, len(env.body.joints)))
        for action in actions[:20]:
            env.step(action)
        other = LocomotionEnv(replace(cfg, episode_s=1.0), 4, seed=99, nthread=1)
        other.load_state(env.state())
        for action in actions[20:]:  # over the end of the episode
            a, b = env.step(action), other.step(action)
            np.testing.assert_array_equal(a.observation, b.observation)
            np.testing.assert_array_equal(a.privileged, b.privileged)
            np.testing.assert_array_equal(a.reward, b.reward)


def test_eq_4_ends_the_episode_of_a_motor_that_is_too_fast_and_can_be_off():
    for limit, falls in ((5.236, True), (0.0, False)):
        env = LocomotionEnv(replace(QUIET, max_joint_speed=limit), 2, nthread=1)
        for _ in range(6):
            assert not env.step(np.zeros((2, 14))).done.any()
        env.sim.qvel[0, env.sim.at.dof[0]] = 40.0
        assert env.step(np.zeros((2, 14))).done.tolist() == [falls, False]


def test_eq_5_ends_the_episode_of_a_target_at_a_joint_limit_and_can_be_off():
    for margin, falls in ((0.02, True), (0.0, False)):
        env = LocomotionEnv(replace(QUIET, limit_margin=margin), 2, nthread=1)
        env.filter.low = env.filter.low.copy()
        env.filter.low[0] = env.default[0] - 0.05
        action = np.zeros((2, 14))
        action[0, 0] = -0.5  # 0.3 * 0.5 / 3 = 0.05 rad towards the limit
        assert env.step(action).done.tolist() == [falls, False]


def test_rewards_below_zero_count_as_zero_where_the_paper_preset_says_so():
    fast = LocomotionEnv(replace(QUIET, weights={"alive": -5.0}), 2, nthread=1)
    clipped = LocomotionEnv(replace(QUIET, weights={"alive": -5.0}, clip_reward=True), 2, nthread=1)
    assert (fast.step(np.zeros((2, 14))).reward < 0).all()
    assert (clipped.step(np.zeros((2, 14))).reward == 0).all()


@pytest.mark.parametrize(("body", "size", "actions"), [("biped", 416, 8), ("crawl", 608, 14)])
def test_the_paper_presets_see_and_do_as_many_numbers_as_printed(body, size, actions):
    env = LocomotionEnv(preset_of(body, "paper").env, 2, nthread=1)
    assert env.observation.shape == (2, size)
    assert env.layout.actions == actions
    assert np.isfinite(env.step(np.zeros((2, actions))).observation).all()


def test_the_paper_presets_have_table_ii_and_nothing_else():
    for body in ("biped", "crawl"):
        cfg = preset_of(body, "paper").env
        on = {k for k, v in {**WEIGHTS, **cfg.weights}.items() if v}
        assert on == set(TABLE_II.terms)


def test_welding_what_a_policy_does_not_move_hardly_changes_how_the_robot_stands():
    for body in ("biped", "crawl"):
        cfg = replace(preset_of(body, "smoke").env, randomisation=Randomisation().off())
        heights = []
        for weld in (True, False):
            env = LocomotionEnv(replace(cfg, weld=weld), 1, seed=0, nthread=1)
            for _ in range(60):
                env.step(np.zeros((1, len(env.body.joints))))
            heights.append(env.height[0])
        assert abs(heights[0] - heights[1]) < 0.01


def test_robots_start_on_tiles_of_their_level_with_the_feet_on_the_ground():
    cfg = replace(preset_of("crawl", "fast-rough").env, randomisation=Randomisation().off())
    env = LocomotionEnv(cfg, 60, seed=0, nthread=1)
    env.curriculum.level[:] = np.arange(60) % 6
    env._reset(np.arange(60))
    tile = cfg.terrain.tile
    assert (env.sim.qpos[:, 1] // tile == env.curriculum.level).all()
    for _ in range(20):
        result = env.step(np.zeros((60, 14)))
        assert not result.done.any()
    assert (env.sim.contact.sum(axis=1) >= 3).mean() > 0.8
    assert np.abs(env.height - env.height0).max() < 0.09


def test_a_policy_may_have_a_stance_of_its_own_and_learns_to_come_to_it():
    """Three quarters of the episodes begin in it, one in the keyframe; targets begin in it."""
    env = LocomotionEnv(preset_of("crawl", "fast").env, 8, seed=0, nthread=1)
    start = env.pool[0][:, env._q_at]
    there, here = robot.keyframe_joints("crawl")[0][env.body.index], WIDE.joints()[env.body.index]
    near = np.abs(start - here).max(axis=1) < np.abs(start - there).max(axis=1)
    np.testing.assert_array_equal(near, np.arange(8) % 4 > 0)
    assert np.abs(env.default - here).max() < 0.1 < np.abs(env.default - there).max()
    np.testing.assert_array_equal(env.target, np.tile(env.default, (8, 1)))


def test_the_lift_of_a_configuration_is_what_swings_are_measured_against(monkeypatch):
    tops, total = [], rewards.total

    def watched(signals, weights):
        tops.append(signals.swing_top)
        return total(signals, weights)

    monkeypatch.setattr(rewards, "total", watched)
    for lift in (0.02, None):
        env = LocomotionEnv(replace(CFG, lift=lift), 1, nthread=1)
        env.step(np.zeros((1, len(env.body.joints))))
    assert tops == [0.02, env.body.gait.height]
