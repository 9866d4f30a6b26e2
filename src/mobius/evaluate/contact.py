"""A small simulator of a gripper in contact: what the tuner is judged on.

A position servo carries the gripper against something that behaves like springs. It is not
the model the tuner believes in: the servo has two lags, the larger of which differs from the
nominal, the command arrives a tick late, the wrench has noise and a drifting zero, the contact
moves and rubs. The servo itself does not give way, so that the stiffness of the contact is
felt in full.

=====  ==========================================================================================
kind   axes under force control
=====  ==========================================================================================
wall   its normal, pressed while the gripper wipes along it; the wall is wavy, and can only push
bar    across a bar and along the approach, coupled; what is held sways
peg    two across the hole, one along it, coupled; along it the peg rubs
=====  ==========================================================================================
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mobius.control.admittance import DT, SERVO_LAG
from mobius.control.admittance.law import batch_steps
from mobius.errors import InvalidInput, UnknownName

__all__ = ["KINDS", "Contact", "ContactPlant", "references"]

Array = NDArray[np.float64]

_SHAPES: dict[str, list[list[float]]] = {
    "wall": [[1.0]],
    "bar": [[1.0, 0.2], [0.2, 0.4]],
    "peg": [[1.0, 0.0, 0.15], [0.0, 1.0, 0.1], [0.15, 0.1, 0.3]],
}
"""Stiffness matrices, as shares of the contact's stiffness."""
_LEVELS: dict[str, list[tuple[float, float]]] = {
    "wall": [(-25.0, -8.0)],
    "bar": [(10.0, 40.0), (-8.0, 8.0)],
    "peg": [(-4.0, 4.0), (-4.0, 4.0), (-20.0, -8.0)],
}
"""Wished wrench of each axis: range of its levels [N]."""
KINDS = tuple(_SHAPES)
Seed = int | Sequence[int]

SECOND_LAG = 0.006
"""Of the servo: current loop and rotor [s]."""
LAG_SPREAD = 0.2
"""The main lag differs from the nominal by up to this share."""
NOISE = 0.15
"""White noise of the wrench [N] (as :mod:`mobius.sense.noise`)."""
DRIFT = 0.1
"""Its zero after one minute [N]."""
SWAY_FORCE, SWAY_MOST = 4.0, 2e-3
"""The contact moves by what this force [N] would push it, at most this far [m]."""
RUB, RUB_SPEED = 0.15, 1e-3
"""Friction coefficient along the peg, and the speed at which it is full [m/s]."""
HOLD_S, RAMP_S = 1.5, 0.1
"""A level is wished this long; the wish gets there with this time constant [s]."""


@dataclass(frozen=True)
class Contact:
    """What is touched."""

    kind: str
    """wall, bar or peg."""
    stiffness: float
    """Of its stiffest axis [N/m], > 0."""

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise UnknownName("contact", self.kind, KINDS)
        if not 0 < self.stiffness < np.inf:
            raise InvalidInput(f"Contact.stiffness: expected N/m > 0, got {self.stiffness}")

    @property
    def K(self) -> Array:
        """(n, n) [N/m]."""
        return self.stiffness * np.array(_SHAPES[self.kind])

    @property
    def n(self) -> int:
        """Axes."""
        return len(_SHAPES[self.kind])


def references(contact: Contact, ticks: int, rng: np.random.Generator) -> Array:
    """(ticks, n) wished wrench [N]: levels drawn anew every so often, smoothly reached."""
    low, high = np.array(_LEVELS[contact.kind]).T
    hold = round(HOLD_S / DT)
    levels = rng.uniform(low, high, (ticks // hold + 2, contact.n))
    levels[0] = 0.5 * (low + high)
    # axes change one after the other
    out = np.empty((ticks, contact.n))
    for i in range(contact.n):
        at = (np.arange(ticks) + i * hold // contact.n) // hold
        out[:, i] = levels[at, i]
    share = DT / (RAMP_S + DT)
    w = out[0].copy()
    for k in range(ticks):
        w = w + share * (out[k] - w)
        out[k] = w
    return out


class ContactPlant:
    """Servo and contact, one tick at a time; starts at rest with the first wish fulfilled."""

    def __init__(
        self, contact: Contact, first: Array, *, seed: Seed, tau: float = SERVO_LAG
    ) -> None:
        """A plant.

        Args:
            contact: What is touched.
            first: (n,) wrench at the start with the command at zero [N].
            seed: Of lag, noise, drift and sway.
            tau: Nominal servo lag [s].
        """
        self.contact, self.n = contact, contact.n
        body, self._rng = np.random.default_rng(seed).spawn(2)
        self.tau = tau * float(body.uniform(1 - LAG_SPREAD, 1 + LAG_SPREAD))
        """The servo's true main lag [s]."""
        self._K = contact.K
        self._keep = np.exp(-DT / np.array([self.tau, SECOND_LAG]))
        self._rest = np.linalg.solve(self._K, np.asarray(first, dtype=float))
        amplitude = np.minimum(SWAY_FORCE / np.diag(self._K), SWAY_MOST)
        self._sway = amplitude[:, None] * body.uniform(0.3, 1.0, (self.n, 2)) / 2
        self._pace = 2 * np.pi * body.uniform(0.1, 1.0, (self.n, 2))
        self._phase = body.uniform(0, 2 * np.pi, (self.n, 2))
        self._sway0 = (self._sway * np.sin(self._phase)).sum(axis=1)
        self._late = self._first = self._y = np.zeros(self.n)
        self._speed = np.zeros(self.n)
        self._zero = np.zeros(self.n)
        self._tick = 0

    def read(self) -> tuple[Array, Array]:
        """True wrench (n,) on the gripper, and as the sensor says it [N]."""
        t = self._tick * DT
        sway = (self._sway * np.sin(self._pace * t + self._phase)).sum(axis=1) - self._sway0
        f = -self._K @ (self._y - sway - self._rest)
        if self.contact.kind == "wall":
            f = np.minimum(f, 0.0)
        if self.contact.kind == "peg":
            press = 1.0 + RUB * float(np.hypot(f[0], f[1]))
            f[2] -= press * np.tanh(self._speed[2] / RUB_SPEED)
        draw = self._rng.standard_normal((2, self.n))
        self._zero = self._zero + DRIFT * np.sqrt(DT / 60.0) * draw[0]
        return f, f + self._zero + NOISE * draw[1]

    def move(self, command: Array) -> None:
        """One tick of the servo towards the command (n,) [m] of the tick before."""
        a, b = self._keep
        self._first = self._late + a * (self._first - self._late)
        y = self._first + b * (self._y - self._first)
        self._speed = (y - self._y) / DT
        self._y, self._late = y, command.copy()
        self._tick += 1

    def closed_loop(self, gains: Array, filter_coefficient: float) -> float:
        """Spectral radius of the law with this very servo and contact, friction left out.

        Args:
            gains: (6,) M, D, K, K_f, K_fi, K_pi, shared by all axes.
            filter_coefficient: Of the wrench filter.
        """
        A4, _B, E4 = (m[0] for m in batch_steps(np.asarray(gains)[None], 0.0))
        (a, b), c = self._keep, filter_coefficient
        worst = 0.0
        for k in np.linalg.eigvalsh(self._K):
            # x, v, z, first lag, y, filtered wrench, command before
            A = np.zeros((7, 7))
            A[:3, :3] = A4[:3, :3]
            wrench = np.zeros(7)
            wrench[4], wrench[5] = -c * k, 1 - c
            A[:3] += E4[:3] * wrench
            A[3, 3], A[3, 6] = a, 1 - a
            A[4, 3], A[4, 6], A[4, 4] = (1 - b) * a, (1 - b) * (1 - a), b
            A[5] = wrench
            A[6, 0] = 1.0
            if gains[4] == 0 and gains[5] == 0:
                A[2] = 0.0
            worst = max(worst, float(np.abs(np.linalg.eigvals(A)).max()))
        return worst
