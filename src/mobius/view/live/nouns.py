"""What crosses between a viewer and the loop that it watches, as plain values.

Loop and viewer are two processes: drawing must not make the robot late, and a viewer that dies
must not take the robot along. A viewer sends requests and a :class:`Beat` many times a second;
the loop sends a :class:`Scene` when the world changes and a :class:`Snapshot` at 60 Hz.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LIMBS_SHOWN = ("arm L", "arm R", "leg L", "leg R")
"""Short names of the limbs, that fit a legend, in the order of :data:`mobius.types.LIMBS`."""
MODE_KEYS = (("1", "crawl"), ("2", "biped"), ("3", "roll"), ("4", "push_ups"))
"""Digit and the mode it asks for."""

# -- requests: viewer -> loop ------------------------------------------------------------


@dataclass(frozen=True)
class Beat:
    """Sent at 60 Hz: somebody is there, and this is what the keys say now."""

    page: bool = True
    """Whether the page is connected and answers."""
    driving: bool = False
    """Whether the Drive toggle is on: keys move the robot, and losing the focus stops it."""
    share: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Of the body's greatest vx, vy, wz, each -1 to 1; zeros when no key is held."""
    seen: int = 0
    """Number of the last snapshot that came."""


@dataclass(frozen=True)
class WantMode:
    """Be this body, or make this motion; the mode machine finds the way."""

    mode: str


@dataclass(frozen=True)
class Halt:
    """Emergency stop."""

    why: str = "emergency stop"


@dataclass(frozen=True)
class Release:
    """End the emergency stop."""


@dataclass(frozen=True)
class SpeedLimit:
    """Share (0 to 1) of the body's greatest speeds that held keys reach."""

    share: float


@dataclass(frozen=True)
class LoadMap:
    """Another map: a shipped one's name or a file."""

    name: str


@dataclass(frozen=True)
class Place:
    """Where the robot starts (it is put there) or shall go; None leaves it."""

    start: tuple[float, float] | None = None
    """x, y [m] in the map frame."""
    goal: tuple[float, float] | None = None


@dataclass(frozen=True)
class MakePlan:
    """Plan from where the robot believes to be to the goal."""

    modes: tuple[str, ...] = ("crawl",)


@dataclass(frozen=True)
class Go:
    """Follow the plan; without one, plan first."""

    modes: tuple[str, ...] = ("crawl",)


@dataclass(frozen=True)
class Wait:
    """Stand still and keep the plan."""


@dataclass(frozen=True)
class Push:
    """Shove the robot: a change of velocity [m/s] within 0.1 s, felt by all its parts."""

    dv: float
    bearing: float
    """Where to, from its heading, counter-clockwise [rad]."""


@dataclass(frozen=True, eq=False)
class Drag:
    """Forces of the mouse on all bodies until the next one comes."""

    xfrc: Array
    """(nbody, 6) force [N] and torque [N m], world frame."""


@dataclass(frozen=True)
class Reset:
    """Put the robot back to the start."""


@dataclass(frozen=True)
class Freeze:
    """Stop the time of the simulation, or let it go on."""

    on: bool


@dataclass(frozen=True)
class Record:
    """Begin or end a log."""

    on: bool


@dataclass(frozen=True)
class UsePolicy:
    """What drives a body from now on: flat, rough, zero, random or an ONNX file."""

    body: str
    name: str


Request = (
    Beat | WantMode | Halt | Release | SpeedLimit | LoadMap | Place | MakePlan | Go | Wait
    | Push | Drag | Reset | Freeze | Record | UsePolicy
)  # fmt: skip

# -- the loop's answers ------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Scene:
    """The world in which the robot is, sent when it changes."""

    number: int
    model: Any
    """mujoco.MjModel."""
    map: str
    maps: tuple[str, ...]
    """Names of the shipped maps."""
    picture: NDArray[np.uint8]
    """(h, w, 3) the map from above, row 0 at the top."""
    origin_M: Array
    """(3,) x, y [m], yaw [rad] of the picture's lower-left corner."""
    resolution: float
    """Edge of a pixel [m]."""
    start: tuple[float, float]
    goal: tuple[float, float] | None
    modes: tuple[str, ...]
    """That can be asked for."""
    policies: dict[str, str] = field(default_factory=dict)
    """What drives each body."""

    def pixel(self, xy_M: Array) -> Array:
        """Points (..., 2) [m] of M as (column, row) of the picture, row 0 at the top."""
        c, s = np.cos(self.origin_M[2]), np.sin(self.origin_M[2])
        local = (np.asarray(xy_M, float) - self.origin_M[:2]) @ np.array([[c, -s], [s, c]])
        at = local / self.resolution
        return np.stack([at[..., 0], self.picture.shape[0] - at[..., 1]], axis=-1)

    def place(self, pixel: Array) -> Array:
        """(column, row) (..., 2) of the picture as points [m] of M."""
        at = np.asarray(pixel, float)
        local = np.stack([at[..., 0], self.picture.shape[0] - at[..., 1]], axis=-1)
        c, s = np.cos(self.origin_M[2]), np.sin(self.origin_M[2])
        return np.asarray(self.origin_M[:2] + self.resolution * local @ np.array([[c, s], [-s, c]]))


@dataclass(frozen=True)
class Keeping:
    """How well real time is kept."""

    factor: float = 1.0
    """Simulated time over wall time in the last ten seconds."""
    misses: float = 0.0
    """Share of the 300 Hz rounds since the start that were done too late."""
    late_p99_ms: float = 0.0
    """99 % of the last rounds were done within this time after they were due [ms]."""
    dropped_s: float = 0.0
    """Time given up for good [s]."""


@dataclass(frozen=True, eq=False)
class Snapshot:
    """The robot at one 60 Hz sample."""

    number: int
    scene: int
    """Number of the scene it is in."""
    t: float
    """Time of the simulation [s]."""
    qpos: Array
    """(nq,)."""
    mode: str
    wanted: str
    stopped: bool
    notice: str
    """Why a request is not being carried out; empty when it is."""
    message: str
    """Last thing that went wrong or right with a request."""
    twist: Array
    """(3, 3) rows commanded, believed, true: vx, vy [m/s], wz [rad/s], heading frame."""
    true_pose: Array
    """(4,) x, y, z [m], yaw [rad]."""
    believed_pose: Array
    """(4,)."""
    power: float
    """[W]."""
    contact: Array
    """(4,) contact forces [N]."""
    wrench: Array
    """(2, 6) left and right wrist [N, N m], sensor frame."""
    keeping: Keeping
    plan: int
    """Number of the plan; 0 where there is none."""
    following: bool
    """Whether the plan is being followed."""
    arrived: bool
    frozen: bool
    recording: str
    """File being written, or empty."""
    mocap: Array | None = None
    """(k, 7) poses of obstacles that move, x y z [m] qw qx qy qz; None where there are none."""


@dataclass(frozen=True, eq=False)
class Way:
    """A plan to draw, sent when it changes."""

    number: int
    xy: Array
    """(T+1, 2) [m], frame M; empty where there is none."""
    modes: tuple[str, ...]
    """T."""
    status: str
    """What is proven about it."""
    goal: tuple[float, float] | None


@dataclass(eq=False)
class History:
    """The last seconds of some numbers, for plots."""

    length: int = 300
    t: list[float] = field(default_factory=list)
    rows: list[list[float]] = field(default_factory=list)

    def add(self, t: float, row: list[float]) -> None:
        """Take in one row; time that runs backwards clears what was."""
        if self.t and t < self.t[-1]:
            self.clear()
        self.t.append(t)
        self.rows.append(row)
        if len(self.t) > self.length:
            del self.t[0], self.rows[0]

    def column(self, k: int) -> list[float]:
        """One number over time."""
        return [row[k] for row in self.rows]

    def clear(self) -> None:
        """Forget all."""
        self.t.clear()
        self.rows.clear()
