"""What a search tells while it runs: the best objective so far, and the bound on every plan."""

from __future__ import annotations

import time
from collections.abc import Callable

__all__ = ["OnProgress", "Teller"]

OnProgress = Callable[[float, float, float], object]
"""Called with seconds since the search began, best objective so far (-inf without a plan), and
bound [points]; each time one of the two is better than before."""


class Teller:
    """Passes on what is news; the objective only rises and the bound only falls."""

    def __init__(self, on_progress: OnProgress | None, began: float) -> None:
        """Start.

        Args:
            on_progress: Whom to tell; ``None`` for nobody.
            began: ``time.perf_counter()`` at the start [s].
        """
        self._tell, self._began = on_progress, began
        self._objective, self._bound = -float("inf"), float("inf")

    def __call__(self, objective: float, bound: float) -> None:
        """Take in where the search stands [points]; tells if it is news."""
        objective, bound = max(objective, self._objective), min(bound, self._bound)
        if self._tell is None or (objective, bound) == (self._objective, self._bound):
            return
        self._objective, self._bound = objective, bound
        self._tell(time.perf_counter() - self._began, objective, bound)
