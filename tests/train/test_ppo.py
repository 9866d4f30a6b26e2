"""The leaner update learns what rsl_rl's learns."""

import contextlib
import io
from dataclasses import replace

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from rsl_rl.algorithms import PPO  # noqa: E402
from rsl_rl.models import MLPModel  # noqa: E402

from mobius.control.observation import mirror_frame, mirror_joints  # noqa: E402
from mobius.train.env import LocomotionEnv  # noqa: E402
from mobius.train.equivariant import Equivariant  # noqa: E402
from mobius.train.ppo import build_learner, build_mirrors  # noqa: E402
from mobius.train.presets import preset_of  # noqa: E402
from mobius.train.snapshot import policy_hash  # noqa: E402
from mobius.train.vec import RslVecEnv  # noqa: E402

FAST = replace(preset_of("crawl", "smoke"), num_envs=16, epochs=3)
PLAIN = replace(FAST, symmetric=False, privileged=False, activation="swish")


@pytest.fixture(scope="module")
def vec():
    return RslVecEnv(LocomotionEnv(FAST.env, FAST.num_envs, nthread=1))


def rsl_learner(preset, vec) -> PPO:
    """What rsl_rl makes of the preset by itself."""
    cfg = preset.runner(actor_class="MLPModel")
    if preset.symmetric:
        for name, mirrors in build_mirrors(preset, vec.env).items():
            cfg[name]["class_name"] = Equivariant.configure(*mirrors)
    cfg["multi_gpu"] = None
    with contextlib.redirect_stdout(io.StringIO()):
        return PPO.construct_algorithm(vec.get_observations(), vec, cfg, "cpu")


def one_update(learner, vec) -> dict[str, float]:
    """A rollout of noise, the same every time, and an update."""
    torch.manual_seed(1)
    n, size = vec.num_envs, vec.env.layout.size
    shape = {k: v.shape for k, v in vec.get_observations().items()}
    assert shape["policy"] == (n, size)
    with torch.inference_mode():
        for _ in range(FAST.horizon):
            obs = vec.get_observations()
            for key in obs.keys():  # noqa: SIM118
                obs[key] = torch.randn(shape[key])
            learner.act(obs)
            learner.process_env_step(obs, torch.randn(n), torch.rand(n) < 0.05, {})
        learner.compute_returns(obs)
    return learner.update()


@pytest.mark.parametrize("preset", [FAST, PLAIN], ids=["equivariant", "plain"])
def test_one_and_two_threads_end_bit_for_bit_the_same(preset, vec):
    ends = []
    for threads in (1, 2):
        torch.manual_seed(0)
        learner = build_learner(preset, vec, threads)
        one_update(learner, vec)
        ends.append(policy_hash(learner))
    assert ends[0] == ends[1] and torch.get_num_threads() == 1


@pytest.mark.parametrize("preset", [FAST, PLAIN], ids=["equivariant", "plain"])
def test_an_update_ends_where_rsl_rl_s_ends(preset, vec):
    torch.manual_seed(0)
    plain = rsl_learner(preset, vec)
    torch.manual_seed(0)
    lean = build_learner(preset, vec)
    before = [p.detach().clone() for p in lean.actor.parameters()]
    a, b = one_update(plain, vec), one_update(lean, vec)
    assert a == pytest.approx(b, rel=1e-4, abs=1e-6)
    for model in ("actor", "critic"):
        ours, theirs = getattr(lean, model).state_dict(), getattr(plain, model).state_dict()
        assert ours.keys() == theirs.keys()
        for key in ours:
            torch.testing.assert_close(ours[key], theirs[key], rtol=1e-3, atol=2e-5)
    moved = [
        float((p.detach() - q).abs().max())
        for p, q in zip(lean.actor.parameters(), before, strict=True)
    ]
    assert min(moved) > 1e-4  # the update did something, well above the tolerance
    assert lean.learning_rate == plain.learning_rate


def test_the_actor_is_equivariant(vec):
    torch.manual_seed(0)
    actor = build_learner(FAST, vec).get_policy()
    obs = torch.randn(8, vec.env.layout.size)
    perm, signs = mirror_frame(vec.env.layout, vec.env.body)
    index, sign = mirror_joints(vec.env.body)
    with torch.no_grad():
        straight = actor.mean_of(obs)
        mirrored = actor.mean_of(obs[:, perm] * torch.tensor(signs, dtype=torch.float32))
    want = straight[:, index] * torch.tensor(sign, dtype=torch.float32)
    torch.testing.assert_close(mirrored, want, atol=1e-6, rtol=1e-5)


def test_the_critic_does_not_care_for_sides(vec):
    torch.manual_seed(0)
    critic = build_learner(FAST, vec).critic
    obs = vec.get_observations()
    mirrors = {
        "policy": mirror_frame(vec.env.layout, vec.env.body),
        "privileged": vec.env.mirror_privileged(),
    }
    other = obs.clone()
    for name, (index, sign) in mirrors.items():
        other[name] = obs[name][:, index] * torch.tensor(sign, dtype=torch.float32)
    with torch.no_grad():
        straight, mirrored = critic(obs), critic(other)
    torch.testing.assert_close(mirrored, straight, atol=1e-6, rtol=1e-5)
    assert straight.std() > 0


def test_building_a_learner_prints_nothing(vec, capsys):
    learner = build_learner(FAST, vec)
    assert isinstance(learner.critic, MLPModel)
    assert capsys.readouterr().out == ""
    assert np.isfinite([float(p.detach().sum()) for p in learner.actor.parameters()]).all()
