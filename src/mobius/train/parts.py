"""A network evaluated in parts of its batch, each part on one thread.

torch shares a sum among its threads, so its rounding, and with it every weight, would depend
on their number; and it wakes them for every small operation. Here a batch is cut into a
fixed number of parts, torch itself keeps to one thread, and the gradients of the parts are
added in their order. How many threads work on the parts changes no bit.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, TypeVar

import torch
from torch import nn

T = TypeVar("T")
PARTS = 2
"""Of a batch; what is learned depends on this number, so it is the same everywhere."""


class Workers:
    """The calling thread and others."""

    def __init__(self, threads: int = 1) -> None:
        """Args: threads >= 1, this one included."""
        self._pool = ThreadPoolExecutor(threads - 1) if threads > 1 else None

    def map(self, work: Callable[[int], T], parts: int) -> list[T]:
        """``work`` of 0 to ``parts`` - 1; this thread does the first itself."""
        if self._pool is None:
            return [work(i) for i in range(parts)]
        others = [self._pool.submit(work, i) for i in range(1, parts)]
        return [work(0), *(other.result() for other in others)]

    def begin(self, work: Callable[[], T]) -> Callable[[], T]:
        """Start ``work`` beside what follows; call what is returned for its result."""
        if self._pool is None:
            result = work()
            return lambda: result
        future: Future[T] = self._pool.submit(work)
        return future.result


def in_parts(
    workers: Workers, module: nn.Module, *inputs: torch.Tensor
) -> tuple[torch.Tensor, ...]:
    """``module(*inputs)``, a tuple of tensors (n, ...), differentiable in its parameters only.

    Args:
        workers: Who does the parts.
        module: Takes tensors (n, ...), gives one or a tuple; rows do not depend on one another.
        inputs: (n, ...) each; no gradients flow to them.
    """
    out: tuple[torch.Tensor, ...] = _InParts.apply(workers, module, inputs, *module.parameters())
    return out


def _slices(n: int) -> list[slice]:
    edges = [n * i // PARTS for i in range(PARTS + 1)]
    return [slice(a, b) for a, b in itertools.pairwise(edges)]


class _InParts(torch.autograd.Function):
    @staticmethod
    def forward(
        ctx: Any,
        workers: Workers,
        module: nn.Module,
        inputs: Sequence[torch.Tensor],
        *parameters: torch.Tensor,
    ) -> tuple[torch.Tensor, ...]:
        slices = _slices(len(inputs[0]))

        def forward(i: int) -> tuple[torch.Tensor, ...]:
            with torch.enable_grad():
                out = module(*(x[slices[i]] for x in inputs))
            return out if isinstance(out, tuple) else (out,)

        ctx.outputs = workers.map(forward, PARTS)
        ctx.workers, ctx.slices, ctx.parameters = workers, slices, parameters
        columns = zip(*ctx.outputs, strict=True)
        return tuple(torch.cat([part.detach() for part in column]) for column in columns)

    @staticmethod
    def backward(ctx: Any, *gradients: torch.Tensor) -> tuple[Any, ...]:
        def backward(i: int) -> tuple[torch.Tensor, ...]:
            here = [g[ctx.slices[i]] for g in gradients]
            return torch.autograd.grad(ctx.outputs[i], ctx.parameters, here)

        total, *rest = ctx.workers.map(backward, PARTS)
        for part in rest:
            for sum_, more in zip(total, part, strict=True):
                sum_.add_(more)
        return (None, None, None, *total)
