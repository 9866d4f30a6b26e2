"""The environment: determinism at any thread count, mirror symmetry, randomisation, endings."""

from dataclasses import replace

import numpy as np
import pytest

from mobius.control.observation import mirror_frame, mirror_joints
from mobius.errors import UnknownName
from mobius.train.env import LocomotionEnv
from mobius.train.presets import Randomisation, preset_of

CFG = preset_of("crawl", "smoke").env
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


def test_mirrored_state_and_action_give_the_mirrored_next_state():
    env = LocomotionEnv(QUIET, 2, seed=3, nthread=1)
    env.sim.model.opt.iterations  # noqa: B018  the solver's few iterations bound the agreement
    index, sign = mirror_joints(env.body)
    perm, signs = mirror_frame(env.layout, env.body)
    state = MirroredState(env)
    state.copy_first_to_second()
    rng = np.random.default_rng(2)
    for _ in range(5):
        action = rng.normal(0, 0.7, 14)
        env.step(np.stack([action, sign * action[index]]))
        assert np.abs(state.mirror_qpos(env.sim.qpos[0]) - env.sim.qpos[1]).max() < 1e-3
    assert np.abs(signs * env.observation[0][perm] - env.observation[1]).max() < 0.02


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
        q[3:7] = [1, 0, 0, 0]
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


def test_randomisation_reaches_the_physics():
    env = LocomotionEnv(CFG, 64, seed=0, nthread=1)
    r = env.randomiser
    trunk = env.sim.model.body("base_link").id
    for drawn in (
        env.sim.mass[:, trunk],
        env.sim.friction[:, r._soles[0], 0],
        env.sim.gain[:, 3, 0],
    ):
        assert np.std(drawn) > 0
    np.testing.assert_allclose(env.sim.bias[:, :, 1], -env.sim.gain[:, :, 0])  # tied (row 23)
    low, high = env.cfg.randomisation.friction
    assert env.sim.friction[:, r._soles[0], 0].min() >= 0.8 + low
    assert env.sim.friction[:, r._soles[0], 0].max() <= 0.8 + high


def test_kicks_come_at_intervals_and_have_a_size():
    cfg = replace(CFG, randomisation=replace(Randomisation().off(), kick_velocity=0.3))
    env = LocomotionEnv(cfg, 200, seed=0, nthread=1)
    changed = 0
    for _ in range(60):
        before = env.sim.qvel[:, :2].copy()
        env.randomiser.kick(1 / 60)
        step = np.linalg.norm(env.sim.qvel[:, :2] - before, axis=1)
        assert step.max() <= 0.3 + 1e-9
        changed += int((step > 0).sum())
    assert changed == 0  # the shortest interval is 1 s
    for _ in range(200):
        before = env.sim.qvel[:, :2].copy()
        env.randomiser.kick(1 / 60)
        changed += int((np.abs(env.sim.qvel[:, :2] - before).max(axis=1) > 0).sum())
    assert 200 < changed < 800  # each of 200 robots once every 1 to 4 s in 3.3 s


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
