"""The loop: the only file that knows all rooms."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mobius.types import GridMap, Plan

Array = NDArray[np.float64]


@dataclass(eq=False)
class RunRecord:
    """Everything one run leaves for the report, the plots and the video.

    Rows are samples at 60 Hz unless said otherwise; n samples, m video frames.
    """

    t: Array
    """(n,) [s]."""
    q: Array
    """(n, 22) joint angles [rad]."""
    q_target: Array
    """(n, 22) what ``robot.write`` let through [rad]."""
    torque: Array
    """(n, 22) servo torque [N m]."""
    power: Array
    """(n,) mechanical power, sum of |torque * rate| [W]."""
    true_p: Array
    """(n, 3) trunk position in M [m]."""
    true_rpy: Array
    """(n, 3) trunk roll, pitch, yaw [rad]."""
    true_twist_H: Array
    """(n, 3) vx, vy [m/s], wz [rad/s] in the heading frame."""
    belief_p: Array
    """(n, 3) [m], frame M."""
    belief_rpy: Array
    """(n, 3) [rad]."""
    belief_twist_H: Array
    """(n, 3)."""
    cmd_twist_H: Array
    """(n, 3) commanded."""
    contact_force: Array
    """(n, 4) true normal force per limb end [N], order LIMBS."""
    contact_belief: Array
    """(n, 4) believed contact probability."""
    modes: list[str]
    """n mode names."""
    frame_t: Array
    """(m,) [s] video frames, 30 Hz."""
    frame_qpos: Array
    """(m, nq) full simulator configuration, for rendering."""
    grid: GridMap
    plan: Plan
    summary: dict[str, Any] = field(default_factory=dict)
    """What ``summary.json`` holds."""
