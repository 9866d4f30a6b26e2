"""What a mission's plan pays for: steps, and seconds and joules where they have a price."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from mobius.errors import InvalidInput
from mobius.plan import DEFAULT_WEIGHTS, Travel, Weights, read_costs
from mobius.types import Mode


@dataclass(frozen=True)
class Prices:
    """Points for seconds and joules, and how many of them a metre and a change take."""

    per_s: float = 0.0
    """Points per second, >= 0."""
    per_J: float = 0.0
    """Points per joule, >= 0."""
    travel: Travel = DEFAULT_WEIGHTS.travel
    """Seconds and joules per metre and mode, and per change of mode."""

    def weights(self) -> Weights:
        """Of a mission: the goal must be reached, so cells seen earn nothing."""
        return Weights(W_exp=0.0, per_s=self.per_s, per_J=self.per_J, travel=self.travel)

    def switch_cost(self) -> Mapping[tuple[Mode, Mode], float] | None:
        """Points of each change of mode; None where none has a price."""
        points = self.travel.switch_points(per_s=self.per_s, per_J=self.per_J)
        return points if any(points.values()) else None


NO_PRICES = Prices()
"""Only steps cost."""


def read_prices(costs: str | Path | None, *, per_s: float = 0.0, per_J: float = 0.0) -> Prices:
    """Prices with the costs of a file (:func:`mobius.plan.read_costs`), else the paper's.

    Raises:
        InvalidInput: A price is no number >= 0, or costs are given without one; a mistake in
            the file.
    """
    for flag, value in (("--per-s", per_s), ("--per-j", per_J)):
        if not (math.isfinite(value) and value >= 0):
            raise InvalidInput(f"{flag}: expected points >= 0, got {value:g}")
    if costs is None:
        return Prices(per_s, per_J)
    if not (per_s or per_J):
        raise InvalidInput("--costs: seconds and joules have no price; add --per-s or --per-j")
    return Prices(per_s, per_J, read_costs(costs))
