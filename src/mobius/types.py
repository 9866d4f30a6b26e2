"""The nouns that cross rooms. Everything the rooms say to one another is in this file.

Conventions: SI units; angles in rad; quaternions ``wxyz``; REP-103 axes (x forward,
y left, z up). Frames: M map, O odom, B ``base_link``, H ``base_footprint`` (heading
frame), I IMU, S sensor. ``p_OB`` is the position of B in O. All messages are frozen,
their arrays read-only and checked on construction.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from enum import StrEnum
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.errors import InvalidInput

__all__ = [
    "LIMBS",
    "NUM_JOINTS",
    "GridMap",
    "JointCommand",
    "Mode",
    "ModeCommand",
    "Plan",
    "Pose",
    "SensorFrame",
    "StateEstimate",
]

Array = NDArray[np.float64]

NUM_JOINTS = 22
"""Length of every joint vector; the order is :data:`mobius.model.JOINTS`."""

LIMBS = ("left_arm", "right_arm", "left_leg", "right_leg")
"""Order of every per-limb array (front left, front right, rear left, rear right)."""


class Mode(StrEnum):
    """Primary body modes (Fig. 6), transitions between them (Fig. 13), exercise and stop."""

    BIPED = "biped"
    CRAWL = "crawl"
    ROLL = "roll"
    CLIMB = "climb"
    PULL_UP = "pull_up"
    GATHER = "gather"
    STAND_UP = "stand_up"
    LIE_DOWN = "lie_down"
    RECOVER = "recover"
    PUSH_UPS = "push_ups"
    STOP = "stop"

    @property
    def bit(self) -> int:
        """Bit of this mode in :attr:`GridMap.allowed` (biped 1, crawl 2, roll 4)."""
        try:
            return {"biped": 1, "crawl": 2, "roll": 4}[self.value]
        except KeyError:
            raise InvalidInput(
                f"mode '{self.value}' cannot be planned on a map; expected one of"
                " biped, crawl, roll"
            ) from None


ALL_MODES_BITS = 7
"""Every plannable mode allowed."""


def _finite(array: NDArray[Any]) -> bool:
    """Whether all numbers are finite; one dot product tells, unless the squares overflow."""
    flat = array.ravel()
    return math.isfinite(flat.dot(flat)) or bool(np.isfinite(array).all())


def frozen_array(
    owner: object, name: str, value: ArrayLike, shape: tuple[int | None, ...], dtype: Any = float
) -> None:
    """Store ``value`` on a frozen dataclass as a read-only array of the given shape.

    ``None`` in ``shape`` admits any length. Raises :class:`InvalidInput` when the
    shape differs or a float is not finite.
    """
    array = np.array(value, dtype=dtype)
    if array.shape != shape and not (
        array.ndim == len(shape)
        and all(want in (None, got) for want, got in zip(shape, array.shape, strict=True))
    ):
        want = tuple("n" if s is None else s for s in shape)
        raise InvalidInput(
            f"{type(owner).__name__}.{name}: expected shape {want}, got {array.shape}"
        )
    if array.dtype.kind == "f" and not _finite(array):
        raise InvalidInput(
            f"{type(owner).__name__}.{name}: expected finite numbers, got {array.tolist()}"
        )
    array.setflags(write=False)
    object.__setattr__(owner, name, array)


def unit_quaternion(owner: object, name: str, value: ArrayLike) -> None:
    """Store a read-only ``wxyz`` quaternion; raise when its norm is not 1 +- 1e-3."""
    frozen_array(owner, name, value, (4,))
    q = getattr(owner, name)
    norm = math.sqrt(float(q @ q))
    if abs(norm - 1.0) > 1e-3:
        raise InvalidInput(
            f"{type(owner).__name__}.{name}: expected a unit quaternion (wxyz), got norm {norm:.4f}"
        )


@dataclass(frozen=True, eq=False)
class Pose:
    """Position ``p`` (3,) [m] and orientation ``q`` (4,) ``wxyz`` of a body in a frame."""

    p: Array
    q: Array

    def __post_init__(self) -> None:
        frozen_array(self, "p", self.p, (3,))
        unit_quaternion(self, "q", self.q)


@dataclass(frozen=True, eq=False)
class GridMap:
    """What the planner sees of the world: cells, what blocks them, which modes they allow.

    Cell ``(i, j)`` covers ``[i, i+1) x [j, j+1)`` cells along the grid's own x and y axes.
    """

    name: str
    """Where the map came from, for messages."""
    cell: float
    """Edge of a cell [m]."""
    origin_M: Array
    """(3,) x [m], y [m], yaw [rad] of the lower-left corner of cell (0, 0), frame M."""
    blocked: NDArray[np.bool_]
    """(nx, ny) True where the robot's centre may not be (obstacles already inflated)."""
    allowed: NDArray[np.uint8]
    """(nx, ny) bit set of :attr:`Mode.bit`; 7 where the map forces nothing."""
    start: Array | None = None
    """(2,) [m], frame M, if the map names one."""
    goal: Array | None = None
    """(2,) [m], frame M, if the map names one."""

    def __post_init__(self) -> None:
        if not (np.isfinite(self.cell) and self.cell > 0):
            raise InvalidInput(f"GridMap.cell: expected metres > 0, got {self.cell}")
        frozen_array(self, "origin_M", self.origin_M, (3,))
        frozen_array(self, "blocked", self.blocked, (None, None), np.bool_)
        frozen_array(self, "allowed", self.allowed, self.blocked.shape, np.uint8)
        for name in ("start", "goal"):
            if getattr(self, name) is not None:
                frozen_array(self, name, getattr(self, name), (2,))

    @property
    def shape(self) -> tuple[int, int]:
        """(nx, ny)."""
        return self.blocked.shape[0], self.blocked.shape[1]

    def center_of(self, cells: ArrayLike) -> Array:
        """Centres (..., 2) [m] in M of cells (..., 2)."""
        local = (np.asarray(cells, dtype=float) + 0.5) * self.cell
        c, s = np.cos(self.origin_M[2]), np.sin(self.origin_M[2])
        return self.origin_M[:2] + local @ np.array([[c, s], [-s, c]])

    def cell_of(self, xy_M: ArrayLike) -> NDArray[np.int64]:
        """Cells (..., 2) that hold the points (..., 2) [m] of M; may lie off the grid."""
        c, s = np.cos(self.origin_M[2]), np.sin(self.origin_M[2])
        local = (np.asarray(xy_M, dtype=float) - self.origin_M[:2]) @ np.array([[c, -s], [s, c]])
        return np.floor(local / self.cell).astype(np.int64)

    def holds(self, cell: ArrayLike) -> bool:
        """Whether one cell (2,) lies on the grid."""
        i, j = (int(v) for v in np.asarray(cell))
        return 0 <= i < self.shape[0] and 0 <= j < self.shape[1]


PlanStatus = Literal["optimal", "feasible", "infeasible"]


@dataclass(frozen=True, eq=False)
class Plan:
    """A path over cells, the mode of every step, and what is proven about it."""

    cells: NDArray[np.int64]
    """(T+1, 2) cells, the first is the start."""
    modes: tuple[Mode, ...]
    """T modes; ``modes[t]`` moves ``cells[t]`` to ``cells[t+1]``."""
    xy_M: Array
    """(T+1, 2) [m] centres of the cells, frame M."""
    status: PlanStatus
    objective: float
    bound: float
    """Upper bound on the objective of any plan (equal to it when optimal)."""
    solve_s: float
    """Wall time of the search [s]."""

    def __post_init__(self) -> None:
        frozen_array(self, "cells", self.cells, (None, 2), np.int64)
        frozen_array(self, "xy_M", self.xy_M, (len(self.cells), 2))
        object.__setattr__(self, "modes", tuple(Mode(m) for m in self.modes))
        if len(self.modes) != max(len(self.cells) - 1, 0):
            raise InvalidInput(
                f"Plan.modes: expected {len(self.cells) - 1} modes for {len(self.cells)}"
                f" cells, got {len(self.modes)}"
            )

    @property
    def gap(self) -> float:
        """Bound minus objective, 0 when proven optimal."""
        return float(self.bound - self.objective)


@dataclass(frozen=True, eq=False)
class ModeCommand:
    """Which body to be and how to move it."""

    mode: Mode
    twist_H: Array
    """(3,) vx, vy [m/s], wz [rad/s] in the heading frame ``base_footprint``."""
    stamp: float
    """[s]."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "mode", Mode(self.mode))
        frozen_array(self, "twist_H", self.twist_H, (3,))


@dataclass(frozen=True, eq=False)
class JointCommand:
    """Position targets of all servos."""

    q: Array
    """(22,) [rad] (grippers: opening angle, 0 closed), order :data:`mobius.model.JOINTS`."""
    stamp: float
    """[s]."""

    def __post_init__(self) -> None:
        frozen_array(self, "q", self.q, (NUM_JOINTS,))


@dataclass(frozen=True, eq=False)
class SensorFrame:
    """What the robot's devices said at one tick. A device that did not tick is ``None``."""

    stamp: float
    """[s]."""
    q: Array
    """(22,) encoder angles [rad], order JOINTS."""
    dq: Array
    """(22,) encoder rates [rad/s]."""
    torque: Array
    """(22,) servo torque from the motor current [N m]."""
    wrench_S: Array
    """(2, 6) force [N], torque [N m] at the left and right wrist, sensor frame."""
    gyro_I: Array
    """(3,) [rad/s]."""
    accel_I: Array
    """(3,) specific force [m/s^2]; (0, 0, +9.81) at rest with z up."""
    vio: Pose | None = None
    """Trunk pose p_OB, q_OB by the visual-inertial camera, in its own drifting frame."""
    wrench_age: Array = field(default_factory=lambda: np.zeros(2))
    """(2,) how old each wrist's reading is [s], >= 0: a wrist that says nothing keeps its last one.
    A driver tells; simulated wrists are never silent."""

    def __post_init__(self) -> None:
        for name in ("q", "dq", "torque"):
            frozen_array(self, name, getattr(self, name), (NUM_JOINTS,))
        frozen_array(self, "wrench_age", self.wrench_age, (2,))
        if min(self.wrench_age) < 0.0:
            raise InvalidInput(
                f"SensorFrame.wrench_age: expected >= 0 s, got {self.wrench_age.tolist()}"
            )
        frozen_array(self, "wrench_S", self.wrench_S, (2, 6))
        frozen_array(self, "gyro_I", self.gyro_I, (3,))
        frozen_array(self, "accel_I", self.accel_I, (3,))


@dataclass(frozen=True, eq=False)
class StateEstimate:
    """What the robot believes of itself. Controllers and follower see this, never the truth."""

    stamp: float
    """[s]."""
    p_OB: Array
    """(3,) trunk position [m] in odom."""
    q_OB: Array
    """(4,) trunk orientation, wxyz."""
    v_B: Array
    """(3,) trunk velocity [m/s] in the trunk frame."""
    w_B: Array
    """(3,) trunk angular velocity [rad/s] in the trunk frame."""
    contact: Array
    """(4,) probability of ground contact per limb, order LIMBS."""
    cov: Array = field(default_factory=lambda: np.zeros((12, 12)))
    """(12, 12) covariance of (rotation vector, p, w, v)."""

    def __post_init__(self) -> None:
        for name in ("p_OB", "v_B", "w_B"):
            frozen_array(self, name, getattr(self, name), (3,))
        unit_quaternion(self, "q_OB", self.q_OB)
        frozen_array(self, "contact", self.contact, (len(LIMBS),))
        frozen_array(self, "cov", self.cov, (12, 12))


def as_dict(message: object) -> dict[str, Any]:
    """A message as plain Python values, for JSON."""

    def plain(value: Any) -> Any:
        if isinstance(value, np.ndarray | np.generic):
            return value.tolist()
        if isinstance(value, StrEnum):
            return value.value
        if isinstance(value, tuple | list):
            return [plain(v) for v in value]
        return as_dict(value) if hasattr(value, "__dataclass_fields__") else value

    return {f.name: plain(getattr(message, f.name)) for f in fields(message)}  # type: ignore[arg-type]
