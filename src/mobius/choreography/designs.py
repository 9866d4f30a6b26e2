"""Every motion that is built, by name, from the numbers the search has found."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from mobius.choreography import rear, tumble
from mobius.errors import InvalidInput, UnknownName
from mobius.modes.motions import Motion

Range = tuple[float, float, float]


@dataclass(frozen=True)
class Design:
    """One motion as a function of numbers."""

    name: str
    build: Callable[[Mapping[str, float]], Motion]
    numbers: tuple[str, ...] = ()
    """Files of numbers it is built from; motions may share them. A search writes the first."""
    ranges: Mapping[str, Range] = field(default_factory=dict)
    """Name -> (lowest, highest, first spread) of what a search may choose."""
    keyframe: str = "crawl"
    """Where a rehearsal begins."""


DESIGNS = {
    d.name: d
    for d in (
        Design("crawl_to_stand", rear.crawl_to_stand, ("rear",), rear.NUMBERS),
        Design("stand_to_crawl", rear.stand_to_crawl, ("rear",), rear.NUMBERS, "stand"),
        Design("roll", tumble.roll, ("roll",), tumble.ROLL_NUMBERS),
        Design("supine_to_crawl", tumble.supine_to_crawl, ("over",), tumble.OVER_NUMBERS, "supine"),
        Design(
            "supine_recovery",
            tumble.supine_recovery,
            ("over", "rear"),
            {**tumble.OVER_NUMBERS, **rear.NUMBERS},
            "supine",
        ),
        Design("head_recovery", tumble.head_recovery, ("over",), tumble.OVER_NUMBERS, "on_head"),
        Design("prone_to_crawl", lambda _: tumble.prone_to_crawl(), keyframe="prone"),
    )
}
"""By name."""


def design_of(name: str) -> Design:
    """The design called ``name``. Raises :class:`UnknownName`."""
    if name not in DESIGNS:
        raise UnknownName("motion design", name, DESIGNS)
    return DESIGNS[name]


def numbers_file(name: str) -> Path:
    """Where numbers of this name are kept."""
    return Path(str(resources.files("mobius.choreography") / "numbers" / f"{name}.json"))


def read_numbers(design: Design) -> dict[str, float]:
    """The numbers a design was last given. Raises :class:`InvalidInput` when some are missing."""
    numbers: dict[str, float] = {}
    for name in design.numbers:
        numbers.update(json.loads(numbers_file(name).read_text()))
    missing = sorted(set(design.ranges) - set(numbers))
    if missing:
        raise InvalidInput(
            f"numbers of {design.name}: expected '{missing[0]}' in"
            f" {', '.join(f'{n}.json' for n in design.numbers)}, where it is missing"
        )
    return numbers


def as_document(motion: Motion) -> dict[str, Any]:
    """A motion as :func:`mobius.modes.motions.read_motion` reads it; angles to 1e-6 rad."""
    return {
        "name": motion.name,
        "start": motion.start.value,
        "end": motion.end.value,
        "stages": [_stage(s) for s in motion.stages],
    }


def _stage(stage: Any) -> dict[str, Any]:
    entry: dict[str, Any] = {"q": _rounded(stage.q), "seconds": round(stage.seconds, 4)}
    if len(stage.through):
        entry["through"] = [_rounded(q) for q in stage.through]
    if stage.hold:
        entry["hold"] = round(stage.hold, 4)
    if stage.until is not None:
        u = stage.until
        entry["until"] = {"angle": u.angle, "above": u.above, "below": u.below}
        entry["timeout"] = stage.timeout
    if stage.feedback:
        entry["feedback"] = [[f.joint, f.k_p, f.k_d, f.pitch] for f in stage.feedback]
    if stage.window is not None:
        w = stage.window
        entry["window"] = {k: v for k, v in vars(w).items() if np.isfinite(v)}
    if stage.pitch:
        entry["pitch"] = [round(p, 6) for p in stage.pitch]
    return entry


def _rounded(q: Any) -> list[float]:
    return [round(float(v), 6) + 0.0 for v in q]
