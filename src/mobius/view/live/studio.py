"""MuJoCo Studio as our viewer: the only file that knows how its plug-ins and launchers work.

Studio runs the viewer in a thread and leaves the simulation to the caller. Here the caller is a
pump: it takes what the loop's process sends, puts it before Studio, and sends back what the
panels ask for.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Protocol

import mujoco
import numpy as np
from mujoco.studio import app as studio_app
from mujoco.studio import launch_native, launch_web, messages, plugin, ux, viewer_protocol
from mujoco.studio.dear_imgui import dear_imgui as imgui
from mujoco.studio.sim import PauseState

from mobius.errors import InvalidInput
from mobius.view.live.cockpit import Cockpit
from mobius.view.live.guard import Door, guarded
from mobius.view.live.nouns import Drag, Freeze, Request, Scene, Snapshot, Way
from mobius.view.live.overlay import build_overlay
from mobius.view.live.panel import DrivePanel
from mobius.view.live.plan_view import PlanView
from mobius.view.live.plots import Plots
from mobius.view.live.pulse import Pulse
from mobius.view.live.visited import Visited
from mobius.view.live.window import WINDOW_GFX, prepare_window

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


@dataclass(frozen=True)
class Window:
    """One of our windows."""

    title: str
    draw: Callable[[], None]
    box: Callable[[float, float], tuple[float, float, float, float]]
    """Left, top, width, height [pixels] on a page of a width and height."""


class Windows(plugin.ViewerPlugin):
    """Our windows, and the overlay in the scene."""

    def __init__(self, cockpit: Cockpit, app: Any, *, shadows: bool = True) -> None:
        self.cockpit, self._app, self._shadows = cockpit, app, shadows
        self._size = (0.0, 0.0)
        self._visited = Visited()

    def windows(self) -> tuple[Window, ...]:
        """What is shown; asked once a frame."""
        raise NotImplementedError

    def before(self) -> None:
        """Called before the windows are drawn."""

    @messages.handler(priority=0)  # after Studio's own, which aligns the camera
    def _on_model(self, _: messages.PostModelEvent) -> None:
        camera = self.viewer.camera
        camera.type = mujoco.mjtCamera.mjCAMERA_TRACKING
        camera.trackbodyid = self.viewer.model.body("base_link").id
        camera.distance, camera.elevation, camera.azimuth = 3.2, -32.0, 40.0
        self._app.ux_state.camera_index = ux.TRACKING_CAMERA_IDX
        if not self._shadows:
            flags = list(self.viewer.render_flags.flags)
            for flag in (mujoco.mjtRndFlag.mjRND_SHADOW, mujoco.mjtRndFlag.mjRND_REFLECTION):
                flags[int(flag)] = 0
            self.viewer.render_flags.flags = flags

    @messages.handler
    def _on_gui(self, _: messages.BuildGuiEvent) -> None:
        self._visited.see(self.cockpit.scene, self.cockpit.snapshot)
        self.before()
        shown = imgui.GetIO().DisplaySize
        moved, self._size = (shown.x, shown.y) != self._size, (shown.x, shown.y)
        when = int(imgui.Cond.Always if moved else imgui.Cond.FirstUseEver)
        for window in self.windows():
            left, top, width, height = window.box(shown.x, shown.y)
            imgui.SetNextWindowPos(imgui.Vec2(left, top), when)
            imgui.SetNextWindowSize(imgui.Vec2(width, height), when)
            if imgui.Begin(window.title, None, int(imgui.WindowFlags.NoSavedSettings))[0]:
                window.draw()
            imgui.End()
        geoms, s = self.viewer.extra_geoms, self.cockpit.snapshot
        geoms.clear()
        if s is not None:
            geoms.extend(build_overlay(s, self.cockpit.way, self._visited))


class DriveWindows(Windows):
    """Of ``mobius drive``."""

    def __init__(self, cockpit: Cockpit, app: Any, *, shadows: bool = True) -> None:
        super().__init__(cockpit, app, shadows=shadows)
        self._panel, plan, plots = DrivePanel(cockpit), PlanView(cockpit), Plots(cockpit)
        self._windows = (
            Window("Drive", self._panel.draw, lambda w, h: (8.0, 30.0, 330.0, h - 64.0)),
            Window(
                "Plan",
                lambda: plan.draw(self.viewer.upload_image, self._visited),
                lambda w, h: (w - 428.0, 30.0, 420.0, 0.56 * h),
            ),
            Window("Plots", plots.draw, bottom),
        )

    def windows(self) -> tuple[Window, ...]:
        """Drive, Plan, Plots."""
        return self._windows

    def before(self) -> None:
        """Look at the keys."""
        self._panel.keys()


def bottom(w: float, h: float) -> tuple[float, float, float, float]:
    """Where the plots stand: below the scene, right of the panel."""
    return 346.0, 0.56 * h + 34.0, w - 354.0, 0.44 * h - 68.0


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
    windows: type[Windows] = DriveWindows,
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
        windows: What is shown beside the scene.

    Returns:
        The last snapshot.
    """
    pulse = Pulse() if viewer == "web" else None
    cockpit = Cockpit(pulse)
    app = _app()
    plugins = [app, windows(cockpit, app, shadows=shadows), Reins(cockpit, reset)]
    config = viewer_protocol.ViewerConfig(
        title="mobius", width=1400, height=860, gfx="web" if viewer == "web" else WINDOW_GFX,
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
        prepare_window()
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
        return
    if isinstance(came, Way):
        cockpit.way = came
        return
    cockpit.seen = came.number
    if cockpit.scene is not None and came.scene == cockpit.scene.number:  # else it is an old one
        cockpit.show(came)
        handle.data.qpos[:] = came.qpos
        if came.mocap is not None:
            handle.data.mocap_pos[:], handle.data.mocap_quat[:] = (
                came.mocap[:, :3],
                came.mocap[:, 3:],
            )
        handle.data.time = came.t


def _show_scene(handle: Any, cockpit: Cockpit, scene: Scene) -> None:
    same = cockpit.scene is not None and _looks(cockpit.scene) == _looks(scene)
    cockpit.scene, cockpit.snapshot = scene, None
    if not same:
        handle.set_model(scene.model)


def _looks(scene: Scene) -> tuple[Any, ...]:
    """What two scenes share that are drawn alike; files of one name may hold other maps."""
    m, where = scene.model, (*scene.origin_M.tolist(), scene.resolution)
    return scene.map, (m.nq, m.nbody, m.ngeom, m.nmocap), where, scene.picture.tobytes()
