"""One colour per mode and per role, the same in the report and in the video."""

from __future__ import annotations

from mobius.types import Mode

__all__ = ["MODE_COLOURS", "rgb"]

MODE_COLOURS: dict[str, str] = {
    Mode.CRAWL: "#2a7fd4",
    Mode.BIPED: "#d9772b",
    Mode.ROLL: "#2f9e6e",
    Mode.CLIMB: "#a05ac8",
    Mode.PULL_UP: "#c2478a",
    Mode.GATHER: "#9c8f5a",
    Mode.STAND_UP: "#b79a1d",
    Mode.LIE_DOWN: "#6f8896",
    Mode.RECOVER: "#cf4444",
    Mode.PUSH_UPS: "#5f6fd6",
    Mode.STOP: "#4a4a4a",
}
"""Colour of every mode; told apart also by those who do not see red and green alike."""


def rgb(colour: str) -> tuple[float, float, float]:
    """Red, green, blue in [0, 1] of a ``#rrggbb`` colour."""
    return tuple(int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5))  # type: ignore[return-value]
