"""A recorded run in the same viewer as a live one: a time slider instead of controls."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mobius.geometry import heading_yaw
from mobius.types import GridMap, Mode, Plan
from mobius.view.live.guard import Door
from mobius.view.live.nouns import Freeze, Keeping, Reset, Scene, Snapshot, Way

Array = NDArray[np.float64]
PIXEL = 0.05
"""Edge of a pixel of the map's picture [m]."""
_WALL, _FLOOR = (74, 79, 87), (246, 247, 248)
SHOWN_S = 1.0 / 60.0


Recorded = Any
"""A run as :func:`mobius.bridge.read_run.open_run` gives it; rooms side by side do not import one
another."""


@dataclass(frozen=True)
class Seek:
    """Show another time [s] of the log."""

    t: float


@dataclass(frozen=True)
class Play:
    """Let time go on, or not, and how fast."""

    on: bool
    speed: float = 1.0


class Player:
    """Stands where the loop stands in a live view: time goes on, snapshots come."""

    def __init__(self, run: Recorded, *, clock: Callable[[], float] = time.monotonic) -> None:
        """Args: what is played; a clock [s]."""
        self.run, self._clock = run, clock
        self.model = run.model()
        self.qpos = run.qpos(self.model)
        self.t = float(run.t[0])
        self.playing, self.speed = True, 1.0
        self._before = clock()
        self._due, self._number, self._plan = 0.0, 0, object()
        self._blank = np.zeros(3)
        self.first = self._scene()

    @property
    def alive(self) -> bool:
        """Always: a log does not end by itself."""
        return True

    def send(self, request: Any) -> None:
        """Seek, Play, Freeze and Reset move the time; everything else is for robots."""
        match request:
            case Seek():
                self.t = float(np.clip(request.t, self.run.t[0], self.run.t[-1]))
            case Play():
                if request.on and not self.playing and self.t >= self.run.t[-1]:
                    self.t = float(self.run.t[0])  # from the beginning again
                self.playing, self.speed = request.on, request.speed
            case Freeze():
                self.playing = not request.on
            case Reset():
                self.t = float(self.run.t[0])

    def come(self, timeout: float = 0.0) -> Iterator[Way | Snapshot]:
        """The plan if it is another one, and the robot now; waits so that it is 60 Hz."""
        time.sleep(min(timeout, max(0.0, self._due - self._clock())))
        now = self._clock()
        self._due = now + SHOWN_S
        if self.playing:
            end = float(self.run.t[-1])
            self.t = min(self.t + self.speed * (now - self._before), end)
            self.playing = self.t < end
        self._before = now
        plan = self.run.plan_at(self.t)
        if plan is not self._plan:
            self._plan = plan
            yield self._way(plan)
        yield self.snapshot(self.run.at(self.t))

    def beside(self, rows: int) -> float:
        """Time [s] of the row that lies so many rows after (or before) the one shown."""
        row = min(max(self.run.at(self.t) + rows, 0), len(self.run) - 1)
        return float(self.run.t[row])

    def snapshot(self, row: int) -> Snapshot:
        """One row of the run."""
        run = self.run
        self._number += 1
        true = run.true or run.believed
        believed = run.believed or run.true
        heading = "biped" if run.modes[row] == Mode.BIPED else "crawl"
        return Snapshot(
            number=self._number,
            scene=1,
            t=float(run.t[row]),
            qpos=self.qpos[row],
            mode=run.modes[row],
            wanted=run.modes[row],
            stopped=run.modes[row] == Mode.STOP,
            notice="",
            message="",
            twist=np.stack([
                self._blank if rows is None else rows[row]
                for rows in (run.cmd_twist_H, believed.twist_H, true.twist_H)
            ]),
            true_pose=_pose(heading, true, row),
            believed_pose=_pose(heading, believed, row),
            power=float(run.power[row]),
            contact=np.zeros(4) if run.contact is None else run.contact[row],
            wrench=np.zeros((2, 6)) if run.wrench_S is None else run.wrench_S[row],
            keeping=Keeping(),
            plan=0,
            following=False,
            arrived=False,
            frozen=not self.playing,
            recording="",
            mocap=self._mocap(),
        )  # fmt: skip

    def _mocap(self) -> Array | None:
        """Obstacles (k, 7), where the scene shown has them: an empty floor has not."""
        poses: Array | None = self.run.mocap_at(self.t)
        return poses if poses is not None and len(poses) == self.model.nmocap else None

    def _way(self, plan: Plan | None) -> Way:
        if plan is None:
            return Way(1, np.zeros((0, 2)), (), "", None)
        goal = (float(plan.xy_M[-1, 0]), float(plan.xy_M[-1, 1]))
        modes = tuple(m.value for m in plan.modes)
        return Way(1, plan.xy_M, modes, plan.status, goal)

    def _scene(self) -> Scene:
        grid = self.run.grid
        picture, origin, pixel = _picture(grid) if grid is not None else _nothing()
        track = self.run.true or self.run.believed
        x, y = (float(v) for v in track.p_M[0, :2])
        return Scene(
            number=1,
            model=self.model,
            map=str(self.run.path),
            maps=(),
            picture=picture,
            origin_M=origin,
            resolution=pixel,
            start=(x, y),
            goal=None,
            modes=(),
        )


def show(
    run: Recorded,
    *,
    viewer: str = "web",
    port: int = 8080,
    seconds: float | None = None,
    shadows: bool = True,
    ready: Callable[[str], None] = print,
    seen: Callable[[Any], None] | None = None,
) -> None:
    """Show a run until the viewer is closed.

    Args:
        run: As :func:`mobius.bridge.read_run.open_run` gives it.
        viewer: ``web`` or ``native``.
        port: Of the page, on this machine alone.
        seconds: How long [s]; for ever if not given.
        shadows: Whether they are drawn.
        ready: Told the address of the page.
        seen: Shown the cockpit 60 times a second.

    Raises:
        InvalidInput: The scene in the log cannot be built, the port is taken, or there is no
            display.
    """
    from mobius.view.live.window import check_window

    if viewer == "native":
        check_window()
    from mobius.view.live.studio import watch
    from mobius.view.replay_windows import windows_of

    player = Player(run)
    watch(
        player,
        Reset,
        viewer=viewer,
        door=Door(port=port),
        seconds=seconds,
        shadows=shadows,
        ready=ready,
        seen=seen,
        windows=windows_of(player),
    )


def _pose(heading: Any, track: Any, row: int) -> Array:
    """(4,) x, y, z [m], yaw [rad]."""
    return np.array([*track.p_M[row], float(heading_yaw(heading, track.q_M[row]))])


def _picture(grid: GridMap) -> tuple[NDArray[np.uint8], Array, float]:
    """Blocked cells from above; a cell is a few pixels."""
    times = max(1, round(grid.cell / PIXEL))
    shown = np.where(grid.blocked.T[::-1, :, None], _WALL, _FLOOR).astype(np.uint8)
    picture = np.repeat(np.repeat(shown, times, axis=0), times, axis=1)
    return np.ascontiguousarray(picture), np.array(grid.origin_M), grid.cell / times


def _nothing() -> tuple[NDArray[np.uint8], Array, float]:
    """Ten metres of floor around the origin, where no map was recorded."""
    return np.full((200, 200, 3), _FLOOR, np.uint8), np.array([-5.0, -5.0, 0.0]), PIXEL


def plotted(run: Recorded, every: int) -> tuple[Array, Array]:
    """Times (m,) and rows (m, 18) in the order of :mod:`mobius.view.live.plots`."""
    rows = slice(None, None, every)
    true = run.true or run.believed
    believed = run.believed or run.true
    zeros = np.zeros((len(run.t), 3))
    forces = np.zeros((len(run.t), 2))
    if run.wrench_S is not None:
        forces = np.linalg.norm(run.wrench_S[:, :, :3], axis=2)
    parts: Iterable[Array] = (
        zeros if run.cmd_twist_H is None else run.cmd_twist_H,
        believed.twist_H,
        true.twist_H,
        run.power[:, None],
        np.zeros((len(run.t), 4)) if run.contact is None else run.contact,
        forces,
        np.zeros((len(run.t), 2)),
    )
    return run.t[rows], np.column_stack([np.asarray(p)[rows] for p in parts])
