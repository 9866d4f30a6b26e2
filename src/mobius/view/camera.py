"""The third-person camera: behind the robot, smooth, and above the walls in between."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d, maximum_filter1d

from mobius.errors import InvalidInput
from mobius.geometry import rotate

__all__ = ["ChaseCamera", "chase", "free_joint"]

Array = NDArray[np.float64]

_STEEPEST = np.radians(80.0)
_FAR_AWAY = 1e3
"""Where the robot is put while walls are looked for, so that no ray ends at it [m]."""


@dataclass(frozen=True)
class ChaseCamera:
    """How the camera follows the trunk."""

    distance: float = 1.7
    """From the trunk [m]."""
    elevation: float = 0.45
    """Above the horizon [rad], in (0, 1.4); raised where a wall would hide the robot."""
    side: float = 0.5
    """Seen from behind and this much from the right [rad]; 0 straight from behind."""
    smooth: float = 0.8
    """Standard deviation of the Gaussian that smooths the motion [s]."""


def free_joint(model: mujoco.MjModel) -> int:
    """Where the first free joint starts in ``qpos``. Raises :class:`InvalidInput`."""
    free = np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_FREE)
    if not len(free):
        raise InvalidInput("video: expected a model with a free joint to follow, got none")
    return int(model.jnt_qposadr[free[0]])


def chase(model: mujoco.MjModel, qpos: Array, dt: float, *, camera: ChaseCamera) -> Array:
    """Where the camera looks in every frame.

    Args:
        model: Robot and scene.
        qpos: (k, nq) configurations, one per frame.
        dt: Time between frames [s].
        camera: Settings.

    Returns:
        (k, 6): point looked at x, y, z [m]; distance [m]; azimuth, elevation [rad] of the
        direction of sight (elevation is negative: the camera looks down).
    """
    adr = free_joint(model)
    sigma = max(camera.smooth / dt, 1e-3)
    look = gaussian_filter1d(qpos[:, adr : adr + 3], sigma, axis=0, mode="nearest")
    forward = gaussian_filter1d(_forward(qpos[:, adr + 3 : adr + 7]), sigma, axis=0, mode="nearest")
    azimuth = np.arctan2(forward[:, 1], forward[:, 0]) + camera.side
    height = _clear_elevation(model, qpos[0], look, azimuth, dt=dt, camera=camera)
    # Rise before the wall is in the way, then smooth: the robot is never hidden on the way up.
    window = 2 * int(np.ceil(1.5 * sigma)) + 1
    height = gaussian_filter1d(maximum_filter1d(height, window), sigma, mode="nearest")
    distance = np.full(len(qpos), camera.distance)
    return np.column_stack([look, distance, azimuth, -height])


def _forward(quat: Array) -> Array:
    """(k, 2) horizontal direction of travel: at right angles to +y of the trunk, which rearing
    up and rolling leave where it is; short where the trunk lies on a side.
    """
    left = rotate(quat, np.broadcast_to([0.0, 1.0, 0.0], (len(quat), 3)))
    return np.column_stack([left[:, 1], -left[:, 0]])


def _clear_elevation(
    model: mujoco.MjModel,
    qpos: Array,
    look: Array,
    azimuth: Array,
    *,
    dt: float,
    camera: ChaseCamera,
) -> Array:
    """(k,) lowest elevation [rad] from which no wall hides the trunk, looked up at 5 Hz."""
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    data.qpos[free_joint(model) + 2] += _FAR_AWAY
    mujoco.mj_kinematics(model, data)
    candidates = np.linspace(camera.elevation, max(_STEEPEST, camera.elevation), 6)
    stride = max(1, round(0.2 / dt))
    rows = np.arange(0, len(look), stride)
    found = [
        next(
            (e for e in candidates if _sees(model, data, look[k], azimuth[k], e, camera.distance)),
            candidates[-1],
        )
        for k in rows
    ]
    return np.interp(np.arange(len(look)), rows, found)


def _sees(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    look: Array,
    azimuth: float,
    elevation: float,
    distance: float,
) -> bool:
    to_camera = distance * np.array(
        [
            -np.cos(elevation) * np.cos(azimuth),
            -np.cos(elevation) * np.sin(azimuth),
            np.sin(elevation),
        ]
    )
    hit = np.zeros(1, dtype=np.int32)
    for sideways in (0.0, 0.25, -0.25):
        start = look + sideways * np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
        reach = mujoco.mj_ray(model, data, start, to_camera, None, 1, -1, hit)
        if 0.0 <= reach <= 1.0:
            return False
    return True
