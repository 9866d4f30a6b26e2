"""What the pull-up's controller asks of a script; any script that answers so may lead it."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

__all__ = ["Goal", "Script"]

Array = NDArray[np.float64]


class Goal(Protocol):
    """What a script wishes at one moment (:class:`mobius.modes.pullup.PullUpGoal`)."""

    @property
    def phase(self) -> str:
        """Its name."""

    @property
    def x_B(self) -> float:
        """Bar towards the head [m]."""

    @property
    def z_B(self) -> float:
        """Bar towards the back [m]."""

    @property
    def lean(self) -> float:
        """Of the trunk, back [rad]."""

    @property
    def along(self) -> float:
        """Inner force along the bar [N]."""

    @property
    def moments(self) -> Array:
        """(3,) bar ahead of the centre of mass [m]; torsion, own axis [N m]."""

    @property
    def legs(self) -> float:
        """0 hanging, 1 drawn up."""

    @property
    def grip(self) -> bool:
        """Whether the hands hold on."""


class Script(Protocol):
    """Where the goals come from (:class:`mobius.modes.pullup.PullUpScript`)."""

    reason: str

    def reset(self) -> None:
        """Start anew."""

    def step(self, now: float) -> Goal:
        """The goal at a time [s]."""

    def abort(self, reason: str) -> None:
        """Go down and let go."""
