"""The last twenty seconds as curves: twist, power, contacts, wrists, timing."""

from __future__ import annotations

from typing import Any

from mujoco.studio.dear_imgui import dear_imgui as imgui
from mujoco.studio.implot import implot

from mobius.view.live.cockpit import Cockpit
from mobius.view.live.nouns import LIMBS_SHOWN, History

SECONDS = 20.0
"""Width of every plot."""
Curves = tuple[tuple[str, int], ...]
Tabs = tuple[tuple[str, tuple[tuple[str, str, Curves], ...]], ...]
TABS: Tabs = (
    (
        "twist",
        (
            ("vx", "m/s", (("command", 0), ("belief", 3), ("truth", 6))),
            ("vy", "m/s", (("command", 1), ("belief", 4), ("truth", 7))),
            ("wz", "rad/s", (("command", 2), ("belief", 5), ("truth", 8))),
        ),
    ),
    (
        "power and forces",
        (
            ("power", "W", (("all servos", 9),)),
            ("contacts", "N", tuple((name, 10 + k) for k, name in enumerate(LIMBS_SHOWN))),
            ("wrists", "N", (("left force", 14), ("right force", 15))),
        ),
    ),
    (
        "timing",
        (
            ("real time", "%", (("kept", 16),)),
            ("300 Hz rounds", "ms", (("99 % done within", 17),)),
        ),
    ),
)
"""Tabs of plots: title, unit, and the curves by their column in the history."""


class Plots:
    """Draws the plots of the tab that is open."""

    def __init__(self, cockpit: Cockpit, tabs: Tabs = TABS) -> None:
        """Args: whose history; which plots."""
        self._cockpit, self._tabs = cockpit, tabs

    def draw(self) -> None:
        """The window's inside."""
        history = self._cockpit.history
        if not imgui.BeginTabBar("##plots"):
            return
        for name, plots in self._tabs:
            asked = self._cockpit.tab == name
            flags = imgui.TabItemFlags.SetSelected if asked else getattr(imgui.TabItemFlags, "None")
            self._cockpit.tab = "" if asked else self._cockpit.tab
            if imgui.BeginTabItem(name, int(flags)):
                room = imgui.GetContentRegionAvail()
                width = max(80.0, (room.x - 8.0 * (len(plots) - 1)) / len(plots))
                for k, (title, unit, curves) in enumerate(plots):
                    if k:
                        imgui.SameLine()
                    _plot(history, f"{title} [{unit}]", curves, width, max(room.y, 60.0))
                imgui.EndTabItem()
        imgui.EndTabBar()


def _plot(history: History, title: str, curves: Curves, width: float, height: float) -> None:
    flags = implot.Flags
    plain = int(flags.NoMouseText) | int(flags.NoMenus)
    if not implot.BeginPlot(title, imgui.Vec2(width, height), plain):
        return
    fit: Any = int(implot.AxisFlags.AutoFit)
    implot.SetupAxes("t [s]", "", 0, fit)
    end = history.t[-1] if history.t else SECONDS
    always = imgui.Cond.Always
    implot.SetupAxisLimits(int(implot.Axis.X1), end - SECONDS, end, always)
    beside = int(implot.LegendFlags.Horizontal) | int(implot.LegendFlags.Outside)
    implot.SetupLegend(int(implot.Location.North), beside)
    for name, column in curves:
        if history.t:
            implot.PlotLine(name, history.t, history.column(column))
    implot.EndPlot()
