"""Networks that cannot prefer a side, by their structure: pi(M o) = M pi(o), V(M o) = V(o).

Hidden units come in pairs that the mirror swaps. A linear map that commutes with a swap is
one matrix on the sums and another on the differences of the pairs, so a layer of k pairs
costs half of a plain layer of 2 k units, and a quarter of running a plain network on the
observation and on its mirror image. The robot is symmetric, so the best policy and its
value are; half of what there is to learn is gone, and no yaw bias can creep in.
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from rsl_rl.models import MLPModel
from rsl_rl.utils import resolve_nn_activation
from tensordict import TensorDict
from torch import nn

_ROOT_HALF = 0.5**0.5


class PairLinear(nn.Module):
    """Linear map of pairs (n, k), (n, k) that commutes with swapping them."""

    def __init__(self, inputs: int, outputs: int) -> None:
        super().__init__()
        self.even = nn.Linear(inputs, outputs)
        self.odd = nn.Linear(inputs, outputs, bias=False)

    def forward(self, a: torch.Tensor, b: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """The pair's image."""
        # the orthonormal sum and difference are (a +- b) / sqrt(2); both factors are put on the
        # weights, which are smaller than the batch
        even = nn.functional.linear(a + b, 0.5 * self.even.weight, _ROOT_HALF * self.even.bias)
        odd = nn.functional.linear(a - b, 0.5 * self.odd.weight)
        return even + odd, even - odd


class PairMLP(nn.Module):
    """From an observation and its mirror image to an action that mirrors with them."""

    def __init__(self, inputs: int, hidden: list[int], outputs: int, activation: str) -> None:
        super().__init__()
        pairs = [h // 2 for h in hidden]
        self.lift = nn.Linear(inputs, pairs[0])
        self.layers = nn.ModuleList(PairLinear(m, n) for m, n in itertools.pairwise(pairs))
        self.head = nn.Linear(pairs[-1], outputs)
        self.act = resolve_nn_activation(activation)

    def forward(self, x: torch.Tensor, mirrored: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """The head's answers (n, k) for both; the second is still to be mirrored."""
        a, b = self.act(self.lift(x)), self.act(self.lift(mirrored))
        for layer in self.layers:
            a, b = layer(a, b)
            a, b = self.act(a), self.act(b)
        return self.head(a), self.head(b)


Mirror = tuple[NDArray[np.int64], NDArray[np.float64]]
"""Permutation and signs of a vector: ``mirrored = sign * x[index]``."""


class Equivariant(MLPModel):
    """rsl_rl's MLP with a :class:`PairMLP` inside: an actor whose mean action mirrors with the
    observation, a critic whose value does not change.

    ``configure`` must be called before construction: rsl_rl builds models from plain names.
    """

    mirrors: tuple[Mirror, Mirror]

    @classmethod
    def configure(cls, observation: Mirror, output: Mirror) -> type[Equivariant]:
        """A subclass for one observation and output."""
        return type(cls.__name__, (cls,), {"mirrors": (observation, output)})

    def __init__(self, *args: Any, hidden_dims: list[int], activation: str, **kwargs: Any) -> None:
        super().__init__(*args, hidden_dims=hidden_dims, activation=activation, **kwargs)
        outputs = len(self.mirrors[1][0])
        self.mlp = PairMLP(self.obs_dim, hidden_dims, outputs, activation)
        for name, (index, sign) in zip(("obs", "out"), self.mirrors, strict=True):
            self.register_buffer(f"{name}_index", torch.from_numpy(index), persistent=False)
            self.register_buffer(
                f"{name}_sign", torch.from_numpy(sign.astype(np.float32)), persistent=False
            )

    def inputs_of(self, raw: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Normalised observations (n, size) and their normalised mirror images."""
        mirrored = raw.index_select(1, self.obs_index) * self.obs_sign
        return self.obs_normalizer(raw), self.obs_normalizer(mirrored)

    def join(self, ours: torch.Tensor, theirs: torch.Tensor) -> torch.Tensor:
        """Mean output (n, k) of the network's two answers."""
        return 0.5 * (ours + theirs.index_select(1, self.out_index) * self.out_sign)

    def mean_of(self, raw: torch.Tensor) -> torch.Tensor:
        """Mean output (n, k) of raw observations (n, size)."""
        return self.join(*self.mlp(*self.inputs_of(raw)))

    def forward(
        self,
        obs: TensorDict,
        masks: torch.Tensor | None = None,
        hidden_state: Any = None,
        stochastic_output: bool = False,
    ) -> torch.Tensor:
        """As :meth:`MLPModel.forward`, with the equivariant mean."""
        mean = self.mean_of(torch.cat([obs[group] for group in self.obs_groups], dim=-1))
        if self.distribution is None:
            return mean
        if stochastic_output:
            self.distribution.update(mean)
            return self.distribution.sample()
        return self.distribution.deterministic_output(mean)
