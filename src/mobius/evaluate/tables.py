"""Results as rows: for a terminal and for CSV files."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Sequence
from dataclasses import asdict
from typing import Any

from mobius.evaluate.commands import AXES
from mobius.evaluate.motions import Series
from mobius.evaluate.push import Push
from mobius.evaluate.robustness import Robustness
from mobius.evaluate.terrain import Terrain
from mobius.evaluate.tracking import Tracking

Outcome = Tracking | Push | Terrain | Robustness
Table = list[list[Any]]
"""Rows of cells, the first of names."""
_NONE = [None] * 3


def tables(result: Outcome) -> dict[str, Table]:
    """Every table of a result by the name of its file."""
    if isinstance(result, Tracking):
        return {
            "commands": _commands(result),
            "segments": _segments(result),
            "runs": _records([_flat(r, without="segments") for r in result.runs]),
        }
    if isinstance(result, Push):
        return {"survival": _survival(result), "runs": _records([_flat(r) for r in result.runs])}
    if isinstance(result, Terrain):
        return {"kinds": _kinds(result), "runs": _records([_flat(r) for r in result.runs])}
    return {"sweeps": _sweeps(result), "runs": _records([_flat(r) for r in result.runs])}


def series_table(series: Sequence[Series]) -> Table:
    """Motions over time: target, actual, mean over a stride and its error, by component."""
    kinds = ("target", "actual", "mean", "error")
    rows: Table = [["motion", "t_s", *(f"{kind}_{axis}" for axis in AXES for kind in kinds)]]
    for s in series:
        for t, want, true, mean in zip(s.t, s.target, s.actual, s.smooth, strict=True):
            cells = [v for w, x, m in zip(want, true, mean, strict=True) for v in (w, x, m, m - w)]
            rows.append([s.name, round(float(t), 4), *(round(float(v), 5) for v in cells)])
    return rows


def as_csv(table: Table) -> str:
    """A table as comma-separated values; None is an empty cell."""
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows(table)
    return out.getvalue()


def _commands(result: Tracking) -> Table:
    vectors = ("target", "mean", "mae")
    rows: Table = [["command", *(f"{v}_{axis}" for v in vectors for axis in AXES)]]
    rows[0] += ["falls", "segments", "power_W", "slip_fraction"]
    for name, c in result.commands.items():
        cells = [x for v in vectors for x in (c[v] or _NONE)]
        rows.append([name, *cells, c["falls"], c["segments"], c["power_W"], c.get("slip_fraction")])
    return rows


def _segments(result: Tracking) -> Table:
    return _records([{"seed": r.seed, **_flat(s)} for r in result.runs for s in r.segments])


def _survival(result: Push) -> Table:
    columns = zip(result.magnitudes_mps, *result.survival.values(), strict=True)
    return [["magnitude_mps", *result.survival], *(list(row) for row in columns)]


def _kinds(result: Terrain) -> Table:
    rows: Table = [["kind", "survived", "episodes", "distance_m", *(f"mae_{a}" for a in AXES)]]
    for kind, k in result.kinds.items():
        rows.append([kind, k["survived"], k["episodes"], k["distance_m"], *k["mae"].values()])
    return rows


def _sweeps(result: Robustness) -> Table:
    rows: Table = [["sweep", "value", "survival", *(f"mae_{axis}" for axis in AXES)]]
    for name, s in result.sweeps.items():
        columns = zip(s["values"], s["survival"], *s["mae"].values(), strict=True)
        rows += [[name, *row] for row in columns]
    return rows


def _flat(record: Any, *, without: str = "") -> dict[str, Any]:
    """A record with a column for every component of a vector; longer lists in one cell."""
    flat: dict[str, Any] = {}
    for name, value in asdict(record).items():
        if name == without:
            continue
        if isinstance(value, list | tuple) and len(value) == len(AXES) and name not in _LISTS:
            flat.update({f"{name}_{a}": v for a, v in zip(AXES, value, strict=True)})
        elif value is None and name in _VECTORS:
            flat.update({f"{name}_{a}": None for a in AXES})
        elif isinstance(value, list | tuple):
            flat[name] = " ".join(f"{v:.4g}" for v in value)
        else:
            flat[name] = value
    return flat


_VECTORS = ("mean", "mae")
"""Vectors that may be missing."""
_LISTS = ("survived", "angles")
"""Lists of any length."""


def _records(records: Sequence[dict[str, Any]]) -> Table:
    return [list(records[0]), *(list(r.values()) for r in records)] if records else []


# -- for a terminal -----------------------------------------------------------------------


def as_text(result: Outcome) -> str:
    """A result as lines for a terminal."""
    writers: dict[type, Callable[[Any], list[str]]] = {
        Tracking: _tracking_lines,
        Push: _push_lines,
        Terrain: _terrain_lines,
        Robustness: _robustness_lines,
    }
    return "\n".join(writers[type(result)](result))


def _cell(value: float | None, digits: int = 3) -> str:
    return "-" if value is None else f"{value:.{digits}f}"


def _percent(share: float | None) -> str:
    return "-" if share is None else f"{100 * share:.1f} %"


def _tracking_lines(r: Tracking) -> list[str]:
    mae, raw = r.mae, r.mae_raw
    lines = [
        f"{r.episodes} episodes of 20 s from seed {r.seed}: {r.falls} falls",
        f"mean abs. error  vx {mae['vx']:.4f} vy {mae['vy']:.4f} m/s  wz {mae['wz']:.4f} rad/s",
        f"  unaveraged     vx {raw['vx']:.4f} vy {raw['vy']:.4f} m/s  wz {raw['wz']:.4f} rad/s",
        "",
        "command     n  falls   target vx     vy     wz     mean vx     vy     wz"
        "    error vx    vy    wz   power  height",
    ]
    for name, c in r.commands.items():
        if not c["segments"]:
            continue
        target, mean, error = (
            " ".join(f"{_cell(v, n):>6}" for v in (c[key] or _NONE))
            for key, n in (("target", 2), ("mean", 3), ("mae", 3))
        )
        power = _cell(c["power_W"], 1)
        lines.append(
            f"{name:10s} {c['segments']:3d} {c['falls']:5d}     {target}      {mean}"
            f"      {error} {power:>6} {_cell(c['height_error_m'], 3):>7}"
        )
    stand, peak = r.stand, max(r.torque_peak.items(), key=lambda item: item[1])
    return [
        *lines,
        "",
        f"slip {_percent(r.slip_fraction)} of the way, contacts below 0.05 s"
        f" {_percent(r.chatter_fraction)}, power {r.power_W:.1f} W",
        f"joints to {r.max_dq_rpm:.1f} rpm, torque to {_percent(peak[1])} of the servo's line"
        f" ({peak[0]}), over 95 % of stall in {_percent(r.saturation)} of joint-samples",
        f"trunk within {r.height_error_m:.3f} m of the stance's height, in 95 % of the episodes"
        f" within {r.height_error_p95_m:.3f} m; loops open at most {r.loop_residual_mm:.2f} mm",
        f"standing: joints {_cell(stand['joint_speed_rms'], 4)} rad/s rms,"
        f" {_cell(stand['foot_lifts_per_s'], 2)} lifts/s",
    ]


def _push_lines(r: Push) -> list[str]:
    head = "shove [m/s]  " + "".join(f"{m:6.1f}" for m in r.magnitudes_mps)
    rows = [
        f"{state:12s} " + "".join(f"{100 * share:5.0f}%" for share in shares)
        for state, shares in r.survival.items()
    ]
    return [f"{r.episodes} robots from seed {r.seed} shoved until they fell", head, *rows]


def _terrain_lines(r: Terrain) -> list[str]:
    lines = [f"{'ground':10s} survived   way [m]   error vx     vy     wz"]
    for kind, k in r.kinds.items():
        error = " ".join(f"{v:6.3f}" for v in k["mae"].values())
        lines.append(
            f"{kind:10s} {k['survived']:4d}/{k['episodes']:<4d} {k['distance_m']:8.2f}     {error}"
        )
    return lines


def _robustness_lines(r: Robustness) -> list[str]:
    lines = []
    for name, s in r.sweeps.items():
        low, high = s["usual"]
        lines += [
            f"{name}: {s['what']}; elsewhere {low:g} to {high:g}",
            "  value    " + "".join(f"{v:8g}" for v in s["values"]),
            "  survival " + "".join(f"{100 * v:7.0f}%" for v in s["survival"]),
            *(
                f"  error {axis} " + "".join(f"{v:8.3f}" for v in column)
                for axis, column in s["mae"].items()
            ),
        ]
    return lines
