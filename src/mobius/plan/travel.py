"""What a metre takes in each mode, in seconds and joules: printed, or measured by physics.

A file of measured numbers is one JSON object:

    {"format": "mobius travel 1",
     "source": "which robot, which run",
     "modes": {"crawl": {"m_per_s": 0.31, "J_per_m": 142.0}, ...},
     "switches": [{"from": "crawl", "to": "biped", "s": 6.1, "J": 210.0}, ...]}

``modes`` holds biped, crawl and roll, or those of them that were measured; ``source`` and
``switches`` may be left out.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any

from mobius import paper
from mobius.errors import InvalidInput, PlanError, UnknownName
from mobius.plan.actions import PLANNABLE
from mobius.types import Mode

__all__ = ["FORMAT", "MAX_SPEED", "PAPER_TRAVEL", "Travel", "plan_mode", "read_costs"]

FORMAT = "mobius travel 1"
"""Value of the key ``format``."""

MAX_SPEED: Mapping[Mode, float] = MappingProxyType(
    {mode: paper.MAX_SPEED[mode] for mode in PLANNABLE}
)
"""Top speed of each mode [m/s], Table V."""

J_PER_M: Mapping[Mode, float] = MappingProxyType(
    {
        mode: (paper.TABLE_VIII_ROLL_V3 if mode is Mode.ROLL else paper.TABLE_VIII[mode]).total
        for mode in PLANNABLE
    }
)
"""Energy of each mode [J/m], Table VIII; the roll's as corrected later (the print's does not
add up)."""

Switch = tuple[Mode, Mode]


def plan_mode(name: str | Mode) -> Mode:
    """The plannable mode of that name; raises with a suggestion when there is none."""
    names = [m.value for m in PLANNABLE]
    if str(name) not in names:
        raise UnknownName("mode", str(name), names)
    return Mode(name)


def switch_table(name: str, table: Mapping[Any, float]) -> Mapping[Switch, float]:
    """A checked table of changes (from, to); keys may be names, values are >= 0."""
    checked = {}
    for key, value in table.items():
        if isinstance(key, str) or len(key) != 2:
            raise InvalidInput(f"{name}: expected keys (from, to) of two modes, got {key!r}")
        a, b = plan_mode(key[0]), plan_mode(key[1])
        if not (math.isfinite(value) and value >= 0):
            raise InvalidInput(f"{name}[{a}, {b}]: expected a number >= 0, got {value}")
        if a is b and value:
            raise InvalidInput(f"{name}[{a}, {b}]: staying in a mode is no change; leave it out")
        checked[a, b] = float(value)
    return MappingProxyType(checked)


@dataclass(frozen=True)
class Travel:
    """Speed and energy per mode, and what a change of mode takes."""

    m_per_s: Mapping[Mode, float] = field(default_factory=lambda: MAX_SPEED)
    """Speed of each mode [m/s], > 0."""
    J_per_m: Mapping[Mode, float] = field(default_factory=lambda: J_PER_M)
    """Energy of each mode [J/m], >= 0."""
    switch_s: Mapping[Switch, float] = field(default_factory=dict)
    """Time of a change (from, to) [s], >= 0; none is 0."""
    switch_J: Mapping[Switch, float] = field(default_factory=dict)
    """Energy of a change (from, to) [J], >= 0; none is 0."""
    source: str = "the paper's Tables V and VIII"
    """Where the numbers come from."""

    def __post_init__(self) -> None:
        for name in ("m_per_s", "J_per_m"):
            table = {plan_mode(m): float(v) for m, v in getattr(self, name).items()}
            for mode, value in table.items():
                least = "> 0" if name == "m_per_s" else ">= 0"
                if not (math.isfinite(value) and value >= 0 and (value > 0 or least == ">= 0")):
                    raise InvalidInput(
                        f"Travel.{name}[{mode}]: expected a number {least}, got {value}"
                    )
            object.__setattr__(self, name, MappingProxyType(table))
        for name in ("switch_s", "switch_J"):
            object.__setattr__(self, name, switch_table(f"Travel.{name}", getattr(self, name)))

    def seconds(self, mode: Mode, length: float) -> float:
        """Time [s] of ``length`` [m] in a mode."""
        if mode not in self.m_per_s:
            raise PlanError(f"no speed for mode '{mode}' ({self.source}); add it to m_per_s")
        return length / self.m_per_s[mode]

    def joules(self, mode: Mode, length: float) -> float:
        """Energy [J] of ``length`` [m] in a mode."""
        if mode not in self.J_per_m:
            raise PlanError(f"no energy for mode '{mode}' ({self.source}); add it to J_per_m")
        return length * self.J_per_m[mode]

    def switch_points(self, *, per_s: float = 0.0, per_J: float = 0.0) -> dict[Switch, float]:
        """Every change (from, to) in points, for the option ``switch_cost`` of a problem."""
        pairs = dict.fromkeys([*self.switch_s, *self.switch_J])
        return {
            p: per_s * self.switch_s.get(p, 0.0) + per_J * self.switch_J.get(p, 0.0) for p in pairs
        }

    def as_json(self) -> dict[str, Any]:
        """What :func:`read_costs` reads, for ``json.dump``."""
        pairs = dict.fromkeys([*self.switch_s, *self.switch_J])
        return {
            "format": FORMAT,
            "source": self.source,
            "modes": {
                m.value: {"m_per_s": self.m_per_s[m], "J_per_m": self.J_per_m[m]}
                for m in self.m_per_s
                if m in self.J_per_m
            },
            "switches": [
                {
                    "from": a.value,
                    "to": b.value,
                    "s": self.switch_s.get((a, b), 0.0),
                    "J": self.switch_J.get((a, b), 0.0),
                }
                for a, b in pairs
            ],
        }


PAPER_TRAVEL = Travel()
"""Tables V and VIII."""


def read_costs(path: str | Path) -> Travel:
    """Read measured numbers from a JSON file, see the module's docstring for the format.

    Raises:
        InvalidInput: There is no such file, or it is not of this format; says which key is
            wrong and what it should hold.
        UnknownName: It names a mode that is none.
    """
    path = Path(path)
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InvalidInput(
            f"{path}: there is no such file; expected a JSON file of travel costs"
        ) from None
    except (OSError, ValueError) as error:
        raise InvalidInput(f"{path}: expected a JSON file of travel costs: {error}") from None
    top = _object(path, "the file", data, {"format", "modes"}, {"source", "switches"})
    if top["format"] != FORMAT:
        raise InvalidInput(f"{path}: format: expected '{FORMAT}', got {top['format']!r}")
    modes = _object(path, "modes", top["modes"], set(), [m.value for m in PLANNABLE])
    if not modes:
        raise InvalidInput(f"{path}: modes: expected at least one of biped, crawl, roll, got none")
    speed, energy = {}, {}
    for name, row in modes.items():
        mode, where = plan_mode(name), f"modes.{name}"
        row = _object(path, where, row, {"m_per_s", "J_per_m"})
        speed[mode] = _number(path, f"{where}.m_per_s", row["m_per_s"], above=True)
        energy[mode] = _number(path, f"{where}.J_per_m", row["J_per_m"])
    seconds, joules = {}, {}
    switches = top.get("switches", [])
    if not isinstance(switches, list):
        raise InvalidInput(f"{path}: switches: expected a list, got {switches!r}")
    for n, row in enumerate(switches):
        where = f"switches[{n}]"
        row = _object(path, where, row, {"from", "to"}, {"s", "J"})
        pair = plan_mode(row["from"]), plan_mode(row["to"])
        seconds[pair] = _number(path, f"{where}.s", row.get("s", 0.0))
        joules[pair] = _number(path, f"{where}.J", row.get("J", 0.0))
    return Travel(speed, energy, seconds, joules, str(top.get("source", path)))


def _object(
    path: Path, where: str, value: Any, needed: set[str], other: Iterable[str] = ()
) -> dict[str, Any]:
    """A JSON object with these keys and no others."""
    if not isinstance(value, dict):
        raise InvalidInput(f"{path}: {where}: expected an object {{...}}, got {value!r}")
    if lacking := needed - value.keys():
        raise InvalidInput(f"{path}: {where}: the key '{min(lacking)}' is missing")
    known = needed | set(other)
    if extra := value.keys() - known:
        raise UnknownName(f"key of {where} in {path}", min(extra), known)
    return value


def _number(path: Path, where: str, value: Any, *, above: bool = False) -> float:
    """A finite number >= 0, or > 0."""
    fits = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not (fits and math.isfinite(value) and value >= 0 and (value > 0 or not above)):
        raise InvalidInput(
            f"{path}: {where}: expected a number {'>' if above else '>='} 0, got {value!r}"
        )
    return float(value)
