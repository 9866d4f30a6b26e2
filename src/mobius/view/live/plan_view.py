"""The map from above: click a start and a goal, plan, go."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from mujoco.studio.dear_imgui import dear_imgui as imgui
from numpy.typing import NDArray

from mobius.view.live.cockpit import Cockpit
from mobius.view.live.nouns import Go, LoadMap, MakePlan, Place, Scene, Snapshot, Wait, Way
from mobius.view.live.visited import CELL, Visited
from mobius.view.palette import MODE_COLOURS, rgb

Array = NDArray[np.float64]

CHOICES = ("crawl", "biped", "roll")
"""Modes that a plan may use; crawl always."""
TRUE_INK, BELIEF_INK = (0.10, 0.10, 0.12, 1.0), (0.80, 0.10, 0.55, 1.0)
GOAL_INK, START_INK, SEEN_INK = (0.82, 0.16, 0.16, 1.0), (0.1, 0.5, 0.2, 1.0), (1.0, 0.8, 0.1, 0.35)
Upload = Callable[[int, bytes, int, int, int], int]


class PlanView:
    """Draws the map with plan, coverage and poses."""

    def __init__(self, cockpit: Cockpit, *, live: bool = True) -> None:
        """Args: what is shown; whether the robot can be told anything."""
        self._cockpit, self._live = cockpit, live
        self._picture, self._scene = 0, 0
        self._set_start = False
        self._modes = {"biped": False, "roll": False}
        self._goal = [0.0, 0.0]

    def draw(self, upload: Upload, visited: Visited) -> None:
        """The window's inside; ``upload`` puts a picture into the viewer."""
        scene, s = self._cockpit.scene, self._cockpit.snapshot
        if scene is None:
            imgui.TextDisabled("waiting for a map")
            return
        if scene.number != self._scene:
            self._show(scene, upload)
        if self._live:
            self._choose(scene)
        scale, corner = self._map(scene)
        self._marks(scene, s, visited, scale, corner)
        if self._live:
            self._buttons(s)
        self._legend()

    def _show(self, scene: Scene, upload: Upload) -> None:
        """Another map."""
        self._scene = scene.number
        h, w = scene.picture.shape[:2]
        opaque = np.full((h, w, 1), 255, np.uint8)
        data = np.concatenate([scene.picture, opaque], axis=2).tobytes()
        self._picture = upload(self._picture, data, w, h, 4)
        if scene.goal is not None:
            self._goal = list(scene.goal)

    def _choose(self, scene: Scene) -> None:
        names = [*scene.maps] if scene.map in scene.maps else [scene.map, *scene.maps]
        imgui.SetNextItemWidth(160.0)
        changed, k = imgui.Combo("map", names.index(scene.map), names)
        if changed and names[k] in scene.maps:
            self._cockpit.ask(LoadMap(names[k]))
        imgui.SameLine()
        imgui.Text("  a click sets")
        imgui.SameLine()
        if imgui.RadioButton("goal", not self._set_start):
            self._set_start = False
        imgui.SameLine()
        if imgui.RadioButton("start", self._set_start):
            self._set_start = True

    def _map(self, scene: Scene) -> tuple[float, Array]:
        """The picture; returns screen pixels per picture pixel and its upper left corner."""
        h, w = scene.picture.shape[:2]
        room = imgui.GetContentRegionAvail()
        below = 4.6 * imgui.GetFrameHeightWithSpacing()
        scale = max(0.05, min(room.x / w, max(room.y - below, 60.0) / h))
        imgui.Image(self._picture, imgui.Vec2(w * scale, h * scale))
        low = imgui.GetItemRectMin()
        corner = np.array([low.x, low.y])
        if self._live and imgui.IsItemClicked():
            at = imgui.GetMousePos()
            x, y = scene.place((np.array([at.x, at.y]) - corner) / scale)
            self._set((float(x), float(y)))
        return scale, corner

    def _set(self, xy: tuple[float, float]) -> None:
        if self._set_start:
            self._cockpit.ask(Place(start=xy))
        else:
            self._goal = list(xy)
            self._cockpit.ask(Place(goal=xy))

    def _marks(
        self, scene: Scene, s: Snapshot | None, visited: Visited, scale: float, corner: Array
    ) -> None:
        """Coverage, plan, start, goal, true and believed pose."""
        ink = imgui.GetWindowDrawList()

        def at(xy: Any) -> Array:
            return np.asarray(corner + scale * scene.pixel(np.asarray(xy, float)))

        for cell in visited.squares:
            square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) + cell
            points = [imgui.Vec2(*p) for p in at(CELL * square)]
            ink.AddConvexPolyFilled(points, _ink(SEEN_INK))
        way = self._cockpit.way
        if way is not None:
            _way(ink, way, at)
        goal = None if way is None else way.goal
        for xy, colour in ((scene.start, START_INK), (goal, GOAL_INK)):
            if xy is not None:
                ink.AddCircle(imgui.Vec2(*at(xy)), 6.0, _ink(colour), 16, 2.5)
        if s is not None:
            for pose, colour in ((s.believed_pose, BELIEF_INK), (s.true_pose, TRUE_INK)):
                _arrow(ink, at(pose[:2]), at(pose[:2] + 0.5 * _unit(pose[3])), colour)

    def _buttons(self, s: Snapshot | None) -> None:
        cockpit = self._cockpit
        imgui.SetNextItemWidth(150.0)
        _, self._goal = imgui.InputFloatN("goal x y [m]", self._goal, "%.2f")
        imgui.SameLine()
        if imgui.Button("set"):
            self._cockpit.ask(Place(goal=(float(self._goal[0]), float(self._goal[1]))))
        for name in self._modes:
            imgui.SameLine()
            _, self._modes[name] = imgui.Checkbox(name, self._modes[name])
        modes = tuple(m for m in CHOICES if m == "crawl" or self._modes[m])
        if imgui.Button("Plan"):
            cockpit.ask(MakePlan(modes))
        imgui.SameLine()
        if imgui.Button("Go"):
            cockpit.ask(Go(modes))
        low, high = imgui.GetItemRectMin(), imgui.GetItemRectMax()
        cockpit.places["go"] = (0.5 * (low.x + high.x), 0.5 * (low.y + high.y))
        imgui.SameLine()
        if imgui.Button("Pause"):
            cockpit.ask(Wait())
        imgui.SameLine()
        if imgui.Button("Replan"):
            cockpit.ask(MakePlan(modes))
        imgui.SameLine()
        way = cockpit.way
        going = "" if s is None else "arrived" if s.arrived else "going" if s.following else ""
        imgui.Text(f"{going}  {'' if way is None else way.status}")

    def _legend(self) -> None:
        imgui.Text("black: true pose")
        imgui.SameLine()
        imgui.TextColored(imgui.Vec4(*BELIEF_INK), "believed")
        imgui.SameLine()
        imgui.TextColored(imgui.Vec4(*GOAL_INK), "goal")
        for mode in CHOICES:
            imgui.SameLine()
            imgui.TextColored(imgui.Vec4(*rgb(MODE_COLOURS[mode]), 1.0), f"{mode}")


def _way(ink: Any, way: Way, at: Callable[[Any], Array]) -> None:
    points = at(way.xy) if len(way.xy) else np.zeros((0, 2))
    for a, b, mode in zip(points[:-1], points[1:], way.modes, strict=True):
        colour = _ink((*rgb(MODE_COLOURS[mode]), 1.0))
        ink.AddLine(imgui.Vec2(*a), imgui.Vec2(*b), colour, 3.0)


def _arrow(ink: Any, a: Array, b: Array, colour: tuple[float, ...]) -> None:
    ink.AddLine(imgui.Vec2(*a), imgui.Vec2(*b), _ink(colour), 2.5)
    ink.AddCircleFilled(imgui.Vec2(*a), 4.5, _ink(colour))


def _unit(yaw: float) -> Array:
    return np.array([np.cos(yaw), np.sin(yaw)])


def _ink(colour: tuple[float, ...]) -> int:
    return int(imgui.ColorConvertFloat4ToU32(imgui.Vec4(*colour)))
