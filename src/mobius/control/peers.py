"""Who can drive a body: a policy file, a shipped policy, or one of two peers it must beat.

``flat`` and ``rough`` are the policies that come with the package.

``zero`` always acts 0, which is the servo targets of the stance; ``random`` acts N(0, 1).
Both go through the filter of Eq. (2) and the joint limits like a policy's actions.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from mobius.control.action import ActionFilter
from mobius.control.bodies import body_of
from mobius.control.policy import PolicyController, load_policy, shipped_policy
from mobius.errors import PolicyError, UnknownName
from mobius.model.build import joint_ranges
from mobius.model.robot import keyframe_joints
from mobius.types import JointCommand, ModeCommand, SensorFrame, StateEstimate

SHIPPED = ("flat", "rough")
"""Names of the shipped policies of each body."""
PEERS: dict[str, float] = {"zero": 0.0, "random": 1.0}
"""Spread of the actions of each peer."""


class PeerController:
    """Acts without looking."""

    def __init__(self, body: str, *, spread: float, seed: int = 0) -> None:
        """Args: body by name; ``spread`` of the raw actions; seed of their draw."""
        chosen = body_of(body)
        self._index, self._spread, self._seed = chosen.index, spread, seed
        self._hold = keyframe_joints(chosen.keyframe)[1]
        ranges = joint_ranges()
        low, high = np.array([ranges[j] for j in chosen.joints]).T
        self._filter = ActionFilter(self._hold[self._index], low, high)
        self.reset()

    def reset(self) -> None:
        """Start anew, with the same draw."""
        self._filter.reset()
        self._rng = np.random.default_rng([self._seed, 91])

    def act(self, command: ModeCommand, belief: StateEstimate, frame: SensorFrame) -> JointCommand:
        """Servo targets of all 22 joints for one policy step."""
        q = self._hold.copy()
        action = self._spread * self._rng.standard_normal((1, len(self._index)))
        q[self._index] = self._filter.push(action)[0]
        return JointCommand(q=q, stamp=frame.stamp)


def controller_of(
    policy: Path | str | None, body: str, *, seed: int = 0
) -> PolicyController | PeerController:
    """The controller that ``policy`` names.

    Args:
        policy: An ONNX file, ``flat``, ``rough``, ``zero`` or ``random``; None is ``flat``.
        body: ``crawl`` or ``biped``.
        seed: Of the random peer.

    Raises:
        PolicyError: The file lacks, is no policy, or drives another body.
        UnknownName: Neither such a name nor the name of an ONNX file.
    """
    chosen = body_of(body)
    if policy is None or str(policy) in SHIPPED:
        rough = str(policy) == "rough"
        return PolicyController(load_policy(shipped_policy(body, rough=rough)))
    if str(policy) in PEERS:
        return PeerController(body, spread=PEERS[str(policy)], seed=seed)
    path = Path(policy)
    if not path.suffix and not path.exists():
        raise UnknownName("policy", str(policy), (*SHIPPED, *PEERS, "FILE.onnx"))
    loaded = load_policy(path)
    if loaded.body is not chosen:
        other: Any = loaded.metadata["body"]
        raise PolicyError(
            f"{path}: drives the body '{other}', not '{body}'; type that body instead"
        )
    return PolicyController(loaded)
