"""An actor that cannot prefer a side: pi(M o) = M pi(o) exactly.

The network answers the observation and its mirror image, and the two answers are averaged:
``pi(o) = (f(o) + M f(M o)) / 2``. The robot is symmetric, so is the best policy; halving what
there is to learn saves samples, and no yaw bias can creep in.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from rsl_rl.models import MLPModel
from tensordict import TensorDict
from torch import nn

from mobius.control.bodies import body_of
from mobius.control.observation import Layout, mirror_frame, mirror_joints


class SymmetricActor(MLPModel):
    """rsl_rl's MLP actor made equivariant under the left-right mirror.

    ``configure`` must be called before construction: rsl_rl builds actors from plain names.
    """

    layout: Layout
    body: str

    @classmethod
    def configure(cls, layout: Layout, body: str) -> type[SymmetricActor]:
        """A subclass for one observation layout and body."""
        return type("SymmetricActor", (cls,), {"layout": layout, "body": body})

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        body = body_of(self.body)
        for name, (index, sign) in (
            ("obs", mirror_frame(self.layout, body)),
            ("act", mirror_joints(body)),
        ):
            self.register_buffer(f"{name}_index", torch.from_numpy(index), persistent=False)
            self.register_buffer(
                f"{name}_sign", torch.from_numpy(sign.astype(np.float32)), persistent=False
            )

    def mean_of(self, raw: torch.Tensor) -> torch.Tensor:
        """Mean action (n, k) of raw observations (n, size)."""
        mirrored = raw[:, self.obs_index] * self.obs_sign
        both = self.mlp(self.obs_normalizer(torch.cat([raw, mirrored])))
        straight, reflected = both.chunk(2)
        return 0.5 * (straight + reflected[:, self.act_index] * self.act_sign)

    def forward(
        self,
        obs: TensorDict,
        masks: torch.Tensor | None = None,
        hidden_state: Any = None,
        stochastic_output: bool = False,
    ) -> torch.Tensor:
        """As :meth:`MLPModel.forward`, with the symmetric mean."""
        mean = self.mean_of(torch.cat([obs[group] for group in self.obs_groups], dim=-1))
        if self.distribution is None:
            return mean
        if stochastic_output:
            self.distribution.update(mean)
            return self.distribution.sample()
        return self.distribution.deterministic_output(mean)


class ExportedActor(nn.Module):
    """Observation (n, size) to mean action (n, k), for ONNX."""

    def __init__(self, actor: SymmetricActor) -> None:
        super().__init__()
        self.actor = actor

    def forward(self, obs: torch.Tensor) -> torch.Tensor:
        """Deterministic action."""
        return self.actor.mean_of(obs)
