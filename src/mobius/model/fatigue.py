"""Why the legs have larger gear teeth: bending stress, Eq. (1), and the S-N curve of Fig. 5.

What is printed and what is not (Sec. III-D). Printed: the factors K_a and K_m, the peak
torque, two stresses with their lives, and the module of the arm's gears. Not printed:
tooth counts, face widths, the geometry factor J and the leg's module. With the
tangential load per unit width F_t = T / (r b), Eq. (1) at unit remaining factors is

    sigma_b = T K_a K_m / (m A),    A = r b J

so everything unknown about the arm's gear is one product, the *load area* A. It is
**calibrated** here from the printed stress at module 0.4 mm: A = 19.0 mm^2. Holding A and
asking for the leg's printed stress gives a module of 0.795 mm, close to the standard
0.8 mm (which would give 493 MPa). Both printed stresses are therefore inputs, not
predictions; what the functions add is how stress moves with torque and module, and what
life follows. If instead tooth count, width and J were held (r = m z / 2), stress would go
as 1 / m^2 and the same ratio would mean 0.564 mm.

The S-N curve is Basquin's power law through the two printed points (row 60): S = 5222 MPa
* N^-0.1877. It knows no endurance limit, so do not read lives far beyond those points.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import log

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.errors import InvalidInput
from mobius.paper import GEAR_FATIGUE

__all__ = [
    "ARM_GEAR",
    "LEG_GEAR",
    "SN_COEFFICIENT",
    "SN_EXPONENT",
    "Gear",
    "bending_stress",
    "cycles_to_failure",
    "stress_for_life",
]

Array = NDArray[np.float64]

_P = GEAR_FATIGUE

SN_EXPONENT = log(_P.arm_stress / _P.leg_stress) / log(_P.leg_life / _P.arm_life)
"""Slope k of the S-N line, S = S_1 N^-k."""
SN_COEFFICIENT = _P.leg_stress * _P.leg_life**SN_EXPONENT
"""S_1 [Pa]: the stress that the line gives for one cycle."""


def bending_stress(
    F_t: ArrayLike,
    m: ArrayLike,
    *,
    J: ArrayLike,
    K_a: float = _P.K_a,
    K_m: float = _P.K_m,
    K_v: float = 1.0,
    K_S: float = 1.0,
    K_B: float = 1.0,
    K_I: float = 1.0,
) -> Array:
    """Bending stress at the root of a spur-gear tooth, Eq. (1).

    Args:
        F_t: Tangential load per unit face width [N/m], any shape.
        m: Module [m].
        J: Geometry factor, dimensionless.
        K_a: Application factor.
        K_m: Load-distribution factor (printed as K_o in the text, row 60).
        K_v: Dynamic factor.
        K_S: Size factor.
        K_B: Rim-thickness factor.
        K_I: Idler factor.

    Returns:
        sigma_b [Pa], broadcast shape.
    """
    m, J = _positive("module m", m, "m"), _positive("geometry factor J", J, "")
    return np.asarray(F_t, dtype=float) / (m * J) * (K_a * K_m / K_v) * (K_S * K_B * K_I)


def cycles_to_failure(sigma: ArrayLike) -> Array:
    """Load cycles until a tooth of 1045 steel breaks at stress ``sigma`` [Pa], Fig. 5."""
    return (SN_COEFFICIENT / _positive("stress sigma", sigma, "Pa")) ** (1.0 / SN_EXPONENT)


def stress_for_life(N: ArrayLike) -> Array:
    """Stress [Pa] that a tooth of 1045 steel survives for ``N`` cycles, Fig. 5."""
    return SN_COEFFICIENT * _positive("life N", N, "cycles") ** -SN_EXPONENT


@dataclass(frozen=True)
class Gear:
    """The most loaded gear of a five-bar drive, as far as the paper lets one know it."""

    m: float
    """Module [m]."""
    load_area: float
    """A = r b J [m^2]: pitch radius, face width, geometry factor. Calibrated, see above."""

    def stress(self, torque: ArrayLike) -> Array:
        """Bending stress [Pa] at the drive's torque [N m]; the sign of torque is ignored."""
        load = np.abs(np.asarray(torque, dtype=float)) / self.load_area  # F_t / J
        return bending_stress(load, self.m, J=1.0)

    def life(self, torque: ArrayLike) -> Array:
        """Cycles to failure at a repeated peak torque [N m] other than 0."""
        return cycles_to_failure(self.stress(torque))


def _positive(what: str, value: ArrayLike, unit: str) -> Array:
    array = np.asarray(value, dtype=float)
    if not (array > 0).all():
        raise InvalidInput(f"{what}: expected {f'{unit} ' if unit else ''}> 0, got {value!r}")
    return array


_LOAD_AREA = _P.peak_torque * _P.K_a * _P.K_m / (_P.arm_module * _P.arm_stress)

ARM_GEAR = Gear(m=_P.arm_module, load_area=_LOAD_AREA)
"""Module printed, load area calibrated from 986 MPa at 2.5 N m."""

LEG_GEAR = Gear(m=_P.arm_module * _P.arm_stress / _P.leg_stress, load_area=_LOAD_AREA)
"""Load area of the arm's gear; module inferred from 496 MPa at 2.5 N m."""
