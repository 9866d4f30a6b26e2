"""A user's sweep as a yaml file: lists of settings, and the maps to plan on.

    map: demo                        # or a list; a Nav2 .yaml, a .map, a shipped name
    horizon: [20, 40]
    modes: [crawl, biped+crawl+roll]
    W_exp: [1, 50, 100]

Every key may be one value or a list; every combination is planned. Only ``horizon`` has no
default.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_args

from mobius.errors import MapError, MobiusError, did_you_mean
from mobius.plan import reconstructed_map
from mobius.plan.actions import PLANNABLE, Connectivity
from mobius.plan.problem import DEFAULT_WEIGHTS, MAX_TABLE, Count
from mobius.sweep.paper_grids import MAP
from mobius.sweep.planner import ALL_MODES, SETTING_KEYS, PlannerWork, modes_of
from mobius.sweep.settings import Setting, product_of
from mobius.types import GridMap, Mode
from mobius.world.keys import Section, read_yaml, shown

__all__ = ["RECONSTRUCTED", "GridFile", "read_grid_file"]

RECONSTRUCTED = "reconstructed"
"""How a file names the reconstructed map."""
NUMBERS = ("W_exp", "W_goal", "P_biped", "P_crawl", "P_roll")

OpenMap = Callable[..., GridMap]
"""``open_map(source, start=, goal=)``: the planner's grid of a map."""


@dataclass(frozen=True, eq=False)
class GridFile:
    """What a sweep file asks for."""

    settings: list[Setting]
    work: PlannerWork


def read_grid_file(path: str | Path, open_map: OpenMap) -> GridFile:
    """Read, check and multiply out a sweep file.

    Args:
        path: The yaml.
        open_map: Reads a map and lays the planner's grid over it.

    Raises:
        MapError: A mistake in the file, with its line; a map that cannot be read.
    """
    doc = read_yaml(Path(path), what="a sweep", first="horizon: [20, 40]")
    doc.only((*SETTING_KEYS, "start", "goal"))
    values: dict[str, list[Any]] = {
        "map": _texts(doc, "map", RECONSTRUCTED),
        "horizon": [_whole(doc, word) for word in doc.scalars("horizon", example="[20, 40]")],
        "modes": [_modes(doc, word) for word in _texts(doc, "modes", ALL_MODES)],
        "connectivity": _words(doc, "connectivity", get_args(Connectivity), "axis"),
        "count": _words(doc, "count", get_args(Count), "sweep"),
        **{key: _penalties(doc, key) for key in NUMBERS},
    }
    for key, listed in values.items():
        for k, value in enumerate(listed):
            if value in listed[:k]:
                raise doc.error(key, f"{value} is listed twice; remove one of them")
    ends = {
        end: doc.numbers(end, 2, example="[0.5, 1.5]") for end in ("start", "goal") if end in doc
    }
    maps = {name: _map(doc, name, ends, open_map) for name in values["map"]}
    if RECONSTRUCTED in maps:  # its results are always labelled
        values["map"] = [MAP if name == RECONSTRUCTED else name for name in values["map"]]
        maps[MAP] = maps.pop(RECONSTRUCTED)
    for name, grid in maps.items():
        most = MAX_TABLE // grid.blocked.size - 1
        if max(values["horizon"]) > most:
            raise doc.error("horizon", f"expected at most {most} on map {shown(name)}")
    return GridFile(product_of(values), PlannerWork(maps))


def _texts(doc: Section, key: str, default: str) -> list[str]:
    return doc.scalars(key, example=default) if key in doc else [default]


def _words(doc: Section, key: str, allowed: Sequence[str], default: str) -> list[str]:
    words = _texts(doc, key, default)
    for word in words:
        if word not in allowed:
            raise doc.error(
                key,
                f"unknown value {shown(word)}.{did_you_mean(word, allowed)}"
                f" Known: {', '.join(allowed)}",
            )
    return words


def _modes(doc: Section, word: str) -> str:
    """Names joined by '+', in one order whatever the order written."""
    known = [mode.value for mode in PLANNABLE]
    names = [name.strip() for name in modes_of(word)]
    for name in names:
        if name not in known:
            raise doc.error(
                "modes",
                f"unknown mode {shown(name)}.{did_you_mean(name, known)}"
                f" Known: {', '.join(known)}, joined by '+'",
            )
    return "+".join(name for name in known if name in names)


def _whole(doc: Section, word: str) -> int:
    if not word.isascii() or not word.isdigit():
        raise doc.error("horizon", f"expected whole numbers >= 0, got {shown(word)}")
    return int(word)


def _penalties(doc: Section, key: str) -> list[float]:
    """Weights are points >= 0."""
    usual = DEFAULT_WEIGHTS.P[Mode(key[2:])] if key[:2] == "P_" else getattr(DEFAULT_WEIGHTS, key)
    if key not in doc:
        return [usual]
    values = []
    for word in doc.scalars(key, example="[1, 50]"):
        try:
            value = float(word)
        except ValueError:
            value = float("nan")
        if not 0 <= value < float("inf"):
            raise doc.error(key, f"expected numbers >= 0, got {shown(word)}")
        values.append(value)
    return values


def _map(doc: Section, name: str, ends: dict[str, list[float]], open_map: OpenMap) -> GridMap:
    """A map by its name, or by its path as seen from the sweep file."""
    if name == RECONSTRUCTED:
        if ends:
            raise doc.error(next(iter(ends)), "the reconstructed map has its own start and goal")
        return reconstructed_map()
    beside = doc.file.parent / name
    source = str(beside) if beside.is_file() else name
    try:
        return open_map(source, **ends)
    except MobiusError as error:
        if isinstance(error, MapError):
            raise
        raise doc.error("map", f"{error} Or '{RECONSTRUCTED}'") from None
