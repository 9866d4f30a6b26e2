"""What grows harder while a policy learns: commands, kicks, ground.

All of it is in :meth:`Curriculum.state`, so that a resumed run goes on where it was.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Ids = NDArray[np.int64]


@dataclass(frozen=True)
class CurriculumConfig:
    """Rules; a start of 1 switches a part off."""

    review: int = 24
    """Policy steps between reviews."""
    command_start: float = 1.0
    """Share of the command range at the beginning."""
    command_error: float = 0.25
    """Commands grow while the mean relative velocity error is below this."""
    kick_start: float = 1.0
    """Share of the kicks at the beginning."""
    kick_falls: float = 2.0
    """Kicks grow while there are fewer falls a minute and robot, and shrink above twice that."""
    step: float = 0.02
    """Change of a share at a review."""


class Curriculum:
    """Shares in [0, 1] of the command range and the kicks; a terrain level for each robot.

    Robots begin on all levels: an episode is long, and who cannot cope sinks fast.
    """

    def __init__(self, cfg: CurriculumConfig, n: int, *, levels: int, columns: int) -> None:
        self.cfg, self.n, self.levels, self.columns = cfg, n, levels, columns
        self.command, self.kick = cfg.command_start, cfg.kick_start
        self.level = np.arange(n, dtype=np.int64) // max(columns, 1) % (levels + 1)
        self.column = np.arange(n, dtype=np.int64) % max(columns, 1)
        self._steps = 0
        self._falls = self._error = 0.0

    def watch(self, relative_error: float, falls_per_minute: float) -> None:
        """Take in one policy step's means; a review every ``cfg.review`` steps."""
        self._steps += 1
        self._falls += falls_per_minute / self.cfg.review
        self._error += relative_error / self.cfg.review
        if self._steps % self.cfg.review:
            return
        cfg = self.cfg
        if self._error < cfg.command_error:
            self.command = min(1.0, self.command + cfg.step)
        if self._falls < cfg.kick_falls:
            self.kick = min(1.0, self.kick + cfg.step)
        elif self._falls > 2 * cfg.kick_falls:
            self.kick = max(min(cfg.kick_start, 0.2), self.kick - cfg.step)
        self._falls = self._error = 0.0

    def ended(self, ids: Ids, fallen: NDArray[np.bool_], rng: np.random.Generator) -> None:
        """Robots (m,) end an episode: a fall lowers the level, a whole episode raises it.

        Who passes the last level starts again on any; the kind of ground is drawn anew.
        """
        if not self.levels:
            return
        level = self.level[ids] + np.where(fallen, -1, 1)
        anywhere = rng.integers(0, self.levels + 1, len(ids))
        self.level[ids] = np.where(level > self.levels, anywhere, np.maximum(level, 0))
        self.column[ids] = rng.integers(0, self.columns, len(ids))

    def state(self) -> dict[str, Any]:
        """Everything that changes."""
        return {
            "command": self.command,
            "kick": self.kick,
            "steps": self._steps,
            "falls": self._falls,
            "error": self._error,
            "level": self.level.copy(),
            "column": self.column.copy(),
        }

    def load_state(self, state: dict[str, Any]) -> None:
        """Go on from :meth:`state`."""
        self.command, self.kick = float(state["command"]), float(state["kick"])
        self._steps = int(state["steps"])
        self._falls, self._error = float(state["falls"]), float(state["error"])
        self.level[:], self.column[:] = state["level"], state["column"]
