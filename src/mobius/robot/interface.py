"""What every body of the robot offers, simulated or real: connect, read, write, wait, close."""

from __future__ import annotations

from types import TracebackType
from typing import Protocol, Self, runtime_checkable

from mobius.types import JointCommand, SensorFrame, StateEstimate

TICK = 1 / 600
"""The base clock [s]: 300 Hz is 2 ticks, 200 Hz 3, 60 Hz 10, 30 Hz 20."""


@runtime_checkable
class Robot(Protocol):
    """A robot behind one protocol; ``with robot:`` connects and closes."""

    def connect(self) -> None:
        """Open the devices; the robot holds its pose."""

    def read(self) -> SensorFrame:
        """The newest readings. Devices that did not tick since the last read are ``None``."""

    def write(self, command: JointCommand) -> JointCommand:
        """Send servo targets; returns what the limits let through."""

    def wait(self) -> None:
        """Let one tick of the base clock pass."""

    def close(self) -> None:
        """Release the devices."""

    def __enter__(self) -> Self: ...

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None: ...


class Simulated:
    """What every simulated body does the same: there is nothing to open or release."""

    def connect(self) -> None:
        """Nothing to open."""

    def close(self) -> None:
        """Nothing to release."""

    def __enter__(self) -> Self:
        self.connect()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


@runtime_checkable
class Observable(Protocol):
    """A simulated robot also tells the truth, to judges and reports only."""

    def truth(self) -> StateEstimate:
        """True trunk state in the world frame."""
