"""One axis of the admittance controller as a linear system: Eq. (20), (22), servo, contact.

The page with Eq. (19) to (22) is lost; this is the reconstruction, per axis:

    u = [K_f (W - W_ref) + z - D v - K (x - x_ref)] / M          (22), z = K_If z_f - K_Ix z_x
    z' = K_If (W - W_ref) - K_Ix (x - x_ref)
    W = -k_env x_s + d,   x_s' = (x - x_s) / tau

x is the commanded position, x_s where the servo really is, W the wrench of the environment on
the gripper, tared where it touched. The step is that of the controller itself
(:mod:`mobius.control.admittance.law`, semi-implicit), closed by the contact.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mobius import paper
from mobius.control.admittance.law import AxisGains, AxisLaw
from mobius.control.governor.admissible import AdmissibleSet
from mobius.control.governor.exact_set import exact_set
from mobius.control.governor.family_set import family_set
from mobius.control.governor.system import Constraints, Disturbance, LinearSystem
from mobius.errors import InvalidInput
from mobius.model.servo import XM430_W350, Servo

__all__ = ["AXES", "STATES", "Axis", "axis_set", "axis_system", "constraints_of"]

Array = NDArray[np.float64]

STATES = ("x", "v", "z", "x_s")
"""Commanded position [m], its rate [m/s], integral action [N], servo position [m]."""
SERVO_LAG = Servo(XM430_W350).damping / Servo(XM430_W350).kp
"""Of a wrist servo, back-EMF over stiffness [s]: 45 ms."""
REFERENCE_REACH = 3.0
"""|x_ref| may be this many times the position limit: a contact may hold the gripper back."""
DT = 1.0 / paper.RATES.admittance
"""Period of the force loop [s]."""


@dataclass(frozen=True)
class Axis:
    """Gains, limits and assumptions of one axis; for a torque axis read rad and N m.

    Raises:
        InvalidInput: A number is out of range.
    """

    name: str = "x"
    mass: float = 10.0
    """M [kg]."""
    damping: float = 120.0
    """D [N s/m]."""
    stiffness: float = 1000.0
    """K [N/m]."""
    force_gain: float = 1.0
    """K_f."""
    integral_position: float = 1000.0
    """K_Ix [N/(m s)]."""
    integral_force: float = 1.0
    """K_If [1/s]."""
    servo_lag: float = SERVO_LAG
    """tau [s], >= 0."""
    dt: float = DT
    """Period [s]."""
    position_max: float = 0.10
    """|x_s| may be this [m]."""
    velocity_max: float = 0.40
    """|v| may be this [m/s]; the servo is then no faster."""
    wrench_max: float = 40.0
    """|W| may be this [N]."""
    disturbance: float = 2.0
    """|d| of an outside force at any moment [N]."""
    environment: tuple[float, float] = (0.0, 500.0)
    """Least and greatest contact stiffness k_env [N/m]."""

    def __post_init__(self) -> None:
        for name in ("mass", "dt", "position_max", "velocity_max", "wrench_max"):
            self._check(name, getattr(self, name), strictly=True)
        for name in ("damping", "stiffness", "force_gain", "integral_position", "integral_force",
                     "servo_lag", "disturbance"):  # fmt: skip
            self._check(name, getattr(self, name))
        low, high = self.environment
        if not (0 <= low <= high < np.inf):
            raise InvalidInput(
                f"axis {self.name}: environment: expected 0 <= low <= high [N/m], got {low} {high}"
            )

    def _check(self, name: str, value: float, *, strictly: bool = False) -> None:
        if not np.isfinite(value) or value < 0 or (strictly and value == 0):
            sign = ">" if strictly else ">="
            raise InvalidInput(f"axis {self.name}: {name}: expected a number {sign} 0, got {value}")


AXES = (
    Axis("x"),
    Axis("y"),
    Axis("z"),
    Axis(
        "torque", mass=0.1, damping=1.2, stiffness=10.0, integral_position=10.0,
        position_max=0.5, velocity_max=2.0, wrench_max=2.0, disturbance=0.1,
        environment=(0.0, 5.0),
    ),
)  # fmt: skip
"""The paper's four: force along x, y, z and torque about the gripper's normal. The paper prints
neither gains nor limits; these are ours, the same per unit mass on all axes."""


def axis_system(axis: Axis, k_env: float) -> LinearSystem:
    """The loop of an axis against a stiffness.

    States :data:`STATES`; references x_ref [m], W_ref [N]; outputs x_s [m], v [m/s], W [N],
    x_ref, W_ref; disturbance d [N].

    Args:
        axis: Gains.
        k_env: Contact stiffness [N/m].

    Raises:
        InvalidInput: The loop is not stable.
    """
    gains = AxisGains(
        M=axis.mass, D=axis.damping, K=axis.stiffness, K_f=axis.force_gain,
        K_fi=axis.integral_force, K_pi=axis.integral_position,
    )  # fmt: skip
    law = AxisLaw(gains, axis.servo_lag, axis.dt, "semi_implicit").matrices()
    A = law.A + law.E @ np.array([[0.0, 0.0, 0.0, -k_env]])  # W = -k_env x_s + d
    B, E = law.B, law.E
    C, D, F = np.zeros((5, 4)), np.zeros((5, 2)), np.zeros((5, 1))
    C[0, 3], C[1, 1], C[2, 3] = 1.0, 1.0, -k_env
    D[3, 0], D[4, 1], F[2] = 1.0, 1.0, 1.0
    try:
        return LinearSystem(A, B, C, D, E, F)
    except InvalidInput as error:
        raise InvalidInput(f"axis {axis.name} at {k_env:g} N/m: {error}") from None


def constraints_of(axis: Axis) -> Constraints:
    """Limits of x_s, v, W, x_ref and W_ref.

    The references must be limited themselves: z makes up for one combination of the two, which
    no other limit would ever see.
    """
    limits = np.array(
        [axis.position_max, axis.velocity_max, axis.wrench_max,
         REFERENCE_REACH * axis.position_max, axis.wrench_max]
    )  # fmt: skip
    return Constraints.box(-limits, limits)


def axis_set(axis: Axis, *, epsilon: float = 0.02, tolerance: float = 0.01) -> AdmissibleSet:
    """The set of an axis for its disturbance and every stiffness of its interval.

    The stiffness may jump within the interval, so contact may be made and lost; against a wall
    that only pushes it is the wall's where it touches and 0 elsewhere.

    Args:
        axis: Gains, limits and assumptions.
        epsilon: Share of the limits that the steady state keeps free.
        tolerance: Relative loss of size that is accepted for fewer rows.
    """
    low, high = axis.environment
    limits, dist = constraints_of(axis), Disturbance.box([axis.disturbance])
    if low == high:
        return exact_set(axis_system(axis, low), limits, disturbance=dist, epsilon=epsilon,
                         tolerance=tolerance)  # fmt: skip
    return family_set(
        lambda k: axis_system(axis, k), axis.environment, limits, disturbance=dist,
        epsilon=epsilon, tolerance=tolerance,
    )  # fmt: skip


def with_margin(axis: Axis, share: float | Sequence[float]) -> Axis:
    """The axis with its limits a share tighter, for what the model leaves out.

    Args:
        axis: As declared.
        share: 0 <= share < 1; one for all limits, or one each for position, velocity and wrench.

    Raises:
        InvalidInput: Neither one share nor three, or out of range.
    """
    shares = np.atleast_1d(np.asarray(share, dtype=float))
    if shares.shape not in ((1,), (3,)) or not ((shares >= 0) & (shares < 1)).all():
        raise InvalidInput(
            "margin: expected one share, or three for position, velocity and wrench, each >= 0 and"
            f" < 1, got {share}"
        )
    position, velocity, wrench = (float(v) for v in np.broadcast_to(1.0 - shares, (3,)))
    return replace(
        axis,
        position_max=position * axis.position_max,
        velocity_max=velocity * axis.velocity_max,
        wrench_max=wrench * axis.wrench_max,
    )
