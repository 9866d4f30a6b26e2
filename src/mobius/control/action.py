"""Eq. (2): from raw policy actions to servo targets."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mobius import paper

Array = NDArray[np.float64]

POLICY_DT = 1 / 60
"""Period of the policy [s] (Sec. V-A)."""
ACTION_SCALE = paper.TABLE_I.action_scale
"""a_scale [rad] (Table I)."""
FILTER_LENGTH = 3
"""n_actions; the paper prints none. 50 ms at 60 Hz, the newest action included."""
ACTION_CLIP = 4.0
"""Raw actions beyond this are clipped: no target further than 1.2 rad from the default."""


class ActionFilter:
    """Theta_action = Theta_default + a_scale * mean of the last n_actions actions."""

    def __init__(
        self,
        default: Array,
        low: Array,
        high: Array,
        n: int = 1,
        *,
        scale: float = ACTION_SCALE,
        length: int = FILTER_LENGTH,
    ) -> None:
        """Args: default, low, high (k,) [rad]; n robots; scale [rad]; length [actions]."""
        self.default, self.low, self.high, self.scale = default, low, high, scale
        self.past = np.zeros((n, length, len(default)))
        """(n, length, k) the last raw actions, newest first."""
        self.free = np.tile(default, (n, 1))
        """(n, k) the newest targets before they are clipped to the joint limits [rad]."""

    def reset(self, which: NDArray[np.bool_] | slice = slice(None)) -> None:
        """Forget the actions of these robots."""
        self.past[which] = 0.0

    @property
    def last(self) -> Array:
        """(n, k) newest raw action, clipped."""
        return self.past[:, 0]

    def push(self, action: Array) -> Array:
        """Servo targets (n, k) [rad] inside the joint limits for raw actions (n, k)."""
        self.past[:, 1:] = self.past[:, :-1].copy()
        self.past[:, 0] = np.clip(action, -ACTION_CLIP, ACTION_CLIP)
        self.free = self.default + self.scale * self.past.mean(axis=1)
        return np.clip(self.free, self.low, self.high)
