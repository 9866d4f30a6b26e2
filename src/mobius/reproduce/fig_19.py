"""Fig. 19: position and velocity with and without a governor, violations marked.

``python -m mobius.reproduce.fig_19 [--out FILE.png]``. As in the paper the wrench reference is
zero, the reference jumps beyond the limits at 0 and 2.5 s and is admissible from 10 to 17.5 s;
its shape is read off the figure, gains and limits are ours. No force acts from outside.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from mobius import paper
from mobius.control.governor import (
    AXES,
    AdmissibleSet,
    Axis,
    NearestGovernor,
    ScalarGovernor,
    algorithm_3,
    axis_set,
    axis_system,
)
from mobius.errors import MobiusError
from mobius.reproduce.common import as_text, write_out
from mobius.view.png import save_png

__all__ = ["Response", "draw", "experiment", "reference"]

Array = NDArray[np.float64]

SECONDS = 20.0
K_ENV = 100.0
"""Contact stiffness of the experiment [N/m]."""
_COLOURS = {"none": "#d9a227", "algorithm_3_repaired": "#2f9e6e", "exact": "#c0392b"}
_WISH, _GIVEN, _LIMIT = "#2f9e6e", "#2a7fd4", "#8a8f98"


@dataclass(frozen=True, eq=False)
class Response:
    """One run; t ticks."""

    t: Array
    wish: Array
    """x_ref as asked for [m]."""
    x_ref: Array
    """As given to the loop [m]."""
    x_s: Array
    """[m]."""
    v: Array
    """[m/s]."""
    broken: NDArray[np.bool_]
    """Whether position or velocity is beyond its limit."""


def reference(axis: Axis, t: Array) -> Array:
    """x_ref [m] over the time t [s]."""
    span = paper.GOVERNOR.unmodified
    high = 1.3 * axis.position_max
    x = np.where(t < paper.GOVERNOR.violations_without[1], high, -high)
    x = np.where(t >= 5.0, high * np.cos(2.0 * np.pi * (t - 5.0) / 5.0), x)
    gentle = 0.4 * axis.position_max * np.sin(2.0 * np.pi * (t - span[0]) / (span[1] - span[0]))
    x = np.where((t >= span[0]) & (t < span[1]), gentle, x)
    return np.where(t >= span[1], high, x)


def experiment(axis: Axis, rows: AdmissibleSet) -> dict[str, Response]:
    """The runs without a governor, with Algorithm 3 repaired, and with the exact set."""
    governors: dict[str, Any] = {
        "none": None,
        "algorithm_3_repaired": NearestGovernor(algorithm_3(axis, repaired=True)),
        "exact": ScalarGovernor(rows),
    }
    loop = axis_system(axis, K_ENV)
    t: Array = axis.dt * np.arange(round(SECONDS / axis.dt), dtype=float)
    wish = reference(axis, t)
    runs = {}
    for name, governor in governors.items():
        x, given, states = np.zeros(4), np.empty(len(t)), np.empty((len(t), 4))
        for k in range(len(t)):
            v = np.array([wish[k], 0.0])
            if name == "exact":
                v = governor.step(x, v)
            elif governor is not None:
                v = governor.step([x[3], x[1], -K_ENV * x[3]], v)
            given[k], states[k] = v[0], x
            x = loop.step(x, v)
        broken = (np.abs(states[:, 3]) > axis.position_max + 1e-9) | (
            np.abs(states[:, 1]) > axis.velocity_max + 1e-9
        )
        runs[name] = Response(t, wish, given, states[:, 3], states[:, 1], broken)
    return runs


def draw(path: Path, axis: Axis, runs: dict[str, Response]) -> None:
    """Position above, velocity below.

    Args:
        path: A ``.png``.
        axis: Limits.
        runs: Of :func:`experiment`.
    """
    figure = Figure(figsize=(9.5, 6.5), layout="constrained")
    top, low = figure.subplots(2, 1, sharex=True)
    exact = runs["exact"]
    top.plot(exact.t, exact.wish, "--", color=_WISH, lw=1.2, label="reference as asked for")
    top.plot(exact.t, exact.x_ref, color=_GIVEN, lw=1.2, label="reference of the governor")
    for at, what in ((top, "x_s"), (low, "v")):
        for name, colour in _COLOURS.items():
            if name == "algorithm_3_repaired":
                continue
            y = getattr(runs[name], what)
            label = "with governor" if name == "exact" else "without"
            at.plot(exact.t, y, color=colour, lw=1.4, label=label)
            _mark(at, exact.t, y, axis.position_max if what == "x_s" else axis.velocity_max, colour)
    for at, limit, unit in (
        (top, axis.position_max, "position [m]"),
        (low, axis.velocity_max, "velocity [m/s]"),
    ):
        for sign in (-1, 1):
            at.axhline(sign * limit, color=_LIMIT, ls="--", lw=1.0)
        at.set_ylabel(unit)
        at.spines[["top", "right"]].set_visible(False)
    top.legend(fontsize=8, ncols=2, frameon=False, loc="lower right")
    low.set_xlabel("time [s]")
    figure.suptitle("Thick: limit broken. Grey: limits. Axis x, contact 100 N/m")
    save_png(path, figure, dpi=110, what="Fig. 19")


def _mark(at: Axes, t: Array, y: Array, limit: float, colour: str) -> None:
    """Thicken a curve where it breaks its limit."""
    beyond = np.where(np.abs(y) > limit + 1e-9, y, np.nan)
    at.plot(t, beyond, color=colour, lw=4.0, alpha=0.6)


def main() -> None:
    """Run, draw, and print violations."""
    parser = argparse.ArgumentParser(
        prog="python -m mobius.reproduce.fig_19", description="Fig. 19"
    )
    parser.add_argument("--out", type=Path, default=Path("fig_19.png"), help="the .png to write")
    options = parser.parse_args()
    try:
        axis = AXES[0]
        runs = experiment(axis, axis_set(axis))
    except MobiusError as error:
        sys.exit(f"fig_19: {error}")
    low, high = paper.GOVERNOR.unmodified
    span = (runs["exact"].t >= low + 0.5) & (runs["exact"].t < high)
    table = [
        {
            "governor": name,
            "steps broken": int(r.broken.sum()),
            "largest |x| m": round(float(np.abs(r.x_s).max()), 4),
            "largest |v| m/s": round(float(np.abs(r.v).max()), 4),
            "reference unchanged 10.5-17.5 s": round(float((r.x_ref == r.wish)[span].mean()), 3),
        }
        for name, r in runs.items()
    ]
    print(as_text(table))
    write_out("fig_19", lambda: draw(options.out, axis, runs), options.out)


if __name__ == "__main__":
    main()
