"""What a spine grasp on a bar can hold: an ellipsoid, drawn anew at each grasp (Table IX).

Axes of a grasp: x along the groove (the bar), y the pinch normal, from finger to finger,
z across the groove. A horizontal bar carries a hanging robot across its groove.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

import numpy as np

from mobius import paper
from mobius.errors import InvalidInput

TORSION_LEVER = 0.044
"""Torsion about the pinch normal that a grasp holds, over its force across the groove [m].

[D] a lower bound: Fig. 15b shows 5 N m about the gripper's normal held while the hand carries
half the weight, (50/124.2)^2 + (5/M)^2 <= 1, hence M >= 5.5 N m = 0.044 m * 124.2 N. The paper
prints no torsion limit."""
LEAST = 0.1
"""No draw falls below this share of its mean; a Gaussian would, once in 10^4 draws."""


@dataclass(frozen=True)
class LimitSurface:
    """(f_across / F_across)^2 + (f_along / F_along)^2 + (m / M)^2 <= 1."""

    F_across: float = paper.TABLE_IX["z"].mean
    """Greatest force across the groove [N]."""
    F_along: float = paper.TABLE_IX["x"].mean
    """Greatest force along the groove [N]."""
    M: float = TORSION_LEVER * paper.TABLE_IX["z"].mean
    """Greatest torsion about the pinch normal [N m]."""

    def __post_init__(self) -> None:
        if not all(np.isfinite(v) and v > 0 for v in (self.F_across, self.F_along, self.M)):
            raise InvalidInput(
                "LimitSurface: expected three positive numbers F_across [N], F_along [N], M [N m],"
                f" got {self.F_across}, {self.F_along}, {self.M}"
            )

    @classmethod
    def draw(cls, rng: np.random.Generator) -> LimitSurface:
        """One grasp's surface: two independent Gaussians of Table IX; M goes with F_across."""
        z, x = paper.TABLE_IX["z"], paper.TABLE_IX["x"]
        across, along = (max(float(rng.normal(d.mean, d.std)), LEAST * d.mean) for d in (z, x))
        return cls(across, along, TORSION_LEVER * across)

    def load(self, across: float, along: float, torsion: float = 0.0) -> float:
        """How far a load [N, N, N m] goes towards the surface: < 1 inside, 1 on it."""
        a, b, c = across / self.F_across, along / self.F_along, torsion / self.M
        return sqrt(a * a + b * b + c * c)

    def holds(self, across: float, along: float = 0.0, torsion: float = 0.0) -> bool:
        """Whether the grasp holds this load at rest."""
        return self.load(across, along, torsion) <= 1.0
