"""Two arms, one rigid bar: gains that suit one arm make two arms fight, and the tuner mends it.

Both grippers hold the bar through grips of stiffness k along the line between the hands. The
bar is light and floats: with y_1 and y_2 the servos' positions, f_1 = -f_2 = -k (y_1 - y_2) / 2.
While the other arm stands still an arm feels k / 2; when both comply they answer each other and
the internal force sees k. Damping that was just enough for one is then too little: the arms
pull against each other harder and harder (the failure of Sec. V-G4).

Both arms share their gains, so the internal coordinate (x_1 - x_2) / 2 obeys the same law as
each of them: the tuner gets that one axis.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mobius.control.admittance import (
    DT,
    SERVO_LAG,
    Admittance,
    AdmittanceConfig,
    AxisGains,
    Interval,
    Loop,
    Wrenches,
    spectral_radius,
)
from mobius.control.tuning import Report, Tuner
from mobius.errors import InvalidInput
from mobius.evaluate.contact import NOISE, SECOND_LAG, Contact, references

__all__ = ["TwoArms", "bad_gains", "hold_bar"]

Array = NDArray[np.float64]

AXIS = 1
"""The line between the hands: y of the law."""
GRIP = 15_000.0
"""Stiffness of one grip on the bar [N/m]."""
LAGS = (0.92, 1.08)
"""True servo lags of the arms, of the nominal."""
ZERO = (0.4, -0.3)
"""Zeros of the sensors [N]."""
SHORT = 0.99
"""Bad gains have this share of the damping that two arms need."""
LETS_GO = 120.0
"""Internal force at which a grip breaks; the run ends there [N] (Table IX, across)."""


@dataclass(frozen=True, eq=False)
class TwoArms:
    """A run."""

    t: Array
    """(n,) [s]; shorter than asked for where a grip broke."""
    internal: Array
    """(n,) true internal force (f_1 - f_2) / 2 [N]."""
    wished: Array
    """(n,) [N]."""
    broke: bool
    """A grip broke."""
    gains: AxisGains
    """At the end."""
    reports: list[tuple[float, Report]] = field(default_factory=list)

    def rmse(self, since: float = 0.0) -> float:
        """Error of the internal force from a moment on, root mean square [N]."""
        late = self.t >= since
        return float(np.sqrt(np.mean((self.internal - self.wished)[late] ** 2)))


def bad_gains(stiffness: float = GRIP) -> AxisGains:
    """Gains that were fine with one arm at a time: 1 % less damping than two arms need.

    Alone, against a partner that stands still, an arm feels half the stiffness and has with
    them a gain margin of almost 2.
    """
    both = Interval(stiffness, stiffness, lag=(1.0,))
    low, high = 1.0, 1e5
    while high / low > 1.0001:
        D = float(np.sqrt(low * high))
        low, high = (low, D) if spectral_radius(_gains(D), both, Loop())[0] < 1 else (D, high)
    return _gains(SHORT * high)


def _gains(D: float) -> AxisGains:
    return AxisGains(D=D, K=50.0, K_f=1.0, K_fi=0.1, K_pi=0.5)


def hold_bar(
    gains: AxisGains,
    *,
    seconds: float = 20.0,
    seed: int = 0,
    tuner: Tuner | None = None,
    stiffness: float = GRIP,
    both: bool = True,
) -> TwoArms:
    """Hold the bar while the wished squeeze changes between 5 and 15 N.

    Args:
        gains: Of both arms along the line between the hands.
        seconds: [s].
        seed: Of the wishes and the noise.
        tuner: Of the internal axis; its gains are used by both arms as they come.
        stiffness: Of a grip [N/m].
        both: False keeps the right arm still, as when one arm is set up at a time.
    """
    if seconds < DT:
        raise InvalidInput(f"hold_bar: expected seconds >= one tick, got {seconds}")
    n = round(seconds / DT)
    rng = np.random.default_rng(seed)
    wish = _squeeze(n, rng)
    law = Admittance([_config(gains)] * 2)
    plant = _Bar(stiffness, wish[0])
    loop, filtered = Loop(), np.array([wish[0], -wish[0]])
    internal, reports = np.zeros(n), []
    ready, calm = np.ones(2, dtype=bool), np.zeros((2, 6), dtype=bool)
    x_ref, w_ref, wrench = np.zeros((2, 6)), np.zeros((2, 6)), np.zeros((2, 6))
    end, clipped = n, False
    for k in range(n):
        f = plant.forces()
        internal[k] = 0.5 * (f[0] - f[1])
        if abs(internal[k]) > LETS_GO:
            end = k + 1
            break
        read = f + ZERO + NOISE * rng.standard_normal(2)
        if tuner is not None:
            report = _tune(tuner, law, read, wish[k], filtered, ok=not clipped)
            if report is not None:
                reports.append((k * DT, report))
        filtered = filtered + loop.filter_coefficient * (read - filtered)
        wrench[:, AXIS] = filtered
        w_ref[:, AXIS] = wish[k], -wish[k]
        motion = law.step(Wrenches(wrench, wrench, ready, calm), x_ref, w_ref)
        clipped = bool((motion.velocity_clipped | motion.position_clipped)[:, AXIS].any())
        command = motion.x[:, AXIS].copy()
        if not both:
            command[1] = 0.0
        plant.move(command)
    t: Array = np.arange(end, dtype=float) * DT
    last = AxisGains(*(float(v) for v in law.gains[0, AXIS]))
    return TwoArms(t, internal[:end], wish[:end], end < n, last, reports)


def _tune(
    tuner: Tuner, law: Admittance, read: Array, wish: float, filtered: Array, *, ok: bool
) -> Report | None:
    """Show the tuner the internal axis, and give both arms what it says."""
    s = law.state[:, AXIS]
    report = tuner.observe(
        0.5 * (s[:1] - s[1:]),
        [0.5 * (read[0] - read[1])],
        [wish],
        filtered=[0.5 * (filtered[0] - filtered[1])],
        ok=ok,
    )
    if report is not None and report.verdict in ("taken", "shrunk"):
        for arm in (0, 1):
            law.set_gains(arm, "y", report.gains)
    return report


def _config(g: AxisGains) -> AdmittanceConfig:
    def six(value: float, other: float) -> list[float]:
        return [value if i == AXIS else other for i in range(6)]

    return AdmittanceConfig(
        selected_axes=np.arange(6) == AXIS,
        mass=six(g.M, 1.0),  # type: ignore[arg-type]
        damping=six(g.D, 100.0),  # type: ignore[arg-type]
        stiffness=six(g.K, 0.0),  # type: ignore[arg-type]
        force_gain=six(g.K_f, 1.0),  # type: ignore[arg-type]
        integral_force=six(g.K_fi, 0.0),  # type: ignore[arg-type]
        integral_position=six(g.K_pi, 0.0),  # type: ignore[arg-type]
    )


def _squeeze(n: int, rng: np.random.Generator) -> Array:
    """(n,) wished internal force [N]."""
    w = references(Contact("wall", 1.0), n, rng)[:, 0]  # -25 to -8
    out: Array = 5.0 + (w + 8.0) * (-10.0 / 17.0)
    return out


class _Bar:
    """Two servos and the bar between them."""

    def __init__(self, stiffness: float, first: float) -> None:
        self._k = stiffness
        self._rest = first / stiffness  # the squeeze at the start
        lags = np.array([[lag * SERVO_LAG, SECOND_LAG] for lag in LAGS])
        self._keep = np.exp(-DT / lags)
        self._late = self._slow = self.y = np.zeros(2)

    def forces(self) -> Array:
        """(2,) by the bar on each gripper [N]."""
        internal = -self._k * (0.5 * (self.y[0] - self.y[1]) - self._rest)
        return np.array([internal, -internal])

    def move(self, command: Array) -> None:
        a, b = self._keep.T
        self._slow = self._late + a * (self._slow - self._late)
        self.y = self._slow + b * (self.y - self._slow)
        self._late = command
