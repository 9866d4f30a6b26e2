"""A tuning run over time: the force with and without the tuner, and the gains."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator
from numpy.typing import NDArray

from mobius.view.png import save_png

__all__ = ["Curve", "draw_tuning"]

Array = NDArray[np.float64]

_INK, _WISH = "#1d2126", "#8a8f98"
_COLOURS = ("#c0392b", "#2a7fd4", "#2f9e6e", "#d9772b", "#a05ac8")


@dataclass(frozen=True, eq=False)
class Curve:
    """One force over time."""

    name: str
    t: Array
    """(n,) [s]."""
    force: Array
    """(n,) [N]."""


def draw_tuning(
    path: str | Path,
    *,
    curves: Sequence[Curve],
    wished: Curve,
    t: Sequence[float],
    gains: Mapping[str, Sequence[float]],
    rmse: Sequence[float],
    title: str,
) -> None:
    """Write a picture of a run.

    Args:
        path: A ``.png``; written whole or not at all.
        curves: Forces to compare, drawn in order.
        wished: The wish.
        t: Moments of the measurements [s].
        gains: Each gain at those moments.
        rmse: Force error over each window [N].
        title: What was held.
    """
    figure = Figure(figsize=(11.0, 6.4), layout="constrained")
    force, error, gain = figure.subplots(3, 1, sharex=True, height_ratios=(2.2, 1.0, 1.4))
    for colour, curve in zip(_COLOURS, curves, strict=False):
        force.plot(curve.t, curve.force, color=colour, lw=0.9, label=curve.name)
    force.plot(wished.t, wished.force, color=_INK, lw=1.2, ls="--", label=wished.name)
    force.set_ylabel("force [N]")
    force.set_title(title, loc="left", fontsize=11)
    error.plot(t, rmse, color=_INK, marker="o", ms=2.5, lw=1.0)
    error.set_ylabel("error, rms\nof a window [N]")
    for colour, (name, values) in zip(_COLOURS, gains.items(), strict=False):
        relative = np.asarray(values) / values[0]
        gain.plot(t, relative, color=colour, lw=1.4, label=name, drawstyle="steps-post")
    gain.set_yscale("log")
    gain.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    gain.yaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
    gain.yaxis.set_minor_locator(NullLocator())
    gain.set_ylabel("gain / first")
    gain.set_xlabel("time [s]")
    force.legend(frameon=False, fontsize=8, ncols=3, loc="upper left")
    gain.legend(frameon=False, fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))
    for axes in (force, error, gain):
        axes.spines[["top", "right"]].set_visible(False)
        axes.grid(color="#dcdfe3", lw=0.6)
        axes.set_axisbelow(True)
    save_png(path, figure, dpi=100, what="a tuning run")
