"""Plan, coverage, goal and the believed pose, drawn into the 3D scene."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from mobius.view.live.nouns import Snapshot, Way
from mobius.view.live.visited import CELL, Visited
from mobius.view.palette import MODE_COLOURS, rgb

Array = NDArray[np.float64]

LIFT, WIDTH = 0.012, 0.012
"""Of the plan's line above the floor, and its radius [m]."""
MOST = 900
"""Geoms that a page is sent at most (it takes 1024)."""


def build_overlay(snapshot: Snapshot, way: Way | None, visited: Visited) -> list[mujoco.MjvGeom]:
    """Everything that is painted: the robot's belief, its plan and goal, where it has been."""
    geoms = [_ghost(snapshot)]
    if way is not None:
        geoms += _plan(way)
        if way.goal is not None:
            geoms.append(_goal(way.goal))
    squares = list(visited.squares)
    geoms += [_square(c, CELL) for c in squares[-max(MOST - len(geoms), 1) :]]
    return geoms[:MOST]


def _geom(
    kind: int, size: Sequence[float], pos: Array, mat: Array, rgba: Sequence[float]
) -> mujoco.MjvGeom:
    geom = mujoco.MjvGeom()
    mujoco.mjv_initGeom(
        geom,
        kind,
        np.array(size, float),
        np.array(pos, float),
        mat.ravel(),
        np.array(rgba, np.float32),
    )
    return geom


def _plan(way: Way) -> list[mujoco.MjvGeom]:
    geoms = []
    for a, b, mode in zip(way.xy[:-1], way.xy[1:], way.modes, strict=True):
        if np.linalg.norm(b - a) < 1e-9:
            continue
        geom = _geom(
            mujoco.mjtGeom.mjGEOM_CAPSULE, (WIDTH,) * 3, np.zeros(3), np.eye(3),
            (*rgb(MODE_COLOURS[mode]), 1.0),
        )  # fmt: skip
        ends = np.column_stack([np.stack([a, b]), [LIFT, LIFT]])
        mujoco.mjv_connector(geom, mujoco.mjtGeom.mjGEOM_CAPSULE, WIDTH, ends[0], ends[1])
        geoms.append(geom)
    return geoms


def _goal(xy: tuple[float, float]) -> mujoco.MjvGeom:
    at = np.array([*xy, 0.01])
    return _geom(
        mujoco.mjtGeom.mjGEOM_CYLINDER, (0.15, 0.006, 0.0), at, np.eye(3), (0.82, 0.16, 0.16, 0.8)
    )


def _square(at: tuple[int, int], cell: float) -> mujoco.MjvGeom:
    middle = np.array([*(cell * (np.array(at) + 0.5)), 0.002])
    half = 0.47 * cell
    return _geom(
        mujoco.mjtGeom.mjGEOM_BOX, (half, half, 0.001), middle, np.eye(3), (1.0, 0.8, 0.1, 0.25)
    )


def _ghost(s: Snapshot) -> mujoco.MjvGeom:
    """An arrow above where the robot believes to be, towards where it believes to face."""
    x, y, z, yaw = s.believed_pose
    c, sn = np.cos(yaw), np.sin(yaw)
    along = np.array([[-sn, 0.0, c], [c, 0.0, sn], [0.0, 1.0, 0.0]])  # columns: x, y, z = ahead
    at = np.array([x - 0.15 * c, y - 0.15 * sn, z + 0.28])
    return _geom(
        mujoco.mjtGeom.mjGEOM_ARROW, (0.012, 0.012, 0.3), at, along, (0.80, 0.10, 0.55, 0.9)
    )
