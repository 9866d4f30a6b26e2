"""The report's section on modes: what each cost, how often they changed, falls, new plans."""

from __future__ import annotations

import html
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from mobius.stack import RunRecord
from mobius.view.palette import MODE_COLOURS
from mobius.view.svg import number, tag, text

__all__ = ["modes_section"]

_WIDTH, _ROW, _LEFT = 1000.0, 26.0, 90.0


def modes_section(record: RunRecord) -> str:
    """Tables and a strip of the modes over time; nothing for a run whose summary lacks them."""
    table = record.summary.get("modes")
    if not isinstance(table, dict) or not table:
        return ""
    parts = ["<h2>Modes</h2>", f"<p>{html.escape(_sentence(record.summary))}</p>"]
    if len(table) > 1:
        parts.append(_strip(record))
    parts.append(_table(table))
    forced = record.summary.get("forced_modes") or {}
    if forced:
        parts.append(_forced(forced))
    replans = record.summary.get("replans") or []
    if replans:
        parts.append(_replans(replans))
    return "".join(parts)


def _sentence(summary: dict[str, Any]) -> str:
    """Switches, falls and rolls in words."""
    says = []
    switches = summary.get("mode_switches")
    if isinstance(switches, dict):
        says.append(
            f"{switches['driven']} changes between biped, crawl and roll"
            f" ({number(switches['driven_per_step'])} per step of the plan; planned"
            f" {switches['planned']}, {number(switches['planned_per_step'])} per step)."
        )
    falls, up = summary.get("falls", 0), summary.get("recoveries", 0)
    says.append(f"{falls or 'No'} falls" + (f", {up} recovered." if falls else "."))
    if summary.get("rolls") or summary.get("rolls_without_room"):
        says.append(
            f"{summary['rolls']} rolls, {summary.get('rolls_without_room', 0)} left out for want"
            " of room."
        )
    if summary.get("motions_failed"):
        says.append(f"{summary['motions_failed']} motions did not come about when asked for.")
    return " ".join(says)


def _strip(record: RunRecord) -> str:
    """Which mode the robot was in, over time."""
    modes, t = record.modes, record.t
    span = max(float(t[-1] - t[0]), 1e-9)
    scale = (_WIDTH - _LEFT) / span
    edges = [0, *(k for k in range(1, len(modes)) if modes[k] != modes[k - 1]), len(modes)]
    bars = []
    for a, b in pairwise(edges):
        end = t[b] if b < len(t) else t[-1]
        colour = MODE_COLOURS.get(modes[a], "#777777")
        x, width = _LEFT + (t[a] - t[0]) * scale, max((end - t[a]) * scale, 1.0)
        bars.append(tag("rect", x=float(x), y=4, width=float(width), height=_ROW - 8, fill=colour))
    label = text(0, _ROW - 9, "mode", class_="tick")
    ends = text(_LEFT, _ROW + 10, "0 s", class_="tick") + text(
        _WIDTH, _ROW + 10, f"{span:.0f} s", class_="tick", text_anchor="end"
    )
    keys = "".join(
        f'<span><i style="background:{MODE_COLOURS.get(m, "#777777")}"></i>'
        f"{html.escape(m.replace('_', ' '))}</span>"
        for m in dict.fromkeys(modes)
    )
    picture = tag(
        "svg",
        label + "".join(bars) + ends,
        viewBox=f"0 0 {_WIDTH:.0f} {_ROW + 16:.0f}",
        class_="wide",
        role="img",
        aria_label="Mode over time",
    )
    return (
        f'<figure><figcaption><span>Mode the robot was in</span><span class="keys">{keys}</span>'
        f"</figcaption>{picture}</figure>"
    )


def _table(table: dict[str, dict[str, Any]]) -> str:
    """A row a mode."""
    heads = ("mode", "time", "way", "energy", "cells", "per metre", "per cell", "mean power")
    rows = []
    for name, row in table.items():
        power = row["energy_J"] / row["time_s"] if row["time_s"] else None
        cells = (
            name.replace("_", " "),
            _with(row["time_s"], "s"),
            _with(row["path_m"], "m"),
            _with(row["energy_J"], "J"),
            str(row["cells"]),
            _with(row["J_per_m"], "J/m"),
            _with(row["J_per_cell"], "J"),
            _with(power, "W"),
        )
        rows.append(cells)
    return _rows("Energy per mode, from joint power", heads, rows)


def _forced(forced: dict[str, dict[str, Any]]) -> str:
    heads = ("forced mode", "cells of the plan", "time in such cells", "in that mode", "used")
    rows = [
        (
            name,
            str(f["planned"]),
            _with(f["time_s"], "s"),
            f"{100 * f['share']:.0f} %",
            "yes" if f["used"] else "no",
        )
        for name, f in forced.items()
    ]
    return _rows("Modes that the map forces", heads, rows)


def _replans(replans: list[dict[str, Any]]) -> str:
    heads = ("new plan at", "because of", "status", "search")
    rows = [
        (_with(r["t"], "s"), r["why"], r["problem"] or r["status"], _with(r["solve_ms"], "ms"))
        for r in replans
    ]
    return _rows("Plans made on the way", heads, rows)


def _rows(title: str, heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    head = "".join(f"<th>{html.escape(h)}</th>" for h in heads)
    body = "".join(
        "<tr>" + "".join(f"<td>{html.escape(str(c))}</td>" for c in row) + "</tr>" for row in rows
    )
    return (
        f"<figure><figcaption>{html.escape(title)}</figcaption>"
        f"<table><tr>{head}</tr>{body}</table></figure>"
    )


def _with(value: float | None, unit: str) -> str:
    if value is None or not np.isfinite(value):
        return "\u2013"
    return f"{number(float(value))} {unit}"
