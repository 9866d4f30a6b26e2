"""Networks, distribution and rollout storage of rsl_rl that do less for the same result."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import torch
from rsl_rl.algorithms import PPO
from rsl_rl.models import MLPModel
from rsl_rl.modules import EmpiricalNormalization
from rsl_rl.modules.distribution import GaussianDistribution
from rsl_rl.storage import RolloutStorage
from tensordict import TensorDict
from torch import nn

from mobius.train.equivariant import Equivariant
from mobius.train.parts import Workers, in_parts

_HALF_LOG_2PI = 0.5 * math.log(2 * math.pi)


class _Lean(MLPModel):
    """What both networks have."""

    workers = Workers()

    def __init__(self, obs: TensorDict, obs_groups: Any, obs_set: str, *a: Any, **k: Any) -> None:
        super().__init__(obs, obs_groups, obs_set, *a, **k)
        self.ready, self.mirrored = f"{obs_set} ready", f"{obs_set} mirrored"

    def update_normalization(self, obs: TensorDict) -> None:
        """Take in observations (n, ...), in training."""
        if self.training and self.obs_normalization:
            learn_moments(self.obs_normalizer, torch.cat([obs[g] for g in self.obs_groups], dim=-1))


class LeanModel(_Lean):
    """rsl_rl's MLP that accepts inputs which are normalised already."""

    def prepare(self, obs: TensorDict) -> dict[str, torch.Tensor]:
        """The network's input (n, size) for observations (n, ...)."""
        return {self.ready: self.get_latent(obs)}

    def forward(
        self,
        obs: TensorDict,
        masks: torch.Tensor | None = None,
        hidden_state: Any = None,
        stochastic_output: bool = False,
    ) -> torch.Tensor:
        """As :meth:`MLPModel.forward`; of prepared inputs the mean, never a sample."""
        if self.ready not in obs.keys():  # noqa: SIM118
            return super().forward(obs, masks, hidden_state, stochastic_output)
        (out,) = in_parts(self.workers, self.mlp, obs[self.ready])
        if self.distribution is not None:
            self.distribution.update(out)
        return out


class LeanEquivariant(Equivariant, _Lean):
    """The equivariant network that accepts inputs which are normalised and mirrored already."""

    def prepare(self, obs: TensorDict) -> dict[str, torch.Tensor]:
        """The network's two inputs (n, size) for observations (n, ...)."""
        raw = torch.cat([obs[group] for group in self.obs_groups], dim=-1)
        straight, mirrored = self.inputs_of(raw)
        return {self.ready: straight, self.mirrored: mirrored}

    def forward(
        self,
        obs: TensorDict,
        masks: torch.Tensor | None = None,
        hidden_state: Any = None,
        stochastic_output: bool = False,
    ) -> torch.Tensor:
        """As :meth:`Equivariant.forward`; of prepared inputs the mean, never a sample."""
        if self.ready not in obs.keys():  # noqa: SIM118
            return super().forward(obs, masks, hidden_state, stochastic_output)
        inputs = obs[self.ready], obs[self.mirrored]
        mean = self.join(*in_parts(self.workers, self.mlp, *inputs))
        if self.distribution is not None:
            self.distribution.update(mean)
        return mean


class LeanStorage(RolloutStorage):
    """A rollout whose mini-batches are gathered and prepared once for all epochs."""

    def __init__(self, learner: PPO, *args: Any) -> None:
        super().__init__("rl", *args)
        self._models = (learner.actor, learner.critic)

    def mini_batch_generator(
        self, num_mini_batches: int, num_epochs: int = 8
    ) -> Iterator[RolloutStorage.Batch]:
        """As in rsl_rl: one permutation, cut into mini-batches, visited ``num_epochs`` times."""
        size = self.num_envs * self.num_transitions_per_env // num_mini_batches
        order = torch.randperm(num_mini_batches * size)

        def flat(x: torch.Tensor) -> torch.Tensor:
            return x.flatten(0, 1).index_select(0, order)

        assert self.distribution_params is not None, "update() before any step"
        shuffled = TensorDict(
            {k: flat(v) for k, v in self.observations.items()}, batch_size=[len(order)]
        )
        inputs: dict[str, torch.Tensor] = {}
        with torch.no_grad():
            for model in self._models:
                inputs.update(model.prepare(shuffled))
        ready = TensorDict(inputs, batch_size=[len(order)])
        actions, values = flat(self.actions), flat(self.values)
        advantages, returns = flat(self.advantages), flat(self.returns)
        log_prob = flat(self.actions_log_prob)
        params = [flat(p) for p in self.distribution_params]
        batches = [
            RolloutStorage.Batch(
                observations=ready[s],
                actions=actions[s],
                values=values[s],
                advantages=advantages[s],
                returns=returns[s],
                old_actions_log_prob=log_prob[s],
                old_distribution_params=tuple(p[s] for p in params),
            )
            for s in (slice(i * size, (i + 1) * size) for i in range(num_mini_batches))
        ]
        for _ in range(num_epochs):
            yield from batches


class LeanGaussian(GaussianDistribution):
    """rsl_rl's Gaussian with one standard deviation for all rows, computed as one row."""

    def update(self, mlp_output: torch.Tensor) -> None:
        """Take new means (n, k)."""
        self._mean = mlp_output
        self._log_std = self.log_std_param.clamp(*self.log_std_range)

    def sample(self) -> torch.Tensor:
        """(n, k), no gradient."""
        with torch.no_grad():
            return torch.normal(self._mean, self._log_std.exp().expand_as(self._mean))

    @property
    def mean(self) -> torch.Tensor:
        """(n, k)."""
        return self._mean

    @property
    def std(self) -> torch.Tensor:
        """(n, k)."""
        return self._log_std.exp().expand_as(self._mean)

    @property
    def entropy(self) -> torch.Tensor:
        """(n,)."""
        one = (self._log_std + 0.5 + _HALF_LOG_2PI).sum()
        return one.expand(len(self._mean))

    def log_prob(self, outputs: torch.Tensor) -> torch.Tensor:
        """(n,) of actions (n, k)."""
        off = (outputs - self._mean) * torch.exp(-self._log_std)
        return -0.5 * (off * off).sum(-1) - (self._log_std + _HALF_LOG_2PI).sum()

    def kl_divergence(
        self, old_params: tuple[torch.Tensor, ...], new_params: tuple[torch.Tensor, ...]
    ) -> torch.Tensor:
        """(n,) KL(old || new); the standard deviations have equal rows."""
        (old, old_std), (new, new_std) = old_params, new_params
        ratio = (old_std[:1] / new_std[:1]) ** 2
        off = (old - new) / new_std[:1]
        return 0.5 * ((off * off).sum(-1) + (ratio - 1 - ratio.log()).sum())


class _Elu(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, x: torch.Tensor) -> torch.Tensor:
        y = x.clamp(max=0).exp_().sub_(1)
        torch.maximum(x, y, out=y)
        ctx.save_for_backward(y)
        return y

    @staticmethod
    def backward(ctx: Any, *grad: torch.Tensor) -> torch.Tensor:
        (y,) = ctx.saved_tensors
        return torch.ops.aten.elu_backward(grad[0], 1.0, 1.0, 1.0, True, y)


class LeanElu(nn.Module):
    """ELU, within 1e-7 of torch's, in two thirds of its time."""

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """max(x, exp(x) - 1)."""
        return nn.functional.elu(x) if torch.jit.is_tracing() else _Elu.apply(x)


def use_lean_elu(model: nn.Module) -> None:
    """Replace every ELU in ``model``."""
    for module in list(model.modules()):
        for name, child in list(module._modules.items()):  # named_children() shows twins once
            if isinstance(child, nn.ELU):
                setattr(module, name, LeanElu())


def learn_moments(normaliser: EmpiricalNormalization, x: torch.Tensor) -> None:
    """Mean and variance of all rows so far and of the new rows (n, size).

    As :meth:`EmpiricalNormalization.update`, with the variance from two plain passes: torch's
    own takes ten times as long.
    """
    mean = x.mean(0, keepdim=True)
    variance = (x - mean).square_().mean(0, keepdim=True)
    normaliser.count += len(x)
    share = len(x) / normaliser.count
    step = mean - normaliser._mean
    normaliser._mean += share * step
    between = step * (mean - normaliser._mean)
    normaliser._var += share * (variance + between - normaliser._var)
    normaliser._std = normaliser._var.sqrt()
