"""Small hand-made SVG: escaping, numbers, ticks, thinned lines and pictures as data.

Colours are left to the style sheet of ``report_page.html`` (classes and variables), so
that a figure is right in light and in dark.
"""

from __future__ import annotations

import base64
import html
import io
from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image

__all__ = ["Axis", "number", "png_data", "points", "tag", "text", "thin", "ticks"]

Array = NDArray[np.float64]


def tag(name: str, content: str = "", /, **attributes: object) -> str:
    """One element; ``stroke_width=2`` becomes ``stroke-width="2"``, ``class_`` ``class``.

    Floats are written with two decimals, values are escaped, None leaves one out.
    ``content`` is taken as it is.
    """
    parts = [name]
    for key, value in attributes.items():
        if value is None:
            continue
        shown = f"{value:.2f}" if isinstance(value, float | np.floating) else str(value)
        parts.append(f'{key.rstrip("_").replace("_", "-")}="{html.escape(shown)}"')
    return f"<{' '.join(parts)}>{content}</{name}>"


def text(x: float, y: float, content: str, **attributes: object) -> str:
    """Text, escaped, at a point of the picture [px]."""
    return tag("text", html.escape(content), x=float(x), y=float(y), **attributes)


def number(value: object, *, digits: int = 3) -> str:
    """A number for reading: so many significant digits, no exponent near one."""
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    if isinstance(value, int | np.integer):
        return f"{value:,}".replace(",", "\u202f")
    if isinstance(value, float | np.floating):
        if not np.isfinite(value):
            return "not finite"
        size = abs(float(value))
        if size != 0 and not 1e-4 <= size < 1e6:
            return f"{value:.{digits - 1}e}"
        decimals = 0 if size == 0 else max(0, digits - 1 - int(np.floor(np.log10(size))))
        return f"{value:.{decimals}f}"
    return str(value)


def ticks(low: float, high: float, *, most: int = 6) -> list[float]:
    """At most ``most + 1`` round numbers within [low, high]: steps of 1, 2 or 5 times 10^k."""
    span = high - low
    if not span > 0:
        return [low]
    raw = span / most
    power = 10.0 ** np.floor(np.log10(raw))
    step = next((m * power for m in (1, 2, 5, 10) if m * power >= raw * (1 - 1e-9)), 10 * power)
    first, last = int(np.ceil(low / step - 1e-9)), int(np.floor(high / step + 1e-9))
    return [float(round(k * step, 10)) for k in range(first, last + 1)]


def thin(t: Array, y: Array, *, bins: int = 500) -> tuple[Array, Array]:
    """At most two samples per bin, its lowest and highest in the order of time.

    Peaks stay where they are; samples that are not finite are left out.
    """
    good = np.isfinite(t) & np.isfinite(y)
    t, y = t[good], y[good]
    if len(t) <= 2 * bins:
        return t, y
    keep: list[int] = []
    for rows in np.array_split(np.arange(len(t)), bins):
        low, high = rows[np.argmin(y[rows])], rows[np.argmax(y[rows])]
        keep += sorted({int(low), int(high)})
    return t[keep], y[keep]


def points(x: Iterable[float], y: Iterable[float]) -> str:
    """The ``points`` attribute of a polyline, one decimal [px]."""
    return " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))


def png_data(pixels: NDArray[np.uint8]) -> str:
    """A picture (h, w, 3 or 4) as a ``data:`` address, losslessly compressed."""
    file = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(pixels)).save(file, "PNG", optimize=True)
    return "data:image/png;base64," + base64.b64encode(file.getvalue()).decode()


def jpeg_data(pixels: NDArray[np.uint8]) -> str:
    """A photograph-like picture (h, w, 3) as a ``data:`` address."""
    file = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(pixels)).save(file, "JPEG", quality=85, optimize=True)
    return "data:image/jpeg;base64," + base64.b64encode(file.getvalue()).decode()


class Axis:
    """A straight scale: values from ``low`` to ``high`` onto pixels from ``a`` to ``b``."""

    def __init__(self, low: float, high: float, a: float, b: float) -> None:
        if not high > low:
            middle, half = low, max(abs(low) * 0.05, 1e-3)
            low, high = middle - half, middle + half
        self.low, self.high, self.a, self.b = float(low), float(high), float(a), float(b)

    def __call__(self, value: ArrayLike) -> Array:
        """Pixels of values."""
        share = (np.asarray(value, dtype=float) - self.low) / (self.high - self.low)
        return self.a + share * (self.b - self.a)
