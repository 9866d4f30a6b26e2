"""The mode machine of Fig. 6, with the modes there are so far."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from mobius.errors import InvalidInput
from mobius.types import Mode, ModeCommand

SUCCESSORS: dict[Mode, frozenset[Mode]] = {
    Mode.CRAWL: frozenset({Mode.CRAWL, Mode.STAND_UP, Mode.ROLL, Mode.RECOVER}),
    Mode.BIPED: frozenset({Mode.BIPED, Mode.LIE_DOWN, Mode.CLIMB, Mode.PULL_UP, Mode.RECOVER}),
    Mode.ROLL: frozenset({Mode.ROLL, Mode.CRAWL, Mode.RECOVER}),
    Mode.STAND_UP: frozenset({Mode.STAND_UP, Mode.BIPED, Mode.RECOVER}),
    Mode.LIE_DOWN: frozenset({Mode.LIE_DOWN, Mode.CRAWL, Mode.RECOVER}),
    Mode.CLIMB: frozenset({Mode.CLIMB, Mode.BIPED, Mode.RECOVER}),
    Mode.PULL_UP: frozenset({Mode.PULL_UP, Mode.BIPED, Mode.RECOVER}),
    Mode.RECOVER: frozenset({Mode.RECOVER, Mode.CRAWL}),
}
"""Which mode may follow which (Fig. 6 and the transitions of Fig. 13)."""


@dataclass
class ModeMachine:
    """Lets through the modes that the robot can be and may switch to."""

    available: frozenset[Mode]
    """Modes with a controller."""
    mode: Mode = Mode.CRAWL
    stopped: bool = field(default=False, init=False)

    def __post_init__(self) -> None:
        if self.mode not in self.available:
            names = ", ".join(sorted(self.available))
            raise InvalidInput(f"start mode '{self.mode}' has no controller; available: {names}")

    def emergency_stop(self) -> None:
        """From any state: every later command becomes standing still."""
        self.stopped = True

    def step(self, wanted: ModeCommand) -> ModeCommand:
        """The command to carry out.

        Raises:
            InvalidInput: the wanted mode has no controller, or may not follow this one.
        """
        if self.stopped:
            return ModeCommand(mode=self.mode, twist_H=np.zeros(3), stamp=wanted.stamp)
        if wanted.mode not in self.available:
            names = ", ".join(sorted(self.available))
            raise InvalidInput(f"mode '{wanted.mode}' has no controller yet; available: {names}")
        if wanted.mode not in SUCCESSORS[self.mode]:
            names = ", ".join(sorted(SUCCESSORS[self.mode]))
            raise InvalidInput(f"mode '{wanted.mode}' may not follow '{self.mode}'; legal: {names}")
        self.mode = wanted.mode
        return wanted
