"""What a learner consists of, as trees of arrays: to store it, to go on from it, to hash it."""

from __future__ import annotations

import hashlib
import random
from typing import Any

import numpy as np
import torch
from rsl_rl.algorithms import PPO
from torch import nn

from mobius.errors import InvalidInput

Tree = dict[str, Any]


def seed_everything(seed: int) -> None:
    """rsl_rl seeds nothing itself."""
    random.seed(seed)
    np.random.seed(seed)  # noqa: NPY002  rsl_rl may use the global generator
    torch.manual_seed(seed)


def random_state() -> Tree:
    """States of the random generators of Python, numpy (the global one) and torch."""
    version, words, gauss = random.getstate()
    return {
        "python": {"version": version, "words": list(words), "gauss": gauss},
        "numpy": np.random.get_state(legacy=False),  # noqa: NPY002
        "torch": torch.get_rng_state().numpy().copy(),
    }


def load_random_state(state: Tree) -> None:
    """Go on from :func:`random_state`."""
    python = state["python"]
    random.setstate((python["version"], tuple(python["words"]), python["gauss"]))
    np.random.set_state(state["numpy"])  # noqa: NPY002
    torch.set_rng_state(torch.from_numpy(state["torch"]))


def learner_state(learner: PPO) -> Tree:
    """Networks with their normalisers, Adam's moments and step counts, learning rate."""
    moments = learner.optimizer.state_dict()["state"]
    return {
        "actor": _arrays(learner.actor),
        "critic": _arrays(learner.critic),
        "optimiser": {
            str(i): {k: v.numpy().copy() for k, v in entry.items()} for i, entry in moments.items()
        },
        "learning_rate": float(learner.learning_rate),
    }


def load_learner(learner: PPO, state: Tree) -> None:
    """Go on from :func:`learner_state`."""
    load_networks(learner, state)
    full = learner.optimizer.state_dict()
    full["state"] = {
        int(i): {k: torch.from_numpy(np.array(v)) for k, v in entry.items()}
        for i, entry in state["optimiser"].items()
    }
    learner.optimizer.load_state_dict(full)
    learner.learning_rate = state["learning_rate"]
    for group in learner.optimizer.param_groups:
        group["lr"] = learner.learning_rate


def load_networks(learner: PPO, state: Tree) -> None:
    """Take over actor and critic with their normalisers, nothing else.

    Raises:
        InvalidInput: the networks in ``state`` have other shapes.
    """
    for name in ("actor", "critic"):
        model: nn.Module = getattr(learner, name)
        have, come = model.state_dict(), state[name]
        other = sorted(
            k
            for k in have.keys() | come.keys()
            if k not in have or k not in come or tuple(have[k].shape) != come[k].shape
        )
        if other:
            raise InvalidInput(
                f"the {name} does not fit: {other[0]} and {len(other) - 1} more differ in shape;"
                " it must have been trained with the same body, observation and networks"
            )
        model.load_state_dict({k: torch.from_numpy(np.array(v)) for k, v in come.items()})


def policy_hash(learner: PPO) -> str:
    """SHA-256 over names and bits of actor and critic, normalisers included."""
    digest = hashlib.sha256()
    for model in (learner.actor, learner.critic):
        for name, value in sorted(_arrays(model).items()):
            digest.update(name.encode() + value.tobytes())
    return digest.hexdigest()


def finite_learner(learner: PPO) -> bool:
    """Whether all weights are finite numbers."""
    parameters = [*learner.actor.parameters(), *learner.critic.parameters()]
    return all(bool(torch.isfinite(p).all()) for p in parameters)


def _arrays(model: nn.Module) -> dict[str, np.ndarray[Any, Any]]:
    return {k: v.detach().numpy().copy() for k, v in model.state_dict().items()}
