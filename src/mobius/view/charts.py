"""Figures over time as SVG: lines, contacts, torques."""

from __future__ import annotations

import html
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from mobius.view.svg import Axis, number, png_data, points, tag, text, thin, ticks

__all__ = ["Line", "bars_chart", "heat_chart", "line_chart"]

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

_WIDTH, _HEIGHT = 480, 190
_LEFT, _RIGHT, _TOP, _BOTTOM = 46, 8, 18, 34


@dataclass(frozen=True, eq=False)
class Line:
    """One curve: its name, its values (n,), its class in the style sheet."""

    name: str
    y: Array
    style: str


def line_chart(
    title: str, unit: str, t: Array, lines: Sequence[Line], *, zero: bool = False
) -> str:
    """Curves over the time t (n,) [s] with a legend that shows values under the pointer.

    Args:
        title: Heading of the figure.
        unit: Unit of the vertical axis.
        t: (n,) [s].
        lines: Curves, drawn in order, the last on top.
        zero: Whether the vertical axis starts at zero.
    """
    values = np.concatenate([line.y[np.isfinite(line.y)] for line in lines] or [np.zeros(1)])
    low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 1.0)
    pad = 0.06 * (high - low)
    x_axis = Axis(t[0], t[-1], _LEFT, _WIDTH - _RIGHT)
    y_axis = Axis(0.0 if zero else low - pad, high + pad, _HEIGHT - _BOTTOM, _TOP)
    curves = []
    for line in lines:
        at, y = thin(t, line.y)
        curves.append(
            tag("polyline", points=points(x_axis(at), y_axis(y)), class_=f"line {line.style}")
        )
    body = _frame(x_axis, y_axis, unit, _HEIGHT) + "".join(curves) + _cursor(_HEIGHT)
    keys = "".join(
        f'<span><i class="{line.style}"></i>{html.escape(line.name)} <b></b></span>'
        for line in lines
    )
    scale = {
        "data_t0": f"{x_axis.low:.6g}",
        "data_t1": f"{x_axis.high:.6g}",
        "data_y0": f"{y_axis.low:.6g}",
        "data_y1": f"{y_axis.high:.6g}",
        "data_box": f"{_LEFT} {_WIDTH - _RIGHT} {_TOP} {_HEIGHT - _BOTTOM}",
    }
    picture = tag(
        "svg",
        body,
        viewBox=f"0 0 {_WIDTH} {_HEIGHT}",
        class_="chart",
        role="img",
        aria_label=f"{title} [{unit}] over time",
        **scale,
    )
    heading = f'<span>{html.escape(title)}</span><span class="keys">{keys}</span>'
    return f"<figure><figcaption>{heading}</figcaption>{picture}</figure>"


def bars_chart(
    title: str,
    t: Array,
    rows: Sequence[tuple[str, Flags, Flags | None, str]],
    *,
    strip: Sequence[str] | None = None,
    colours: dict[str, str] | None = None,
    width: int = 980,
) -> str:
    """On-off diagram, such as which limb stands when.

    Args:
        title: Heading of the figure.
        t: (n,) [s].
        rows: Name, (n,) on or off, (n,) second opinion drawn as a thin bar or None, and a
            remark for the right margin.
        strip: n labels drawn as a coloured band on top, or None.
        colours: Colour of every label.
        width: Width of the picture [px].
    """
    left, right, pitch, top = 84, 150, 30, 26 if strip is not None else 6
    height = top + pitch * len(rows) + _BOTTOM
    axis = Axis(t[0], t[-1], left, width - right)
    parts = []
    if strip is not None:
        parts += [_band(axis, t, strip, colours or {})]
    for k, (name, on, second, remark) in enumerate(rows):
        y = top + k * pitch
        parts.append(text(left - 8, y + 15, name, class_="label", text_anchor="end"))
        parts.append(text(width - right + 8, y + 15, remark, class_="label"))
        back = {"x": left, "y": y + 2, "width": width - right - left, "height": pitch - 6}
        parts.append(tag("rect", class_="lane", **back))
        parts.append(_runs(axis, t, on, y + 2, pitch - 11, "on"))
        if second is not None:
            parts.append(_runs(axis, t, second, y + pitch - 8, 3, "on2"))
    parts.append(_time_axis(axis, height - _BOTTOM))
    return _wide(html.escape(title), parts, width, height, label=title)


def heat_chart(
    title: str,
    unit: str,
    t: Array,
    values: Array,
    names: Sequence[str],
    *,
    remarks: Sequence[str],
    heads: str,
    columns: int = 240,
) -> str:
    """Root mean square over short spans as a field of colour, a row per name.

    Args:
        title: Heading of the figure.
        unit: Unit of the values.
        t: (n,) [s].
        values: (n, r).
        names: r names for the left margin.
        remarks: r remarks for the right margin.
        heads: Heading of the remarks.
        columns: How many spans at most.
    """
    width, left, right, pitch, top = 980, 168, 190, 17, 22
    height = top + pitch * len(names) + _BOTTOM
    axis = Axis(t[0], t[-1], left, width - right)
    pixels, most = _opacities(values, columns)
    parts = [
        tag(
            "image",
            href=png_data(pixels),
            x=left,
            y=top,
            width=width - right - left,
            height=pitch * len(names),
            preserveAspectRatio="none",
            class_="field",
        ),
        text(width - right + 8, top - 8, heads, class_="label soft"),
        text(left, top - 8, f"opaque: {number(most)} {unit}", class_="label soft"),
    ]
    for k, (name, remark) in enumerate(zip(names, remarks, strict=True)):
        y = top + k * pitch + 12.5
        parts.append(text(left - 8, y, name, class_="label", text_anchor="end"))
        parts.append(text(width - right + 8, y, remark, class_="label fixed"))
    parts.append(_time_axis(axis, height - _BOTTOM))
    heading = f"<span>{html.escape(title)} <small>[{html.escape(unit)}]</small></span>"
    return _wide(heading, parts, width, height, label=f"{title} [{unit}] over time")


def _opacities(values: Array, columns: int) -> tuple[NDArray[np.uint8], float]:
    """Picture (r, c, 4) of root mean squares over c spans, and the largest: it is opaque."""
    chunks = np.array_split(values, min(columns, len(values)), axis=0)
    rms = np.nan_to_num([np.sqrt(np.mean(np.square(c), axis=0)) for c in chunks]).T
    most = float(rms.max(initial=0.0))
    pixels = np.zeros((*rms.shape, 4), dtype=np.uint8)
    pixels[..., :3] = (217, 95, 30)
    pixels[..., 3] = np.round(255 * rms / max(most, 1e-12))
    return pixels, most


def _wide(heading: str, parts: Sequence[str], width: int, height: int, *, label: str) -> str:
    """A figure as broad as the page; ``heading`` is taken as it is."""
    picture = tag(
        "svg",
        "".join(parts),
        viewBox=f"0 0 {width} {height}",
        class_="wide",
        role="img",
        aria_label=label,
    )
    return f"<figure><figcaption>{heading}</figcaption>{picture}</figure>"


def _frame(x_axis: Axis, y_axis: Axis, unit: str, height: int) -> str:
    parts = []
    for value in ticks(y_axis.low, y_axis.high, most=5):
        y = float(y_axis(value))
        line = {"x1": x_axis.a, "x2": x_axis.b, "y1": y, "y2": y}
        parts.append(tag("line", class_="grid" if value else "grid zero", **line))
        parts.append(text(x_axis.a - 6, y + 4, _tick(value), class_="tick", text_anchor="end"))
    parts.append(text(x_axis.a, _TOP - 6, unit, class_="tick soft"))
    return "".join(parts) + _time_axis(x_axis, height - _BOTTOM)


def _time_axis(axis: Axis, y: float) -> str:
    parts = [tag("line", x1=axis.a, x2=axis.b, y1=float(y), y2=float(y), class_="axis")]
    for value in ticks(axis.low, axis.high, most=8):
        x = float(axis(value))
        parts.append(tag("line", x1=x, x2=x, y1=float(y), y2=float(y + 4), class_="axis"))
        parts.append(text(x, y + 16, _tick(value), class_="tick", text_anchor="middle"))
    middle = (axis.a + axis.b) / 2
    parts.append(text(middle, y + 30, "time [s]", class_="tick soft", text_anchor="middle"))
    return "".join(parts)


def _tick(value: float) -> str:
    return f"{value:.6g}".replace("-", "\u2212")


def _cursor(height: int) -> str:
    y = {"y1": _TOP, "y2": height - _BOTTOM}
    return tag("line", x1=-9, x2=-9, class_="cursor", **y)


def spans(flags: Flags) -> list[tuple[int, int]]:
    """First and one-past-last index of every run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _runs(axis: Axis, t: Array, on: Flags, y: float, height: float, style: str) -> str:
    """One path of rectangles."""
    ends = np.append(t, t[-1])
    pieces = []
    for a, b in spans(on):
        x0, x1 = float(axis(ends[a])), float(axis(ends[b]))
        pieces.append(f"M{x0:.1f} {y:.1f}H{x1:.1f}V{y + height:.1f}H{x0:.1f}z")
    return tag("path", d="".join(pieces), class_=style) if pieces else ""


def _band(axis: Axis, t: Array, labels: Sequence[str], colours: dict[str, str]) -> str:
    """Coloured band of labels along the time axis."""
    names = np.asarray(labels)
    cuts = [0, *(np.flatnonzero(names[1:] != names[:-1]) + 1).tolist(), len(names)]
    ends = np.append(t, t[-1])
    parts = [text(axis.a - 8, 15, "mode", class_="label", text_anchor="end")]
    for a, b in pairwise(cuts):
        x0, x1 = float(axis(ends[a])), float(axis(ends[b]))
        name = str(names[a])
        box = {"x": x0, "y": 3, "width": max(x1 - x0, 0.5), "height": 16}
        parts.append(tag("rect", fill=colours.get(name, "#888888"), **box))
        if x1 - x0 > 7 * len(name):
            parts.append(text((x0 + x1) / 2, 15, name, class_="onband", text_anchor="middle"))
    return "".join(parts)
