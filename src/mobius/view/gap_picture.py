"""How a search closed in on the optimum: best plan and bound over time, the gap in between."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator
from numpy.typing import NDArray

from mobius.errors import InvalidInput
from mobius.types import Plan
from mobius.view.png import save_png

__all__ = ["draw_gap"]

Moment = tuple[float, float, float]
"""Seconds since the search began, best objective (-inf without a plan), bound [points]."""

_PLAN, _BOUND, _GAP = "#2a7fd4", "#d9772b", "#f4d35e"
_DPI = 110
_EARLIEST = 1e-3
"""Left end of the time axis [s], at most; nothing of interest happens before."""


def draw_gap(path: str | Path, trace: Sequence[Moment], plan: Plan, *, title: str = "") -> None:
    """Write a picture of a search.

    Args:
        path: A ``.png``; written whole or not at all.
        trace: What ``solve(..., on_progress=lambda *m: trace.append(m))`` told, in order; at
            least one moment.
        plan: What the search returned, at ``plan.solve_s``.
        title: What was solved.
    """
    if not trace:
        raise InvalidInput("the search told nothing; pass on_progress to solve() and draw that")
    told = np.array([*trace, (plan.solve_s, plan.objective, plan.bound)], dtype=float)
    t = np.maximum(told[:, 0], _EARLIEST)
    figure = Figure(figsize=(7.2, 4.2), layout="constrained")
    axes = figure.subplots()
    _curves(axes, t, told[:, 1], told[:, 2])
    _frame(axes, t, told[:, 1:])
    axes.set_title(f"{title}: {_verdict(plan)}" if title else _verdict(plan), fontsize=11)
    save_png(path, figure, dpi=_DPI, what="the gap over time")


def _verdict(plan: Plan) -> str:
    """What is known at the end."""
    if plan.status == "optimal":
        return f"{plan.objective:g} points, proven optimal after {_time(plan.solve_s)}"
    if plan.status == "infeasible":
        return f"no plan exists, proven after {_time(plan.solve_s)}"
    share = 100.0 * plan.gap / max(abs(plan.objective), 1e-9)
    return (
        f"{plan.objective:g} points, gap {plan.gap:.3g} ({share:.2g} %) after {_time(plan.solve_s)}"
    )


def _curves(
    axes: Axes, t: NDArray[np.float64], best: NDArray[np.float64], bound: NDArray[np.float64]
) -> None:
    """Two staircases and what lies between them."""
    has = np.isfinite(best)
    look: dict[str, Any] = {"lw": 1.8, "drawstyle": "steps-post", "marker": "o", "ms": 3.5}
    axes.plot(t, bound, color=_BOUND, label="bound on every plan", **look)
    if has.any():
        axes.fill_between(
            t[has], best[has], bound[has], step="post", color=_GAP, alpha=0.45, lw=0, label="gap"
        )
        axes.plot(t[has], best[has], color=_PLAN, label="best plan", **look)


def _frame(axes: Axes, t: NDArray[np.float64], values: NDArray[np.float64]) -> None:
    """Axes: time in decades where it spans more than one, else from zero."""
    if t[-1] > 10 * t[0]:
        axes.set_xscale("log")
        axes.set_xlim(0.9 * t[0], 1.1 * t[-1])
        axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    else:
        axes.set_xlim(0.0, 1.1 * t[-1])
    axes.xaxis.set_major_formatter(FuncFormatter(lambda v, _: _time(v)))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.set_xlabel("time since the search began")
    finite = values[np.isfinite(values)]
    room = max(0.08 * float(np.ptp(finite)), 0.03 * float(np.abs(finite).max()), 0.5)
    axes.set_ylim(finite.min() - room, finite.max() + room)
    axes.ticklabel_format(axis="y", style="plain", useOffset=False)
    axes.set_ylabel("objective [points], higher is better")
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(color="#dcdfe3", lw=0.6)
    axes.set_axisbelow(True)
    axes.legend(loc="best", frameon=False, fontsize=10)


def _time(seconds: float) -> str:
    return f"{seconds:.3g} s" if seconds >= 1.0 else f"{1e3 * seconds:.3g} ms"
