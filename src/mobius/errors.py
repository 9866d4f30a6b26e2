"""Errors a user can act on: what was expected, what came, and what to type next."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import Any

__all__ = [
    "InvalidInput",
    "MapError",
    "MissingDependency",
    "MobiusError",
    "PlanError",
    "PolicyError",
    "UnknownName",
    "did_you_mean",
]


def did_you_mean(name: str, allowed: Iterable[str]) -> str:
    """Return ``" Did you mean 'x'?"`` for the closest allowed name, or ``""``."""
    close = difflib.get_close_matches(name, list(allowed), n=1, cutoff=0.5)
    return f" Did you mean '{close[0]}'?" if close else ""


class MobiusError(Exception):
    """Base of every error that is the user's to fix; the CLI prints it in one line.

    Bugs of ours stay ordinary exceptions, with their traceback. Errors cross to other processes
    whatever their constructors ask for.
    """

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (type(self), self.args, self.__dict__)


def _again(kind: type[MobiusError], args: tuple[Any, ...], attributes: dict[str, Any]) -> Any:
    """An error as it was in another process."""
    error = kind.__new__(kind)
    error.args = args
    error.__dict__.update(attributes)
    return error


class InvalidInput(MobiusError, ValueError):
    """A value has the wrong shape, unit or range."""


class UnknownName(MobiusError, LookupError):
    """A name is not among those that exist.

    Attributes:
        name: What was asked for.
        allowed: What exists, sorted.
    """

    def __init__(self, kind: str, name: str, allowed: Iterable[str]) -> None:
        self.name = name
        self.allowed = sorted(allowed)
        super().__init__(
            f"unknown {kind} '{name}'.{did_you_mean(name, self.allowed)}"
            f" Known: {', '.join(self.allowed)}."
        )


class MapError(MobiusError):
    """A map file, or a place on a map, cannot be used: names file, place and fix."""


class PlanError(MobiusError):
    """No plan exists, or a plan breaks a rule."""


class PolicyError(MobiusError):
    """A policy file does not fit the robot or the observation."""


class MissingDependency(MobiusError, ImportError):
    """An optional package is not installed; the message names the extra to install."""

    def __init__(self, package: str, extra: str, purpose: str) -> None:
        super().__init__(
            f"{purpose} needs the package '{package}', which is not installed."
            f" Type: pip install 'mobius[{extra}]'"
        )
