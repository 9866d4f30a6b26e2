"""Motions as JSON files, one a motion.

    {"name": "sit", "start": "crawling", "end": "prone",
     "guard": {"error": 1.0, "seconds": 0.8},
     "stages": [{"q": [22 numbers], "seconds": 0.6, "hold": 0.1,
                 "until": {"angle": "pitch_B", "below": -1.2}, "timeout": 0.5,
                 "feedback": [["left_ankle_pitch", 0.5, 0.05, -1.57]],
                 "window": {"pitch": 0.0, "within": 0.5, "lean": 0.4},
                 "through": [[22 numbers], [22 numbers]], "pitch": [-0.7, -1.57]}]}

Of a stage only ``q`` and ``seconds`` must be there, of a motion all but ``guard``. With
``"repeat": 3`` the stages are played three times over. ``note`` is free text. Other keys are
refused.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import fields
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from mobius.errors import InvalidInput, UnknownName
from mobius.modes.motions.motion import Feedback, Guard, Motion, Stage, Until, Window

Made = TypeVar("Made")

MAX_REPEAT = 1000
"""Most repetitions a file may ask for."""


def _folder() -> Path:
    return Path(str(resources.files("mobius.modes.motions") / "data"))


def motion_names() -> tuple[str, ...]:
    """Names of the motions that come with the package, sorted."""
    return tuple(sorted(path.stem for path in _folder().glob("*.json")))


@cache
def load_motion(name: str) -> Motion:
    """The shipped motion called ``name``.

    Raises:
        UnknownName: There is none of this name.
        InvalidInput: Its file is wrong; the message names file and field.
    """
    if name not in motion_names():
        raise UnknownName("motion", name, motion_names())
    return read_motion(_folder() / f"{name}.json")


def read_motion(path: Path) -> Motion:
    """A motion from a JSON file; its name is that of the file.

    Raises:
        InvalidInput: The file is missing or wrong; the message names file and field.
    """
    try:
        document = json.loads(path.read_text())
    except OSError as error:
        raise InvalidInput(f"{path}: cannot be read ({error.strerror})") from None
    except ValueError as error:
        raise InvalidInput(f"{path}: not JSON ({error})") from None
    try:
        return _motion(document, path.stem)
    except (InvalidInput, UnknownName) as error:
        raise InvalidInput(f"{path.name}: {error}") from None


def _motion(document: Any, stem: str) -> Motion:
    known = {f.name for f in fields(Motion)}
    _keys("the motion", document, known - {"guard"}, known | {"note", "repeat"})
    if document["name"] != stem:
        raise InvalidInput(f"name: expected '{stem}' as the file is called, got {document['name']}")
    if not isinstance(document["stages"], list):
        raise InvalidInput("stages: expected a list")
    repeat = document.get("repeat", 1)
    if not isinstance(repeat, int) or not 1 <= repeat <= MAX_REPEAT:
        raise InvalidInput(f"repeat: expected a whole number from 1 to {MAX_REPEAT}, got {repeat}")
    stages = [_said(f"stages[{i}]", _stage, entry) for i, entry in enumerate(document["stages"])]
    return Motion(
        name=stem,
        start=document["start"],
        end=document["end"],
        stages=tuple(repeat * stages),
        guard=_made("guard", Guard, document.get("guard", {})),
    )


def _stage(entry: Any) -> Stage:
    known = {f.name for f in fields(Stage)}
    _keys("the stage", entry, {"q", "seconds"}, known | {"note"})
    if not isinstance(entry["q"], list):
        raise InvalidInput("q: expected a list of 22 angles [rad]")
    plain = {
        k: entry[k] for k in ("q", "seconds", "hold", "timeout", "through", "pitch") if k in entry
    }
    try:
        float(sum(plain["q"]))
    except TypeError:
        raise InvalidInput(f"q: expected 22 numbers [rad], got {plain['q']}") from None
    if "through" in plain:
        try:
            plain["through"] = np.array(plain["through"], dtype=float).reshape(-1, len(plain["q"]))
        except (TypeError, ValueError):
            raise InvalidInput("through: expected a list of poses of 22 numbers [rad]") from None
    if not isinstance(plain.get("pitch", []), list):
        raise InvalidInput(f"pitch: expected a list of angles [rad], got {plain['pitch']!r}")
    for key, make in (("until", Until), ("window", Window)):
        if entry.get(key) is not None:
            plain[key] = _made(key, make, entry[key])
    rows = entry.get("feedback", [])
    if not isinstance(rows, list) or any(not isinstance(r, list) or len(r) != 4 for r in rows):
        raise InvalidInput(
            "feedback: expected a list of [joint, k_p, k_d, pitch], e.g."
            ' [["left_ankle_pitch", 0.5, 0.05, -1.57]]'
        )
    return Stage(**plain, feedback=tuple(Feedback(*row) for row in rows))


def _made(what: str, kind: Callable[..., Made], entry: Any) -> Made:
    """A small record of the format; unknown keys are refused."""
    known = {f.name for f in fields(kind)}  # type: ignore[arg-type]
    _keys(what, entry, {"angle"} & known, known)
    return kind(**entry)


def _said(where: str, make: Callable[[Any], Made], entry: Any) -> Made:
    """``make(entry)``; an error says where."""
    try:
        return make(entry)
    except (InvalidInput, UnknownName) as error:
        raise InvalidInput(f"{where}: {error}") from None


def _keys(what: str, entry: Any, needed: set[str], known: set[str]) -> None:
    if not isinstance(entry, Mapping):
        raise InvalidInput(f"{what}: expected an object, got {entry!r}")
    missing, extra = sorted(needed - set(entry)), sorted(set(entry) - known)
    if missing:
        raise InvalidInput(f"{what}: expected '{missing[0]}', which is missing")
    if extra:
        raise InvalidInput(f"{what}: unknown '{extra[0]}'; known: {', '.join(sorted(known))}")
