"""rsl_rl's PPO with less work in an update; what it learns is the same.

- rsl_rl visits the same mini-batches in every epoch, and normalisers change only after the
  last. So mini-batches are gathered, normalised and mirrored once, not once an epoch.
- Networks run in two parts of the batch, on two threads if there are two; torch itself keeps
  to one (:mod:`mobius.train.parts`). In a rollout the critic works beside the environment.
- Nothing is sampled where only the distribution is wanted.
- One Adam kernel for all weights; cheaper ELU, Gaussian and moments (:mod:`mobius.train.lean`).
"""

from __future__ import annotations

import contextlib
import io

import numpy as np
import torch
from rsl_rl.algorithms import PPO
from tensordict import TensorDict

from mobius.control.observation import join_mirrors, mirror_frame, mirror_joints
from mobius.train.env import LocomotionEnv
from mobius.train.equivariant import Mirror
from mobius.train.lean import LeanEquivariant, LeanGaussian, LeanModel, LeanStorage, use_lean_elu
from mobius.train.parts import Workers
from mobius.train.presets import Preset
from mobius.train.vec import RslVecEnv


def build_learner(preset: Preset, vec: RslVecEnv, threads: int = 1) -> PPO:
    """PPO for the preset; seeds nothing.

    Args:
        preset: Networks and algorithm.
        vec: What it will learn in.
        threads: Threads of the learner; the result does not depend on it. torch's own number
            of threads is set to 1.
    """
    torch.set_num_threads(1)
    cfg = preset.runner(actor_class="MLPModel")
    cfg["algorithm"]["class_name"] = LeanPPO
    for name, mirrors in build_mirrors(preset, vec.env).items():
        own = LeanEquivariant.configure(*mirrors) if preset.symmetric else LeanModel
        cfg[name]["class_name"] = own
    cfg["actor"]["distribution_cfg"]["class_name"] = LeanGaussian
    cfg["multi_gpu"] = None
    obs = vec.get_observations()
    with contextlib.redirect_stdout(io.StringIO()):  # it prints the networks
        learner = PPO.construct_algorithm(obs, vec, cfg, "cpu")
    learner.workers = workers = Workers(threads)
    for model in (learner.actor, learner.critic):
        use_lean_elu(model)
        model.workers = workers
    learner.storage = LeanStorage(
        learner, vec.num_envs, preset.horizon, obs, [vec.num_actions], learner.device
    )
    (group,) = learner.optimizer.param_groups
    learner.optimizer = torch.optim.Adam(group["params"], lr=group["lr"], fused=True)
    return learner


def build_mirrors(preset: Preset, env: LocomotionEnv) -> dict[str, tuple[Mirror, Mirror]]:
    """Mirror of what actor and critic see, and of what they say."""
    seen, actions = mirror_frame(env.layout, env.body), mirror_joints(env.body)
    value = np.zeros(1, dtype=np.int64), np.ones(1)
    all_seen = join_mirrors(seen, env.mirror_privileged()) if preset.privileged else seen
    return {"actor": (seen, actions), "critic": (all_seen, value)}


class LeanPPO(PPO):
    """PPO whose critic works while the environment steps."""

    workers = Workers()

    def act(self, obs: TensorDict) -> torch.Tensor:
        """Sampled actions (n, k) of observations."""
        now = self.transition
        self._values = self.workers.begin(lambda: self._value(obs))
        now.observations, now.hidden_states = obs, (None, None)
        now.actions = actions = self.actor(obs, stochastic_output=True)
        now.actions_log_prob = self.actor.get_output_log_prob(actions)
        now.distribution_params = self.actor.output_distribution_params
        return actions

    def process_env_step(
        self,
        obs: TensorDict,
        rewards: torch.Tensor,
        dones: torch.Tensor,
        extras: dict[str, torch.Tensor],
    ) -> None:
        """Store what :meth:`act` and the environment gave."""
        self.transition.values = self._values()
        super().process_env_step(obs, rewards, dones, extras)

    def _value(self, obs: TensorDict) -> torch.Tensor:
        with torch.inference_mode():
            return self.critic(obs)
