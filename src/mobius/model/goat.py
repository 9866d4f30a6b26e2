"""The GOAT gripper's linkage: one linear actuator, a whippletree, two fingers (paper ref. [26]).

Plane of the gripper: x along the approach, y from finger N to finger M, origin where the
actuator is hinged. The actuator of length L may tilt by theta; its end D moves two bars. The
bar of side M is held at C by a crank hinged at B and goes on beyond C to G, on the finger:

    D = L (cos theta, sin theta),     |BC| = crank,   |CD| = bar,   G = C + tail / bar (C - D)
    |IH| = proximal, |HG| = distal,   M = G + tip / distal (G - H)

Side N is the mirror image at -theta. theta is free, the tree's one passive degree of freedom:
what one finger gives way by, the other closes by, and both press with the forces that leave
theta in balance. Sec. III-E: closed, the gripper is singular and this compliance is gone; here
that is d M_y / d theta = 0, which these lengths give where the tips are 2.2 mm apart.

Lengths [S] are those of the public SCALER hardware constants; which link meets which is [D] from
the same source. The MJCF's fingers are simpler, see :mod:`mobius.model.gripper`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mobius.errors import InvalidInput

Array = NDArray[np.float64]
_STEP = 1e-7
"""For derivatives [m, rad]."""


@dataclass(frozen=True)
class Goat:
    """Lengths of the linkage [m]."""

    base: float = 0.116
    """Crank pivots B and finger pivots I ahead of the actuator's hinge."""
    crank_y: float = 0.03724
    """Of the crank pivots, to either side."""
    finger_y: float = 0.004
    """Of the finger pivots, to either side."""
    crank: float = 0.02459
    bar: float = 0.04965
    tail: float = 0.010
    proximal: float = 0.04341
    distal: float = 0.02531
    tip: float = 0.01775

    def tips(self, L: float, theta: float = 0.0) -> Array:
        """Finger tips M and N (2, 2) [m] for actuator length L [m] and tilt theta [rad].

        Raises:
            InvalidInput: The linkage cannot be assembled there.
        """
        return np.array([self._side(L, theta), self._side(L, -theta) * [1.0, -1.0]])

    def _side(self, L: float, theta: float) -> Array:
        D = L * np.array([np.cos(theta), np.sin(theta)])
        C = _corner(np.array([self.base, self.crank_y]), D, self.crank, self.bar)
        if C is not None:
            G = C + (C - D) * (self.tail / self.bar)
            pivot = np.array([self.base, self.finger_y])
            H = _corner(pivot, G, self.proximal, self.distal)
            if H is not None:
                return np.asarray(G + (G - H) * (self.tip / self.distal))
        raise InvalidInput(
            f"Goat: the linkage cannot be assembled at L = {1e3 * L:.1f} mm,"
            f" theta = {theta:.3f} rad; expected L from 79 mm (closed) to 137 mm (open) and a"
            " small tilt"
        )

    def opening(self, L: float, theta: float = 0.0) -> float:
        """Distance [m] from tip to tip across the gripper; < 0 would be crossed."""
        M, N = self.tips(L, theta)
        return float(M[1] - N[1])

    def length(self, opening: float) -> float:
        """Actuator length [m] at which the tips stand ``opening`` [m] apart, without tilt.

        Raises:
            InvalidInput: Not between 0 and what the linkage opens to.
        """
        low, high = STROKE
        most = self.opening(high)
        if not 0.0 <= opening <= most:
            raise InvalidInput(
                f"Goat.length: expected an opening of 0 to {1e3 * most:.0f} mm,"
                f" got {1e3 * opening:.1f} mm"
            )
        for _ in range(50):  # halving; opening grows with L over the stroke
            mid = 0.5 * (low + high)
            low, high = (mid, high) if self.opening(mid) < opening else (low, mid)
        return 0.5 * (low + high)

    def jacobian(self, L: float, theta: float = 0.0) -> Array:
        """(2, 2) how far each finger opens, M outwards and N outwards (rows), by L and by theta
        (columns) [1, m/rad].
        """
        outward = np.array([1.0, -1.0])
        dL = self.tips(L + _STEP, theta) - self.tips(L - _STEP, theta)
        dt = self.tips(L, theta + _STEP) - self.tips(L, theta - _STEP)
        return np.column_stack([dL[:, 1] * outward, dt[:, 1] * outward]) / (2 * _STEP)

    def finger_forces(self, thrust: float, L: float, theta: float = 0.0) -> Array:
        """Normal forces (2,) [N] with which M and N press on what they hold.

        Virtual work of the actuator's closing ``thrust`` [N] and of the two forces n, theta
        free: jacobian^T n = (thrust, 0).

        Raises:
            InvalidInput: The gripper is singular (closed): how fingers share is then not the
                whippletree's to say.
        """
        J = self.jacobian(L, theta)
        if min(abs(J[:, 1])) < RIGID:
            raise InvalidInput(
                f"Goat.finger_forces: at L = {1e3 * L:.1f} mm the gripper is rigid (singular) and"
                " any sharing is in balance; expected an open gripper"
            )
        return np.asarray(np.linalg.solve(J.T, [thrust, 0.0]))


STROKE = (0.0786, 0.137)
"""Actuator lengths [m] that the linkage makes use of: tips together, tips widest [D]."""
RIGID = 2e-3
"""Tips that a tilt moves by less than this [m/rad] count as not moving."""


def _corner(A: Array, P: Array, a: float, b: float) -> Array | None:
    """Point at a [m] from A and b [m] from P, left of the way from A to P, if there is one."""
    d = P - A
    r = float(np.hypot(d[0], d[1]))
    cosine = (r * r + a * a - b * b) / (2 * r * a) if r > 0 else 2.0
    if abs(cosine) > 1:
        return None
    angle = np.arctan2(d[1], d[0]) + np.arccos(cosine)
    return np.asarray(A + a * np.array([np.cos(angle), np.sin(angle)]))
