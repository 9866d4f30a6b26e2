"""What is painted on the floor of the video: the plan in the colours of its modes, and
the way the robot has gone so far.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from mobius.errors import InvalidInput, UnknownName
from mobius.view.camera import free_joint
from mobius.view.palette import MODE_COLOURS, rgb

__all__ = ["NO_BOXES", "floor_height", "plan_boxes", "trail_boxes"]

Array = NDArray[np.float64]

NO_BOXES = np.zeros((0, 19))
"""Nothing to paint, in the form of :class:`mobius.view.render_worker.Painter`."""

Floor = Callable[[Array], Array]
"""Height (p,) [m] of the floor under points (p, 2) [m]."""

_PLAN_WIDTH, _TRAIL_WIDTH = 0.06, 0.025
_PLAN_LIFT, _TRAIL_LIFT = 0.004, 0.010
_THICK = 0.002
_DIM = 0.75
"""Lamps add up to more than one: painted colours are dimmed to come out as meant."""
_WHITE = (1.0 / _DIM,) * 3
_STEP, _FINE = 0.1, 0.025
"""Longest box on rough floor, and how closely the floor is looked at [m]."""
_FLAT = 1e-3
_KNEE_HIGH = 0.3
"""Floor is looked for below this height [m]: what hangs above is not the floor."""


def plan_boxes(xy: Array, floor: Floor, *, modes: Sequence[str] | None = None) -> Array:
    """Flat boxes along a plan.

    Args:
        xy: (T+1, 2) [m].
        floor: Height of the floor.
        modes: T mode names, or None for all crawl.

    Returns:
        (b, 19) boxes. Steps that go straight on in one mode over flat floor share one; on
        rough floor the boxes are short and lie on its bumps.
    """
    names = ["crawl"] * (len(xy) - 1) if modes is None else [str(m) for m in modes]
    if len(names) != max(len(xy) - 1, 0):
        raise InvalidInput(
            f"video: expected {max(len(xy) - 1, 0)} modes for {len(xy)} plan points,"
            f" got {len(names)}"
        )
    for name in names:
        if name not in MODE_COLOURS:
            raise UnknownName("mode", name, MODE_COLOURS)
    rows, first = [], 0
    for t, name in enumerate(names):
        if t + 1 < len(names) and names[t + 1] == name and _straight(xy[t : t + 3]):
            continue
        line = _divided(xy[first], xy[t + 1])
        z = floor(line) + _PLAN_LIFT
        step = np.inf if np.ptp(z) < _FLAT else _STEP
        strips, _ = _strips(np.column_stack([line, z]), _PLAN_WIDTH, step, rgb(MODE_COLOURS[name]))
        rows += strips
        first = t + 1
    return np.array(rows).reshape(-1, 19)


def trail_boxes(xy: Array, floor: Floor) -> tuple[Array, NDArray[np.int64]]:
    """Flat boxes along the way gone.

    Args:
        xy: (p, 2) [m], in the order of time.
        floor: Height of the floor.

    Returns:
        (b, 19) boxes, and (p,) how many of them are behind the robot at each point.
    """
    points = np.column_stack([xy, floor(xy) + _TRAIL_LIFT])
    rows, shown = _strips(points, _TRAIL_WIDTH, _STEP, _WHITE)
    return np.array(rows).reshape(-1, 19), shown


def floor_height(model: mujoco.MjModel, qpos: Array, xy: Array) -> Array:
    """(p,) height [m] of what does not move under the points (p, 2), 0 where nothing is."""
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    data.qpos[free_joint(model) + 2] += 1e3
    mujoco.mj_kinematics(model, data)
    down, hit = np.array([0.0, 0.0, -1.0]), np.zeros(1, dtype=np.int32)
    heights = np.zeros(len(xy))
    for k, (x, y) in enumerate(xy):
        reach = mujoco.mj_ray(model, data, np.array([x, y, _KNEE_HIGH]), down, None, 1, -1, hit)
        if reach >= 0.0:
            heights[k] = _KNEE_HIGH - reach
    return heights


def _straight(points: Array) -> bool:
    a, b = points[1] - points[0], points[2] - points[1]
    scale = np.linalg.norm(a) * np.linalg.norm(b)
    return bool(scale > 0 and np.dot(a, b) > scale * (1 - 1e-6))


def _divided(start: Array, end: Array) -> Array:
    """(p, 2) points from start to end, at most ``_FINE`` apart."""
    count = max(2, int(np.ceil(np.linalg.norm(end - start) / _FINE)) + 1)
    return np.linspace(start, end, count)


def _strips(
    points: Array, width: float, step: float, colour: Sequence[float]
) -> tuple[list[Array], NDArray[np.int64]]:
    """Boxes along points (p, 3), one as soon as ``step`` metres are gone and one for the rest
    if ``step`` is infinite; and (p,) how many there are up to each point.
    """
    rows: list[Array] = []
    made = np.zeros(len(points), dtype=np.int64)
    first = 0
    for k in range(1, len(points)):
        gone = np.linalg.norm(points[k, :2] - points[first, :2])
        if gone >= step - 1e-9 or (np.isinf(step) and k == len(points) - 1):
            rows += _strip(points[first : k + 1], width, colour)
            first = k
        made[k] = len(rows)
    return rows, made


def _strip(points: Array, width: float, colour: Sequence[float]) -> list[Array]:
    """One box from the first to the last point, a little longer so that corners are filled,
    and lifted so that no point between rises above it.
    """
    start, end = points[0], points[-1]
    along = end - start
    length = float(np.linalg.norm(along))
    if length < 1e-9:
        return []
    share = np.linspace(0.0, 1.0, len(points))
    lift = float(np.max(points[:, 2] - (start[2] + share * along[2])))
    x = along / length
    y = np.array([-x[1], x[0], 0.0]) / max(np.hypot(x[0], x[1]), 1e-9)
    rotation = np.column_stack([x, y, np.cross(x, y)])
    half = [length / 2 + width / 2, width / 2, _THICK / 2]
    rgba = [*(_DIM * c for c in colour), 1.0]
    middle = (start + end) / 2 + [0.0, 0.0, lift]
    return [np.concatenate([middle, half, rotation.ravel(), rgba])]
