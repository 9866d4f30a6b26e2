"""The windows of ``mobius replay``: time slider, map, and curves around the time shown."""

from __future__ import annotations

from typing import Any

import numpy as np
from mujoco.studio.dear_imgui import dear_imgui as imgui

from mobius.view.live.cockpit import PLOT_EVERY, Cockpit
from mobius.view.live.nouns import LIMBS_SHOWN
from mobius.view.live.plan_view import PlanView
from mobius.view.live.plots import SECONDS, TABS, Plots, Tabs
from mobius.view.live.studio import Window, Windows, bottom
from mobius.view.replay import Play, Player, Seek, plotted

STEPS = (("< 1 s", -60), ("< frame", -1), ("frame >", 1), ("1 s >", 60))
"""Buttons, and by how many rows (60 Hz) they move: times are rounded, rows are not."""
SPEEDS = (0.1, 0.25, 0.5, 1.0, 2.0, 4.0)
CURVES: Tabs = (
    TABS[0],
    (
        "power and contacts",
        (
            TABS[1][1][0],
            (
                "believed contact",
                "probability",
                tuple((name, 10 + k) for k, name in enumerate(LIMBS_SHOWN)),
            ),
            TABS[1][1][2],
        ),
    ),
)
"""A log holds believed contacts, no contact forces, and nothing of how time was kept."""


def windows_of(player: Player) -> type[Windows]:
    """The windows that show and move one player."""

    class ReplayWindows(Windows):
        def __init__(self, cockpit: Cockpit, app: Any, *, shadows: bool = True) -> None:
            super().__init__(cockpit, app, shadows=shadows)
            self._times, self._rows = plotted(player.run, PLOT_EVERY)
            plan, plots = PlanView(cockpit, live=False), Plots(cockpit, CURVES)
            self._all = (
                Window("Replay", self._controls, lambda w, h: (8.0, 30.0, 330.0, 330.0)),
                Window(
                    "Map",
                    lambda: plan.draw(self.viewer.upload_image, self._visited),
                    lambda w, h: (w - 428.0, 30.0, 420.0, 0.56 * h),
                ),
                Window("Plots", plots.draw, bottom),
            )

        def windows(self) -> tuple[Window, ...]:
            return self._all

        def before(self) -> None:
            """The curves of the seconds before the time shown."""
            first, last = np.searchsorted(self._times, [player.t - SECONDS, player.t + 1e-9])
            history = self.cockpit.history
            history.t = self._times[first:last].tolist()
            history.rows = self._rows[first:last].tolist()

        def _controls(self) -> None:
            run, s = player.run, self.cockpit.snapshot
            imgui.TextWrapped(str(run.path))
            imgui.SetNextItemWidth(-1.0)
            low, high = float(run.t[0]), float(run.t[-1])
            changed, t = imgui.SliderFloat("##time", player.t, low, high, "%.2f s")
            if changed:
                self.cockpit.ask(Seek(float(t)))  # type: ignore[arg-type]
            if imgui.Button("Pause" if player.playing else "Play"):
                self._ask(not player.playing, player.speed)
            for name, rows in STEPS:
                imgui.SameLine()
                if imgui.Button(name):
                    self._ask(False, player.speed)
                    self.cockpit.ask(Seek(player.beside(rows)))  # type: ignore[arg-type]
            for k, speed in enumerate(SPEEDS):
                if k:
                    imgui.SameLine()
                if imgui.RadioButton(f"{speed:g}x", speed == player.speed):
                    self._ask(player.playing, speed)
            if s is None:
                return
            imgui.SeparatorText("Robot")
            imgui.Text(f"mode: {s.mode or 'not recorded'}   power {s.power:.0f} W")
            for name, row in zip(("command", "belief", "truth"), s.twist, strict=True):
                imgui.Text(
                    f"{name:8s} vx {row[0]:+.2f}  vy {row[1]:+.2f} m/s  wz {row[2]:+.2f} rad/s"
                )
            off = float(np.linalg.norm(s.true_pose[:2] - s.believed_pose[:2]))
            imgui.Text(f"belief off by {off:.2f} m")

        def _ask(self, on: bool, speed: float) -> None:
            self.cockpit.ask(Play(on, speed))  # type: ignore[arg-type]

    return ReplayWindows
