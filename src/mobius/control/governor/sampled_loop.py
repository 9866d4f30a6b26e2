"""Algorithm 3 as printed, line by line, one sample and one step at a time.

Only for comparison: :func:`mobius.control.governor.algorithm_3` returns the same set.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from mobius.control.governor.plant import Axis

__all__ = ["algorithm_3_loop"]


def algorithm_3_loop(
    axis: Axis, samples: Iterable[Iterable[float]], *, horizon_s: float = 2.0
) -> NDArray[np.float64]:
    """The propagated states (n, 5) of the samples that stay within position and velocity.

    Args:
        axis: Gains and limits.
        samples: Of x, v, x_ref, W, W_ref.
        horizon_s: T [s].
    """
    D_d, K_d, K_f = axis.damping, axis.stiffness, axis.force_gain
    K_Ix, K_If, dt = axis.integral_position, axis.integral_force, axis.dt
    o_inf: list[tuple[float, ...]] = []
    for x_cur, v_cur, x_ref, W_cur, W_ref in samples:  # line 5
        valid = True
        z_x, z_f = 0.0, 0.0  # line 7; nothing integrates them
        for _ in range(round(horizon_s / dt) + 1):  # line 8: t = 0 to T / dt
            u = (
                K_f * (W_cur - W_ref) + K_If * z_f
                - D_d * v_cur - K_d * (x_cur - x_ref) - K_Ix * z_x
            ) / axis.mass  # fmt: skip
            x_cur = x_cur + v_cur * dt + 0.5 * u * dt**2
            v_cur = v_cur + u * dt
            if abs(x_cur) > axis.position_max or abs(v_cur) > axis.velocity_max:
                valid = False
            if not valid:
                break
        if valid:  # line 17: the propagated state
            o_inf.append((x_cur, v_cur, x_ref, W_cur, W_ref))
    return np.array(o_inf).reshape(-1, 5)
