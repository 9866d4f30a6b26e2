"""Pictures of results; PNG, drawn without a display."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mobius.evaluate.commands import AXES
from mobius.evaluate.motions import Series
from mobius.evaluate.push import Push
from mobius.evaluate.robustness import Robustness
from mobius.evaluate.terrain import Terrain

UNITS = {"vx": "m/s", "vy": "m/s", "wz": "rad/s"}
_TARGET, _ACTUAL, _ERROR, _SECOND = "#2f9e6e", "#2a7fd4", "#8a8f98", "#d9772b"
_STATES = {"stand": _ACTUAL, "walk": _SECOND}


def draw_tracking(path: Path, body: str, series: Sequence[Series]) -> None:
    """Target, actual velocity and error by component and motion, as in Fig. 17."""
    figure = Figure(figsize=(3.4 * len(series), 7.0), layout="constrained")
    grid = figure.subplots(len(AXES), len(series), sharex=True, sharey="row", squeeze=False)
    for column, s in enumerate(series):
        for row, axis in enumerate(AXES):
            at = grid[row, column]
            target, mean = s.target[:, row], s.smooth[:, row]
            at.plot(s.t, s.actual[:, row], color=_ACTUAL, lw=0.6, alpha=0.35)
            at.plot(s.t, mean, color=_ACTUAL, lw=1.6, label="actual, mean over a stride")
            at.plot(s.t, target, color=_TARGET, lw=1.6, ls="--", label="target")
            at.plot(s.t, mean - target, color=_ERROR, lw=1.0, label="error")
            _tidy(at, ylabel=f"{axis} [{UNITS[axis]}]" if column == 0 else "")
        grid[0, column].set_title(s.name)
        grid[-1, column].set_xlabel("time [s]")
    grid[0, 0].legend(loc="best", fontsize="small", frameon=False)
    figure.suptitle(f"{body}: velocity tracking in the whole stack")
    figure.savefig(path, dpi=120)


def draw_push(path: Path, result: Push) -> None:
    """Share of robots that stand or walk on, over the size of the shove, as in Fig. 16."""
    figure = Figure(figsize=(6.4, 4.0), layout="constrained")
    at = figure.subplots()
    for state, shares in result.survival.items():
        values = [100.0, *(100.0 * v for v in shares)]
        at.plot([0.0, *result.magnitudes_mps], values, "o-", color=_STATES[state], label=state)
    _tidy(at, ylabel="survived [%]")
    at.set_xlabel("shove of 0.1 s, change of velocity [m/s]")
    at.set_ylim(-2, 104)
    at.legend(frameon=False)
    at.set_title(f"{result.body}: {result.episodes // 2} robots a state, random directions")
    figure.savefig(path, dpi=120)


def draw_terrain(path: Path, result: Terrain) -> None:
    """Share of episodes without a fall on every kind of ground."""
    figure = Figure(figsize=(6.4, 3.6), layout="constrained")
    at = figure.subplots()
    shares = [100.0 * k["survived"] / k["episodes"] for k in result.kinds.values()]
    bars = at.bar(list(result.kinds), shares, color=_ACTUAL, width=0.6)
    at.bar_label(bars, [f"{k['survived']}/{k['episodes']}" for k in result.kinds.values()])
    _tidy(at, ylabel="20 s without a fall [%]")
    at.set_ylim(0, 112)
    at.set_title(f"{result.body}: other ground")
    figure.savefig(path, dpi=120)


def draw_robustness(path: Path, result: Robustness) -> None:
    """Survival and errors over each property; the range that is drawn elsewhere is shaded."""
    names = list(result.sweeps)
    figure = Figure(figsize=(3.2 * len(names), 6.0), layout="constrained")
    grid = figure.subplots(2, len(names), squeeze=False, sharex="col", sharey="row")
    for column, name in enumerate(names):
        s = result.sweeps[name]
        top, low = grid[0, column], grid[1, column]
        top.plot(s["values"], 100.0 * np.array(s["survival"]), "o-", color=_ACTUAL)
        for axis, colour in zip(AXES, (_ACTUAL, _TARGET, _SECOND), strict=True):
            label = f"{axis} [{UNITS[axis]}]"
            low.plot(s["values"], s["mae"][axis], "o-", ms=3, color=colour, label=label)
        for at in (top, low):
            at.axvspan(*s["usual"], color=_ERROR, alpha=0.15, lw=0)
        _tidy(top, ylabel="survived [%]" if column == 0 else "")
        _tidy(low, ylabel="mean abs. error" if column == 0 else "")
        top.set_title(name)
        low.set_xlabel(s["what"])
    grid[0, 0].set_ylim(-2, 104)
    grid[1, 0].legend(fontsize="small", frameon=False)
    figure.suptitle(f"{result.body}: one property changed, the rest nominal")
    figure.savefig(path, dpi=120)


def _tidy(at: Axes, *, ylabel: str) -> None:
    at.set_ylabel(ylabel)
    at.grid(alpha=0.25)
    at.set_axisbelow(True)
    at.spines[["top", "right"]].set_visible(False)
