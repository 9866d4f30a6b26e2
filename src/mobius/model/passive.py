"""The joints that no motor drives: coupler and distal link of every five-bar, in closed form.

The two crank angles of a limb fix the loop, and with it the angle between top crank and coupler
and the angle between bottom crank and distal link. Both depend on both cranks and not linearly,
so no mimic joint of a URDF can say them. The second finger of a gripper is none of these: it
mirrors the first exactly.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.model.dimensions import limb_geometry
from mobius.model.fivebar import Complex, FiveBar
from mobius.model.joints import LIMB_JOINTS
from mobius.types import LIMBS

Array = NDArray[np.float64]

PASSIVE: tuple[str, ...] = tuple(f"{limb}_{end}" for limb in LIMBS for end in ("coupler", "distal"))
"""Names of the eight, as in the MJCF, and their order in every (8,) vector."""


def passive_angles(q: ArrayLike) -> tuple[Array, Array]:
    """Coupler and distal joint angles (..., 4) [rad] that close the loops for q (..., 22).

    NaN where a loop cannot be closed. Order LIMBS.
    """
    q = np.asarray(q, dtype=float)
    both = [_angles(loop, q) for loop in _LOOPS]
    coupler, distal = (np.concatenate(kind, axis=-1) for kind in zip(*both, strict=True))
    return coupler, distal


def passive_joints(q: ArrayLike) -> Array:
    """All passive joint angles (..., 8) [rad] for q (..., 22), order :data:`PASSIVE`.

    NaN where a loop cannot be closed.
    """
    return _woven(*passive_angles(q))


def passive_rates(q: ArrayLike, dq: ArrayLike) -> Array:
    """Their rates (..., 8) [rad/s] for q and dq (..., 22) [rad, rad/s], order :data:`PASSIVE`.

    NaN where a loop cannot be closed, or is stretched.
    """
    q, dq = np.asarray(q, dtype=float), np.asarray(dq, dtype=float)
    both = [_rates(loop, q, dq) for loop in _LOOPS]
    return _woven(*(np.concatenate(kind, axis=-1) for kind in zip(*both, strict=True)))


class _Loop(NamedTuple):
    """The five-bars of two limbs of one kind."""

    fivebar: FiveBar
    a: NDArray[np.int64]
    """(2,) top cranks in a joint vector."""
    b: NDArray[np.int64]
    """(2,) bottom cranks."""


def _loop(*limbs: str) -> _Loop:
    first = np.array([LIMB_JOINTS[limb].start for limb in limbs])
    return _Loop(limb_geometry(limbs[0]).fivebar, first + 1, first + 2)


_LOOPS = (_loop(*LIMBS[:2]), _loop(*LIMBS[2:]))


def _woven(coupler: Array, distal: Array) -> Array:
    """(..., 4) and (..., 4) as (..., 8), limb by limb."""
    return np.stack([coupler, distal], axis=-1).reshape(*coupler.shape[:-1], len(PASSIVE))


def _angles(loop: _Loop, q: Array) -> tuple[Array, Array]:
    """Coupler and distal joints (..., 2) [rad]."""
    a, b = q[..., loop.a], q[..., loop.b]
    B, E, EC = loop.fivebar.loop(a, b)
    u, t = E + EC - B, loop.fivebar.to_T * EC
    return np.arctan2(u.imag, u.real) - a, np.arctan2(t.imag, t.real) - b


def _rates(loop: _Loop, q: Array, dq: Array) -> tuple[Array, Array]:
    """Their rates (..., 2): C moves with the distal link about E and with the coupler about B."""
    B, E, EC = loop.fivebar.loop(q[..., loop.a], q[..., loop.b])
    da, db = dq[..., loop.a], dq[..., loop.b]
    v_B, v_E = 1j * B * da, 1j * (E - loop.fivebar.w) * db
    u, d = E + EC - B, 1j * EC
    with np.errstate(invalid="ignore", divide="ignore"):
        distal = _dot(v_B - v_E, u) / _dot(d, u)
    coupler = _dot(1j * u, v_E + distal * d - v_B) / _dot(u, u)
    return coupler - da, distal - db


def _dot(a: Complex, b: Complex) -> Array:
    """Scalar product of plane vectors."""
    return np.asarray(a.real * b.real + a.imag * b.imag)
