"""MuJoCo Studio as our viewer: the only file that knows how its plug-ins and launchers work.

Studio runs the viewer in a thread and leaves the simulation to the caller. Here the caller is a
pump: it takes what the loop's process sends, puts it before Studio, and sends back what the
panels ask for.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from typing import Any, Protocol

import mujoco
import numpy as np
from mujoco.studio import app as studio_app
from mujoco.studio import launch_native, launch_web, messages, plugin, ux, viewer_protocol
from mujoco.studio.dear_imgui import dear_imgui as imgui
from mujoco.studio.sim import PauseState

from mobius.errors import InvalidInput
from mobius.view.live.cockpit import Cockpit
from mobius.view.live.guard import Door, Pulse, guarded
from mobius.view.live.nouns import Drag, Freeze, Request, Scene, Snapshot, Way
from mobius.view.live.overlay import build_overlay
from mobius.view.live.panel import DrivePanel
from mobius.view.live.plan_view import SEEN_CELL, PlanView
from mobius.view.live.plots import Plots

PUMP_S = 1.0 / 60.0


class Loop(Protocol):
    """What the pump asks of the loop's line."""

    first: Scene

    @property
    def alive(self) -> bool:
        """Whether it runs."""

    def send(self, request: Request) -> None:
        """Ask something."""

    def come(self, timeout: float = 0.0) -> Iterable[Scene | Way | Snapshot]:
        """What has come."""


class Panels(plugin.ViewerPlugin):
    """Our windows, and the overlay in the scene."""

    def __init__(self, cockpit: Cockpit, app: Any, *, shadows: bool = True) -> None:
        self.cockpit, self._app, self._shadows = cockpit, app, shadows
        self.drive, self.plan, self.plots = DrivePanel(cockpit), PlanView(cockpit), Plots(cockpit)
        self._size = (0.0, 0.0)

    @messages.handler(priority=0)  # after Studio's own, which aligns the camera
    def _on_model(self, _: messages.PostModelEvent) -> None:
        camera = self.viewer.camera
        camera.type = mujoco.mjtCamera.mjCAMERA_TRACKING
        camera.trackbodyid = self.viewer.model.body("base_link").id
        camera.distance, camera.elevation, camera.azimuth = 3.2, -32.0, 40.0
        self._app.ux_state.camera_index = ux.TRACKING_CAMERA_IDX
        if not self._shadows:
            for flag in (mujoco.mjtRndFlag.mjRND_SHADOW, mujoco.mjtRndFlag.mjRND_REFLECTION):
                flags = list(self.viewer.render_flags.flags)
                flags[int(flag)] = 0
                self.viewer.render_flags.flags = flags

    @messages.handler(priority=messages.Priority.USER)
    def _on_gui(self, _: messages.BuildGuiEvent) -> None:
        self.drive.keys()
        shown = imgui.GetIO().DisplaySize
        moved = (shown.x, shown.y) != self._size
        self._size = (shown.x, shown.y)
        for title, draw, box in (
            ("Drive", self.drive.draw, (8.0, 30.0, 330.0, shown.y - 64.0)),
            ("Plan", self._draw_plan, (shown.x - 428.0, 30.0, 420.0, 0.56 * shown.y)),
            (
                "Plots",
                self.plots.draw,
                (346.0, 0.56 * shown.y + 34.0, shown.x - 354.0, 0.44 * shown.y - 68.0),
            ),
        ):
            when = imgui.Cond.Always if moved else imgui.Cond.FirstUseEver
            imgui.SetNextWindowPos(imgui.Vec2(box[0], box[1]), int(when))
            imgui.SetNextWindowSize(imgui.Vec2(box[2], box[3]), int(when))
            if imgui.Begin(title, None, int(imgui.WindowFlags.NoSavedSettings))[0]:
                draw()
            imgui.End()
        self._paint()

    def _draw_plan(self) -> None:
        self.plan.draw(self.viewer.upload_image)

    def _paint(self) -> None:
        geoms, s = self.viewer.extra_geoms, self.cockpit.snapshot
        geoms.clear()
        if s is not None:
            geoms.extend(build_overlay(s, self.cockpit.way, self.plan.visited, SEEN_CELL))


class Reins(plugin.SimPlugin):
    """What Studio itself lets a person do: drag bodies with the mouse, pause, reset."""

    def __init__(self, cockpit: Cockpit, reset: Callable[[], Request]) -> None:
        self._cockpit, self._reset = cockpit, reset
        self._dragging = False

    @messages.handler
    def _on_drag(self, event: messages.PerturbSnapshot) -> bool:
        xfrc = np.asarray(event.state).reshape(-1, 6)
        if xfrc.any() or self._dragging:
            self._cockpit.ask(Drag(xfrc.copy()))
        self._dragging = bool(xfrc.any())
        return True

    @messages.handler
    def _on_pause(self, event: messages.StepControlSnapshot) -> bool:
        self._cockpit.ask(Freeze(event.pause_state is not PauseState.UNPAUSED))
        return True

    @messages.handler
    def _on_reset(self, event: messages.ResetEvent) -> bool:
        del event
        self._cockpit.ask(self._reset())
        return True

    @messages.handler
    def _on_state(self, event: messages.StateEvent) -> bool:
        del event  # joints are moved by the robot's servos alone
        return True

    @messages.handler
    def _on_load(self, event: messages.LoadModelEvent) -> bool:
        del event  # files dropped on the page: the scene comes from the map
        return True


def watch(
    loop: Loop,
    reset: Callable[[], Request],
    *,
    viewer: str,
    door: Door,
    seconds: float | None = None,
    shadows: bool = True,
    ready: Callable[[str], None] = print,
    seen: Callable[[Cockpit], None] | None = None,
) -> Snapshot | None:
    """Show a loop until the viewer is closed, the loop ends, or ``seconds`` are over.

    Args:
        loop: The line to it.
        reset: Makes the request that Studio's own reset button sends.
        viewer: ``web`` or ``native``.
        door: Where the page is served.
        seconds: How long [s].
        shadows: Whether they are drawn; without a graphics card they are dear.
        ready: Told the address once the page can be opened.
        seen: Called after each round of the pump.

    Returns:
        The last snapshot.
    """
    pulse = Pulse() if viewer == "web" else None
    cockpit = Cockpit(pulse)
    app = _app()
    plugins = [app, Panels(cockpit, app, shadows=shadows), Reins(cockpit, reset)]
    config = viewer_protocol.ViewerConfig(
        title="mobius", width=1400, height=860, gfx="web" if viewer == "web" else "",
        http_port=door.port,
    )  # fmt: skip
    with _launched(config, plugins, door, pulse, ready) as handle:
        _show_scene(handle, cockpit, loop.first)
        _pump(handle, cockpit, loop, seconds, seen or _nothing)
    return cockpit.snapshot


def _launched(
    config: Any, plugins: list[Any], door: Door, pulse: Pulse | None, ready: Callable[[str], None]
) -> Any:
    """Studio's handle, once its window or page is there."""
    if pulse is None:
        return launch_native.launch(config, plugins=plugins)
    try:
        with guarded(door, pulse) as opened:
            handle = launch_web.launch(config, plugins=plugins)
            while not opened.serving.wait(0.05) and handle.is_running():
                pass
    except RuntimeError as error:  # of Studio: the port is taken
        raise InvalidInput(f"--port {door.port}: {error}") from None
    query = f"?token={door.token}" if door.token else ""
    ready(f"http://{door.address(opened.port)}/{query}")
    return handle


def _app() -> Any:
    return studio_app.App(
        studio_app.Config(show_options=False, show_inspector=False, show_status_bar=False)
    )


def _nothing(_: Cockpit) -> None:
    """Nobody looks on."""


def _pump(
    handle: Any,
    cockpit: Cockpit,
    loop: Loop,
    seconds: float | None,
    seen: Callable[[Cockpit], None],
) -> None:
    began = time.monotonic()
    while handle.is_running() and loop.alive:
        if seconds is not None and time.monotonic() - began > seconds:
            return
        due = time.monotonic() + PUMP_S
        for came in loop.come(PUMP_S):
            _take(handle, cockpit, came)
        loop.send(cockpit.beat())
        while cockpit.requests:
            loop.send(cockpit.requests.popleft())
        handle.sync()
        seen(cockpit)
        time.sleep(max(0.0, due - time.monotonic()))


def _take(handle: Any, cockpit: Cockpit, came: Any) -> None:
    if isinstance(came, Scene):
        _show_scene(handle, cockpit, came)
    elif isinstance(came, Way):
        cockpit.way = came
    elif cockpit.scene is not None and came.scene == cockpit.scene.number:
        cockpit.show(came)
        handle.data.qpos[:] = came.qpos
        handle.data.time = came.t
    # an older scene's snapshot is dropped


def _show_scene(handle: Any, cockpit: Cockpit, scene: Scene) -> None:
    same = cockpit.scene is not None and cockpit.scene.map == scene.map
    cockpit.scene, cockpit.snapshot = scene, None
    if not same:
        handle.set_model(scene.model)
