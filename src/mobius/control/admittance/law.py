"""The admittance law of one axis, Eq. (20) and (22), and its discretisation at 300 Hz.

The page of the paper that holds Eq. (19)-(22) is lost; this is a reconstruction from the
names of the gains in Alg. 3 and from what Sec. V-G4 says of the steady state::

    M u = K_f (W - W_ref) + z - D v - K (x - x_ref)                      (22)
    x' = v,   v' = u,   z' = K_fi (W - W_ref) - K_pi (x - x_ref)

x is the commanded position, W the wrench the environment puts on the gripper, and z [N] is
both integrals of the paper in one state, z = K_fi z_f - K_pi z_x: they enter the law only in
this combination, and kept apart they would leave an eigenvalue 1 that no gain can move. The
servo follows the command with a lag, y' = (x - y) / tau.

Between two ticks everything measured or asked for is constant, so the exact step is a matrix
exponential. The paper's explicit step has the eigenvalue 1 - D dt / M for v: with the gains
that are public for this robot family (M 0.7, D 250) it is -0.19, and the sign of v alternates.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from mobius.errors import InvalidInput, UnknownName

__all__ = ["DT", "SERVO_LAG", "AxisGains", "AxisLaw", "Lti", "Method", "batch_steps"]

Array = NDArray[np.float64]

DT = 1 / 300
"""Period of the force loop [s], Sec. V-A."""
SERVO_LAG = 0.045
"""Lag of a position servo [s]: slope of its torque-speed line over its stiffness, which is the
same for one motor and for a pair (``model.servo``: damping / kp of an XM430-W350)."""
Method = Literal["exact", "semi_implicit", "explicit"]
METHODS = ("exact", "semi_implicit", "explicit")
STATES = ("x", "v", "z", "y")
"""Commanded position [m], its velocity [m/s], integral [N], position of the servo [m]; for an
axis of rotation rad, rad/s, N m, rad."""


@dataclass(frozen=True)
class AxisGains:
    """Gains of one axis; rotation in brackets: rad for m, N m for N."""

    M: float = 0.7
    """Virtual mass [kg]; 0.7 is public for this robot family."""
    D: float = 250.0
    """Damping [N s/m]."""
    K: float = 0.0
    """Stiffness [N/m]."""
    K_f: float = 1.0
    """Gain on the wrench error [-]."""
    K_fi: float = 0.0
    """Gain on its integral [1/s]."""
    K_pi: float = 0.0
    """Gain on the integral of the position error [N/(m s)]."""

    def __post_init__(self) -> None:
        for f in fields(self):
            value = getattr(self, f.name)
            above = f.name in ("M", "D")
            if not (np.isfinite(value) and (value > 0 if above else value >= 0)):
                raise InvalidInput(
                    f"AxisGains.{f.name}: expected a number {'>' if above else '>='} 0, got {value}"
                )
        if self.K_pi > 0 and self.M * self.K_pi >= self.D * self.K:
            raise InvalidInput(
                "AxisGains: the free axis is unstable; expected D K > M K_pi, got"
                f" {self.D:g} * {self.K:g} <= {self.M:g} * {self.K_pi:g}; raise D or K, or"
                f" take K_pi below {self.D * self.K / self.M:g}"
            )


class Lti(NamedTuple):
    """x+ = A x + B r + E f, out = C x; x = (x, v, z, y), r = (x_ref, W_ref), f = (W,)."""

    A: Array
    """(4, 4)."""
    B: Array
    """(4, 2)."""
    E: Array
    """(4, 1)."""
    C: Array
    """(3, 4): commanded position, its velocity, position of the servo."""


_C = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
_C.setflags(write=False)


@dataclass(frozen=True)
class AxisLaw:
    """One axis: gains, servo lag, tick and how the tick is computed."""

    gains: AxisGains = AxisGains()
    tau: float = SERVO_LAG
    """Servo lag [s]; 0 is a perfect servo."""
    dt: float = DT
    """Tick [s]."""
    method: Method = "exact"
    """``exact``, ``semi_implicit`` (damping at the end of the tick) or ``explicit`` (Alg. 3)."""

    def __post_init__(self) -> None:
        if self.method not in METHODS:
            raise UnknownName("discretisation", self.method, METHODS)
        if not (np.isfinite(self.tau) and self.tau >= 0):
            raise InvalidInput(f"AxisLaw.tau: expected seconds >= 0, got {self.tau}")
        if not (np.isfinite(self.dt) and self.dt > 0):
            raise InvalidInput(f"AxisLaw.dt: expected seconds > 0, got {self.dt}")

    def matrices(self) -> Lti:
        """The law as a linear system; the arrays are read-only."""
        return _matrices(self)


@lru_cache(maxsize=256)
def _matrices(law: AxisLaw) -> Lti:
    g = law.gains
    row = np.array([[g.M, g.D, g.K, g.K_f, g.K_fi, g.K_pi]])
    step = {"exact": batch_steps, "semi_implicit": _semi_implicit, "explicit": _explicit}
    A, B, E = (m[0] for m in step[law.method](row, law.tau, law.dt))
    for m in (A, B, E):
        m.setflags(write=False)
    return Lti(A, B, E, _C)


def _rates(gains: Array) -> tuple[Array, Array]:
    """Continuous (k, 3, 3) of (x, v, z) and (k, 3, 3) of the inputs (x_ref, W_ref, W)."""
    M, D, K, K_f, K_fi, K_pi = np.moveaxis(gains, -1, 0)
    F, G = np.zeros((*M.shape, 3, 3)), np.zeros((*M.shape, 3, 3))
    F[..., 0, 1] = 1.0
    F[..., 1, 0], F[..., 1, 1], F[..., 1, 2] = -K / M, -D / M, 1.0 / M
    F[..., 2, 0] = -K_pi
    G[..., 1, 0], G[..., 1, 1], G[..., 1, 2] = K / M, -K_f / M, K_f / M
    G[..., 2, 0], G[..., 2, 1], G[..., 2, 2] = K_pi, -K_fi, K_fi
    return F, G


def batch_steps(gains: Array, tau: float, dt: float = DT) -> tuple[Array, Array, Array]:
    """Exact A (k, 4, 4), B (k, 4, 2), E (k, 4, 1) of many axes at once.

    Args:
        gains: (k, 6) M, D, K, K_f, K_fi, K_pi.
        tau: Servo lag [s].
        dt: Tick [s].
    """
    F, G = _rates(gains)
    k = len(gains)
    block = np.zeros((k, 7, 7))
    block[:, :3, :3], block[:, :3, 4:] = F, G
    if tau > 0:
        block[:, 3, 0], block[:, 3, 3] = 1.0 / tau, -1.0 / tau
    step = expm(block * dt)
    if tau == 0:
        step[:, 3] = step[:, 0]
    return step[:, :4, :4].copy(), step[:, :4, 4:6].copy(), step[:, :4, 6:].copy()


def _with_servo(A3: Array, G3: Array, tau: float, dt: float) -> tuple[Array, Array, Array]:
    """A step of (x, v, z) with the servo appended: it follows the command held over the tick."""
    k = len(A3)
    A, G = np.zeros((k, 4, 4)), np.zeros((k, 4, 3))
    A[:, :3, :3], G[:, :3] = A3, G3
    keep = float(np.exp(-dt / tau)) if tau > 0 else 0.0
    A[:, 3, :3], G[:, 3] = (1 - keep) * A3[:, 0], (1 - keep) * G3[:, 0]
    A[:, 3, 3] = keep
    return A, G[:, :, :2].copy(), G[:, :, 2:].copy()


def _explicit(gains: Array, tau: float, dt: float) -> tuple[Array, Array, Array]:
    """Line 10 of Alg. 3: x += v dt + u dt^2 / 2, v += u dt."""
    F, G = _rates(gains)
    A, B = np.eye(3) + dt * F, dt * G
    A[:, 0] += 0.5 * dt * dt * F[:, 1]
    B[:, 0] += 0.5 * dt * dt * G[:, 1]
    return _with_servo(A, B, tau, dt)


def _semi_implicit(gains: Array, tau: float, dt: float) -> tuple[Array, Array, Array]:
    """V at the end of the tick in damping and in x, the rest at its beginning."""
    F, G = _rates(gains)
    A, B = np.eye(3) + dt * F, dt * G
    slow = 1.0 / (1.0 - dt * F[:, 1, 1])
    A[:, 1] = slow[:, None] * (np.eye(3)[1] + dt * F[:, 1] * [1.0, 0.0, 1.0])
    B[:, 1] *= slow[:, None]
    A[:, 0], B[:, 0] = np.eye(3)[0] + dt * A[:, 1], dt * B[:, 1]
    return _with_servo(A, B, tau, dt)
