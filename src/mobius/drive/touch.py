"""The robot as seen and touched from outside: its heading, a push, the mouse's pull."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mobius.control.bodies import BODIES
from mobius.control.observation import heading_twist
from mobius.errors import InvalidInput
from mobius.geometry import heading_yaw
from mobius.types import Mode, StateEstimate

Array = NDArray[np.float64]

SHOVE_MOST = 2.0
"""Greatest push [m/s]."""


def body_in(mode: Mode) -> Any:
    """The body whose heading counts in a mode: biped while it stands, else crawl."""
    return BODIES["biped" if mode is Mode.BIPED else "crawl"]


def twist_of(body: Any, state: StateEstimate) -> Array:
    """(3,) vx, vy [m/s], wz [rad/s] in the body's heading frame."""
    v, w = heading_twist(body, state.q_OB, state.v_B, state.w_B)
    return np.array([v[0], v[1], w[2]])


def pose_of(body: Any, state: StateEstimate) -> Array:
    """(4,) x, y, z [m], yaw of the heading [rad]."""
    return np.array([*state.p_OB, float(heading_yaw(body.heading, state.q_OB))])


def push(robot: Any, mode: Mode, dv: float, bearing: float) -> None:
    """Shove a simulated robot by ``dv`` [m/s] towards ``bearing`` [rad] from its heading.

    Raises:
        InvalidInput: ``dv`` is none from 0 to :data:`SHOVE_MOST`.
    """
    if not 0.0 <= dv <= SHOVE_MOST:
        raise InvalidInput(f"push: expected 0 to {SHOVE_MOST:g} m/s, got {dv:g}")
    angle = pose_of(body_in(mode), robot.truth())[3] + bearing
    robot.push(dv * np.array([np.cos(angle), np.sin(angle)]), as_force=True)


def pull(robot: Any, xfrc: Any) -> None:
    """Pull at a simulated robot's bodies, (nbody, 6); forces of another scene are left out."""
    force = np.asarray(xfrc, dtype=float)
    if force.shape == robot.data.xfrc_applied.shape and np.isfinite(force).all():
        robot.pull(force)


def let_loose(robot: Any) -> None:
    """Nobody pulls any more."""
    robot.pull(np.zeros_like(robot.data.xfrc_applied))
