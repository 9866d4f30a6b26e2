"""What is painted on the floor of the video: the plan in the colours of its modes, and
the way the robot has gone so far.
"""

from __future__ import annotations

from collections.abc import Sequence

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

_PLAN_WIDTH, _TRAIL_WIDTH = 0.06, 0.02
_PLAN_LIFT, _TRAIL_LIFT = 0.004, 0.008
_THICK = 0.002
_DIM = 0.75
"""Lamps add up to more than one: painted colours are dimmed to come out as meant."""
_TRAIL_COLOUR = (0.95, 0.95, 0.95)
_TRAIL_STEP = 0.12
_KNEE_HIGH = 0.3
"""Floor is looked for below this height [m]: what hangs above is not the floor."""


def plan_boxes(xy: Array, z: Array, modes: Sequence[str] | None) -> Array:
    """Flat boxes along a plan.

    Args:
        xy: (T+1, 2) [m].
        z: (T+1,) height of the floor there [m].
        modes: T mode names, or None for all crawl.

    Returns:
        (b, 19) boxes; steps that go on straight in one mode share one.
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
    points = np.column_stack([xy, np.asarray(z) + _PLAN_LIFT])
    rows, first = [], 0
    for t in range(len(names)):
        if t + 1 < len(names) and names[t + 1] == names[t] and _straight(points[t : t + 3]):
            continue
        colour = rgb(MODE_COLOURS[names[t]])
        rows += _strip(points[first], points[t + 1], _PLAN_WIDTH, colour)
        first = t + 1
    return np.array(rows).reshape(-1, 19)


def trail_boxes(xy: Array, z: Array) -> tuple[Array, NDArray[np.int64]]:
    """Flat boxes along the way gone.

    Args:
        xy: (p, 2) [m], in the order of time.
        z: (p,) height of the floor there [m].

    Returns:
        (b, 19) boxes, and (p,) how many of them are behind the robot at each point.
    """
    points = np.column_stack([xy, np.asarray(z) + _TRAIL_LIFT])
    rows: list[Array] = []
    shown = np.zeros(len(points), dtype=np.int64)
    last = 0
    for k in range(1, len(points)):
        if np.linalg.norm(points[k, :2] - points[last, :2]) >= _TRAIL_STEP:
            rows += _strip(points[last], points[k], _TRAIL_WIDTH, _TRAIL_COLOUR)
            last = k
        shown[k] = len(rows)
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


def _strip(start: Array, end: Array, width: float, colour: Sequence[float]) -> list[Array]:
    """One box from start to end, a little longer at both ends so that corners are filled."""
    along = end - start
    length = float(np.linalg.norm(along))
    if length < 1e-9:
        return []
    x = along / length
    y = np.array([-x[1], x[0], 0.0]) / max(np.hypot(x[0], x[1]), 1e-9)
    rotation = np.column_stack([x, y, np.cross(x, y)])
    half = [length / 2 + width / 2, width / 2, _THICK / 2]
    rgba = [*(_DIM * c for c in colour), 1.0]
    return [np.concatenate([(start + end) / 2, half, rotation.ravel(), rgba])]
