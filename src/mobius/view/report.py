"""``report.html`` of a run: one file that needs nothing else, for reading on any screen."""

from __future__ import annotations

import html
import json
from collections.abc import Sequence
from pathlib import Path
from string import Template
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.errors import InvalidInput
from mobius.files import write_text_atomic
from mobius.stack import RunRecord
from mobius.types import Plan
from mobius.view.floor_map import Occupancy, floor_map
from mobius.view.modes import modes_section
from mobius.view.sections import contacts, effort, estimator, velocities
from mobius.view.svg import jpeg_data, number

__all__ = ["Occupancy", "build_report", "verdict", "write_report"]

_PAGE = Path(__file__).with_name("report_page.html")

_TILES = (
    ("final_distance_m", "left to the goal", "m"),
    ("sim_time_s", "simulated", "s"),
    ("path_length_m", "path gone", "m"),
    ("falls", "falls", ""),
    ("collisions", "wall contacts", ""),
    ("energy_J", "mechanical energy", "J"),
    ("energy_per_cell_J", "energy per cell", "J"),
    ("real_time_factor", "of real time", "\u00d7"),
)

_UNITS = {
    "m": "m",
    "mm": "mm",
    "s": "s",
    "ms": "ms",
    "J": "J",
    "rad": "rad",
    "mps": "m/s",
    "W": "W",
}


def write_report(path: str | Path, record: RunRecord, **options: Any) -> None:
    """Write :func:`build_report` to ``path``, whole or not at all."""
    write_text_atomic(path, build_report(record, **options))


def build_report(
    record: RunRecord,
    *,
    title: str | None = None,
    goal: ArrayLike | None = None,
    occupancy: Occupancy | None = None,
    later: Sequence[Plan] = (),
    still: NDArray[np.uint8] | None = None,
    files: Sequence[str] = (),
) -> str:
    """The report as HTML, with no reference to anything outside itself but ``files``.

    Args:
        record: The run, at least two samples; what its summary lacks is shown as such.
        title: Heading; the map's name by default.
        goal: (2,) [m] in M; the map's goal or the plan's last cell by default.
        occupancy: Walls and obstacles, drawn beneath the planner's cells.
        later: Plans made on the way.
        still: (h, w, 3) a picture of the robot, shown beside the figures.
        files: Names of files beside the report to link to.

    Raises:
        InvalidInput: The record holds fewer than two samples.
    """
    if len(record.t) < 2:
        raise InvalidInput(f"report: expected a run of two samples or more, got {len(record.t)}")
    heading = title or f"MOBIUS on {record.summary.get('map', Path(record.grid.name).name)}"
    good, sentence = verdict(record.summary)
    where = _goal(record, goal)
    figure = floor_map(
        record.grid,
        record.plan,
        record.true_p[:, :2],
        record.belief_p[:, :2],
        goal=where,
        occupancy=occupancy,
        modes=record.modes,
        later=later,
    )
    parts = [
        f"<h1>{html.escape(heading)}</h1>",
        f'<p class="sub">{html.escape(_subtitle(record))}</p>',
        f'<p class="verdict {"good" if good else "bad"}">{html.escape(sentence)}</p>',
        _tiles(record.summary),
        "<h2>Way</h2>",
        "<p>The plan in the colours of its modes; on it the way the trunk really went, in"
        " those colours too where the robot was in several, and"
        " dashed the way the robot believed. Point at a curve further down to read values"
        " there and to see the robot here at that time.</p>",
        figure,
        modes_section(record),
        _still(still),
        velocities(record, where),
        estimator(record),
        contacts(record),
        effort(record),
        _numbers(record.summary, files),
    ]
    return Template(_PAGE.read_text(encoding="utf-8")).substitute(
        title=html.escape(heading), body="\n".join(parts), track=_track(record)
    )


def _goal(record: RunRecord, goal: ArrayLike | None) -> NDArray[np.float64]:
    """(2,) [m] in M: the one given, else the map's, else the end of the plan or of the run."""
    for candidate in (goal, record.grid.goal, *record.plan.xy_M[-1:]):
        if candidate is not None:
            return np.asarray(candidate, dtype=float)[:2]
    return record.true_p[-1, :2]


def verdict(summary: dict[str, Any]) -> tuple[bool, str]:
    """Whether the run went well, and one sentence that says how."""
    missing = [k for k in ("goal_reached", "falls", "final_distance_m") if k not in summary]
    if missing:
        return False, f"The run left no verdict: its summary lacks {', '.join(missing)}."
    falls, hits = int(summary["falls"]), int(summary.get("collisions", 0))
    reached = bool(summary["goal_reached"])
    distance = f"{number(float(summary['final_distance_m']), digits=2)} m"
    took = f" after {number(float(summary['sim_time_s']))} s" if "sim_time_s" in summary else ""
    gone = (
        f" and {number(float(summary['path_length_m']))} m of path"
        if "path_length_m" in summary
        else ""
    )
    fell = f"{falls or 'no'} fall{'' if falls == 1 else 's'}"
    hit = f"{hits or 'no'} wall contact{'' if hits == 1 else 's'}"
    lead = (
        f"Reached the goal, {distance} from it"
        if reached
        else f"Did not reach the goal: {distance} short"
    )
    return reached and falls == 0, f"{lead}{took}{gone}, with {fell} and {hit}."


def _subtitle(record: RunRecord) -> str:
    cells = f"{record.grid.shape[0]} \u00d7 {record.grid.shape[1]} cells of {record.grid.cell:g} m"
    plan = record.plan
    proof = {
        "optimal": "proven optimal",
        "feasible": f"within {number(plan.gap)} of the best possible",
        "infeasible": "infeasible",
    }[plan.status]
    steps = f"plan of {len(plan.modes)} steps, {proof}, found in {number(1e3 * plan.solve_s)} ms"
    return f"{cells}; {steps}; seed {record.summary.get('seed', 'not recorded')}"


def _tiles(summary: dict[str, Any]) -> str:
    rows = []
    for key, label, unit in _TILES:
        shown = number(summary[key]) if key in summary else "\u2013"
        small = f" <small>{unit}</small>" if unit and key in summary else ""
        rows.append(
            f'<div class="tile"><b>{html.escape(shown)}{small}</b><span>{label}</span></div>'
        )
    return f'<div class="tiles">{"".join(rows)}</div>'


def _still(still: NDArray[np.uint8] | None) -> str:
    if still is None:
        return ""
    return f'<figure><img src="{jpeg_data(still)}" alt="The robot on its way"></figure>'


def _numbers(summary: dict[str, Any], files: Sequence[str]) -> str:
    rows = "".join(
        f"<tr><th>{html.escape(name)}</th><td>{html.escape(value)}</td></tr>"
        for name, value in _flat(summary)
    )
    links = ", ".join(f'<a href="{html.escape(f)}">{html.escape(f)}</a>' for f in files)
    beside = f"<p>Beside this report: {links}.</p>" if files else "<p>As in summary.json.</p>"
    return f"<h2>All numbers</h2>{beside}<figure><table>{rows}</table></figure>"


def _flat(value: dict[str, Any], prefix: str = "") -> list[tuple[str, str]]:
    """Names and readable values; the unit is read off the end of the name."""
    rows = []
    for key, item in value.items():
        if isinstance(item, dict):
            rows += _flat(item, f"{prefix}{key} ")
            continue
        name, _, end = key.rpartition("_")
        known = bool(name) and end in _UNITS
        label = (name if known else key).replace("_", " ")
        items = item if isinstance(item, list | tuple) else [item]
        shown = ", ".join(number(v) for v in items)
        rows.append((f"{prefix}{label}", f"{shown} {_UNITS[end]}" if known else shown))
    return rows


def _track(record: RunRecord) -> str:
    """Time, true x, y, yaw, believed x, y for the moving arrow: at most 1000 rows."""
    step = max(1, -(-len(record.t) // 1000))
    rows = np.column_stack(
        [record.t, record.true_p[:, :2], record.true_rpy[:, 2], record.belief_p[:, :2]]
    )[::step]
    rows = rows[np.isfinite(rows).all(axis=1)]
    return json.dumps(np.round(rows, 3).tolist(), separators=(",", ":"))
