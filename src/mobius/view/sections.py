"""The figures of the report, section by section."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mobius.geometry import wrap_angle
from mobius.model.joints import JOINTS, LIMB_JOINTS
from mobius.stack import RunRecord
from mobius.types import LIMBS
from mobius.view.charts import Line, bars_chart, heat_chart, line_chart
from mobius.view.palette import MODE_COLOURS
from mobius.view.svg import number

__all__ = ["CONTACT_N", "contacts", "effort", "energy_J", "estimator", "velocities"]

Array = NDArray[np.float64]

CONTACT_N = 5.0
"""A limb stands when its normal force is above this [N]."""

_CLOSE_UP = 4.0
"""Length of the close-up [s]."""


def velocities(record: RunRecord, goal: Array) -> str:
    """Commanded, believed and true velocity per axis of the heading frame, and the way
    left to the goal (2,) [m] in M.
    """
    charts = []
    for k, (name, unit) in enumerate(
        [("Forward vx", "m/s"), ("Left vy", "m/s"), ("Turning wz", "rad/s")]
    ):
        lines = [
            Line("commanded", record.cmd_twist_H[:, k], "cmd"),
            Line("true", record.true_twist_H[:, k], "true"),
            Line("believed", record.belief_twist_H[:, k], "belief"),
        ]
        charts.append(line_chart(name, unit, record.t, lines))
    away = np.linalg.norm(record.true_p[:, :2] - goal, axis=1)
    charts.append(
        line_chart("Distance to the goal", "m", record.t, [Line("true", away, "true")], zero=True)
    )
    error = record.true_twist_H - record.cmd_twist_H
    mae = ", ".join(
        f"{number(float(e), digits=2)} {unit}"
        for e, unit in zip(np.nanmean(np.abs(error), axis=0), ("m/s", "m/s", "rad/s"), strict=True)
    )
    note = f"Heading frame: x forward, y left. Mean absolute tracking error (vx, vy, wz): {mae}."
    return _section("Velocity", note, charts)


def estimator(record: RunRecord) -> str:
    """Belief against truth."""
    off = np.linalg.norm(record.belief_p - record.true_p, axis=1)
    yaw = wrap_angle(record.belief_rpy[:, 2] - record.true_rpy[:, 2])
    roll, pitch = record.true_rpy[:, 0], record.true_rpy[:, 1]
    charts = [
        line_chart("Position error", "m", record.t, [Line("error", off, "c0")], zero=True),
        line_chart("Yaw error", "rad", record.t, [Line("error", yaw, "c0")]),
        line_chart(
            "Trunk height",
            "m",
            record.t,
            [
                Line("true", record.true_p[:, 2], "true"),
                Line("believed", record.belief_p[:, 2], "belief"),
            ],
        ),
        line_chart(
            "Trunk roll and pitch",
            "rad",
            record.t,
            [Line("roll", roll, "c0"), Line("pitch", pitch, "c1")],
        ),
    ]
    rms = np.sqrt(np.nanmean(off**2))
    note = (
        "Controllers and follower see the belief only. Root mean square error:"
        f" {number(float(rms), digits=2)} m,"
        f" {number(float(np.sqrt(np.nanmean(yaw**2))), digits=2)} rad."
    )
    return _section("Estimator", note, charts)


def contacts(record: RunRecord) -> str:
    """Gait diagram of the whole run, and a close-up of contacts and torques."""
    whole = _gait("Contacts, whole run", record, np.arange(len(record.t)))
    rows = close_up(record)
    charts = []
    for limb in LIMBS:
        part = LIMB_JOINTS[limb]
        side, kind = limb.split("_")
        lines = [
            Line(
                JOINTS[j].removeprefix(f"{side}_").replace("_", " "),
                record.torque[rows, j],
                f"c{j - part.start}",
            )
            for j in range(part.start, part.stop)
        ]
        charts.append(
            line_chart(f"{side.capitalize()} {kind} torque", "N m", record.t[rows], lines)
        )
    note = (
        f"Blue: normal force above {CONTACT_N:g} N. Thin orange: believed contact. Right:"
        " share of time on the ground, and how often the belief is right."
    )
    t0, t1 = record.t[rows[0]], record.t[rows[-1]]
    near = _gait(f"Contacts in close-up, {number(t0)} to {number(t1)} s", record, rows)
    return _section("Gait", note, charts, before=whole + near)


def effort(record: RunRecord) -> str:
    """Torque of all joints, power and energy."""
    rms = np.sqrt(np.nanmean(record.torque**2, axis=0))
    peak = np.nanmax(np.abs(record.torque), axis=0)
    track = np.sqrt(np.nanmean((record.q - record.q_target) ** 2, axis=0))
    remarks = [f"{a:5.2f}  {b:5.2f}  {c:6.3f}" for a, b, c in zip(rms, peak, track, strict=True)]
    field = heat_chart(
        "Joint torque, root mean square",
        "N m",
        record.t,
        np.abs(record.torque),
        [j.replace("_", " ") for j in JOINTS],
        remarks=remarks,
        heads="rms, peak [N m], lag [rad]",
    )
    charts = [
        line_chart(
            "Mechanical power", "W", record.t, [Line("power", record.power, "c1")], zero=True
        ),
        line_chart(
            "Energy so far", "J", record.t, [Line("energy", energy_J(record), "c0")], zero=True
        ),
    ]
    note = (
        f"Power is the sum of |torque \u00d7 rate|: mean"
        f" {number(float(np.nanmean(record.power)))} W, peak"
        f" {number(float(np.nanmax(record.power)))} W. Lag: root mean square of target minus"
        " joint angle."
    )
    return _section("Effort", note, charts, before=field)


def energy_J(record: RunRecord) -> Array:
    """(n,) integral of the power from the start [J], by trapezoids."""
    power = np.nan_to_num(record.power)
    steps = 0.5 * (power[1:] + power[:-1]) * np.diff(record.t)
    return np.concatenate([[0.0], np.cumsum(steps)])


def close_up(record: RunRecord) -> NDArray[np.int64]:
    """Rows of the four seconds around the middle of the time the robot was told to move."""
    moving = np.flatnonzero(np.abs(record.cmd_twist_H).max(axis=1) > 1e-3)
    middle = record.t[moving[len(moving) // 2]] if len(moving) else record.t[len(record.t) // 2]
    start = np.clip(middle - _CLOSE_UP / 2, record.t[0], max(record.t[0], record.t[-1] - _CLOSE_UP))
    rows = np.flatnonzero((record.t >= start) & (record.t <= start + _CLOSE_UP))
    return rows if len(rows) > 1 else np.arange(len(record.t))


def _gait(title: str, record: RunRecord, rows: NDArray[np.int64]) -> str:
    stands = record.contact_force[rows] > CONTACT_N
    believed = record.contact_belief[rows] > 0.5
    duty, right = stands.mean(axis=0), (stands == believed).mean(axis=0)
    lanes = [
        (
            limb.replace("_", " "),
            stands[:, k],
            believed[:, k],
            f"{100 * duty[k]:.0f} %, belief {100 * right[k]:.0f} %",
        )
        for k, limb in enumerate(LIMBS)
    ]
    strip = [record.modes[k] for k in rows]
    colours = {str(k): v for k, v in MODE_COLOURS.items()}
    return bars_chart(title, record.t[rows], lanes, strip=strip, colours=colours)


def _section(title: str, note: str, charts: list[str], *, before: str = "") -> str:
    return f'<h2>{title}</h2><p>{note}</p>{before}<div class="two">{"".join(charts)}</div>'
