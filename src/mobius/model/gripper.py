"""The hand's two fingers in the model: where the tips are, how wide and how hard they pinch.

Frame: the wrist centre, axes of ``gripper_base``: x along the finger pivots, y from finger b to
finger a, z towards the forearm; the fingers point along -z.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.errors import InvalidInput
from mobius.model import dimensions as dim
from mobius.model.servo import SERVOS

Array = NDArray[np.float64]


def finger_tips(q: ArrayLike) -> Array:
    """Centres (..., 2, 3) of the tips of finger a and b at gripper angle q (...) [m]."""
    q = np.asarray(q, dtype=float)
    c, s = np.cos(q), np.sin(q)
    ty, tz = dim.FINGER_TIP
    y = dim.FINGER_PIVOT[0] + ty * c + tz * s
    z = -dim.FINGER_PIVOT[1] + ty * s - tz * c
    x = np.zeros_like(y)
    return np.stack([np.stack([x, y, z], axis=-1), np.stack([x, -y, z], axis=-1)], axis=-2)


def gap(q: ArrayLike) -> Array:
    """Free width (...) between the finger tips at gripper angle q (...) [m]; < 0: pressed."""
    return np.asarray(2 * (finger_tips(q)[..., 0, 1] - dim.FINGER_RADIUS))


def pinch_angle(width: float) -> float:
    """Gripper angle [rad] at which both tips touch the faces of a bar ``width`` [m] thick.

    Raises:
        InvalidInput: The hand does not open so far, or cannot close so far.
    """
    low, high = dim.GRIPPER_RANGE
    ty, tz = dim.FINGER_TIP
    reach = np.hypot(ty, tz)
    need = 0.5 * width + dim.FINGER_RADIUS - dim.FINGER_PIVOT[0]
    # ty cos q + tz sin q = reach sin(q + atan2(ty, tz))
    q = float(np.arcsin(np.clip(need / reach, -1, 1)) - np.arctan2(ty, tz))
    if not (low <= q <= high):
        least, most = 1e3 * float(gap(low)), 1e3 * float(gap(high))
        raise InvalidInput(
            f"pinch_angle: expected a bar of {max(least, 0):.0f} to {most:.0f} mm,"
            f" got {1e3 * width:.0f} mm"
        )
    return q


def pinch_force(q: float) -> float:
    """Force [N] of each finger on a bar pinched at gripper angle q [rad], servo at its limit.

    The actuator's moment [A] is shared by two fingers over the height of pivot above tip.
    """
    arm = -float(finger_tips(q)[0, 2]) - dim.FINGER_PIVOT[1]
    return 0.5 * SERVOS["gripper"].stall_torque / arm


def grasp_map(p_G: ArrayLike) -> Array:
    """Eq. (19), reconstructed: G (6, 6 n) from the wrenches at n finger tips to that at the wrist.

    W_G = sum_k [[I, 0], [[p_k]x, I]] W_k with W = (f, tau), all in the gripper's frame G.

    Args:
        p_G: (n, 3) where the tips' wrenches act, from the point of W_G [m].
    """
    p = np.atleast_2d(np.asarray(p_G, dtype=float))
    if p.ndim != 2 or p.shape[1] != 3 or not np.isfinite(p).all():
        raise InvalidInput(f"grasp_map: expected finite points (n, 3) [m], got shape {p.shape}")
    G = np.zeros((6, 6 * len(p)))
    for k, (x, y, z) in enumerate(p):
        block = np.eye(6)
        block[3:, :3] = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]
        G[:, 6 * k : 6 * k + 6] = block
    return G
