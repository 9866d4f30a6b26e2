"""Tunes the gains of an axis group while the robot works.

Each window of ticks gives one measurement. The gains' logarithms are the state of the filter
(they stay positive), the specification of :mod:`mobius.control.tuning.specification` is its
measurement, and the wish is zero. The prediction of h at the gains in use is corrected by what
was really measured with them. A step is taken only if

- the closed loop stays stable over the interval of stiffnesses and lags, with damping, and
- the replayed window does not get worse;

else it is halved up to four times, then refused. Without excitation nothing moves.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import isfinite
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.control.admittance.law import AxisGains
from mobius.control.admittance.stability import Interval, Loop, damping, spectral_radius
from mobius.control.tuning.specification import SIZE, Specification, Window, measured, predicted
from mobius.control.tuning.stiffness import ContactEstimate, StiffnessEstimator
from mobius.control.tuning.ukf import SquareRootUkf
from mobius.errors import InvalidInput

__all__ = ["Report", "Tuner", "TunerConfig"]

Array = NDArray[np.float64]

NAMES = ("D", "K", "K_f", "K_fi", "K_pi")
"""Gains that are tuned; those that are 0 stay 0, and so does the mass."""
Verdict = Literal["taken", "shrunk", "refused", "waiting", "skipped"]
HALVINGS = 4


@dataclass(frozen=True)
class TunerConfig:
    """How the tuner goes about it."""

    window: float = 1.5
    """Length of a window [s]."""
    period: float = 0.5
    """Time between two measurements [s]."""
    spread: float = 0.5
    """Standard deviation of each log-gain at the start."""
    walk: float = 0.15
    """Standard deviation of its walk per measurement at first."""
    walk_end: float = 0.02
    """And in the long run."""
    calm: float = 5.0
    """Time constant from the one to the other [s]; a contact that turns out to be twice as
    stiff or half as stiff as at the last start starts anew."""
    stay: float = 0.15
    """Pull of each log-gain to where it started, in units of the specification: it keeps gains
    that do not matter (or only their ratio) from wandering."""
    noise: float = 1.0
    """Standard deviation of the measurement, in units of the specification."""
    step_max: float = 0.7
    """Largest change of a log-gain per measurement; 0.7 is a factor of 2."""
    range: float = 300.0
    """A gain stays within this factor of where it started."""
    interval: float = 1.5
    """The loop must stay stable with contacts stiffer and softer than estimated by at least
    this factor (more where the estimate is poor)."""
    spread_max: float = 1.5
    """Nothing moves while the stiffness is known less well than this, relative."""
    damping_floor: float = 0.15
    """No step may leave a pole over the interval with less."""

    def __post_init__(self) -> None:
        for name in ("window", "period", "spread", "walk", "noise", "step_max"):
            if not getattr(self, name) > 0:
                raise InvalidInput(f"TunerConfig.{name}: expected a number > 0")
        if self.interval < 1 or self.range <= 1:
            raise InvalidInput("TunerConfig: expected interval >= 1 and range > 1")


@dataclass(frozen=True, eq=False)
class Report:
    """One measurement."""

    verdict: Verdict
    gains: AxisGains
    """To use from now on."""
    specification: Array
    """(4,) as measured over the window: force, position, slip, manipulability."""
    force_rmse: float
    """Over the window [N]."""
    contact: ContactEstimate | None
    radius: float | None
    """Spectral radius over the interval with these gains; None while waiting."""


class Tuner:
    """One axis group: n axes that share their gains."""

    def __init__(
        self,
        gains: AxisGains,
        n: int = 1,
        *,
        loop: Loop | None = None,
        specification: Specification | None = None,
        config: TunerConfig | None = None,
    ) -> None:
        """A tuner.

        Args:
            gains: In use at the start.
            n: Axes of the group.
            loop: Nominal servo lag, tick, filter, delay.
            specification: What is wished.
            config: How to go about it.
        """
        if n < 1:
            raise InvalidInput(f"Tuner.n: expected at least one axis, got {n}")
        self.gains, self.n = gains, n
        self.loop, self.specification = loop or Loop(), specification or Specification()
        self.config = c = config or TunerConfig()
        self.names = tuple(k for k in NAMES if getattr(gains, k) > 0)
        L = len(self.names)
        theta = np.log([getattr(gains, k) for k in self.names])
        self._home, self._wide = theta.copy(), float(np.log(c.range))
        self.filter = SquareRootUkf(
            theta,
            P=c.spread**2 * np.eye(L),
            Q=c.walk**2 * np.eye(L),
            R=c.noise**2 * np.eye(SIZE + L),
        )
        self._length = round(c.window / self.loop.dt)
        self._every = round(c.period / self.loop.dt)
        self._contact = StiffnessEstimator(n, dt=self.loop.dt)
        self._known: float | None = None
        self._age = 0.0
        self.forget()

    def forget(self) -> None:
        """Drop what was seen so far, e.g. after a drop-out; gains and estimates stay."""
        self._rows: list[Array] = []
        self._states: list[Array] = []
        self._since = 0

    def observe(
        self,
        state: ArrayLike,
        wrench: ArrayLike,
        reference: ArrayLike,
        *,
        filtered: ArrayLike,
        x_ref: ArrayLike = 0.0,
        ok: bool = True,
    ) -> Report | None:
        """See one tick, before the law steps.

        Args:
            state: (n, 4) x, v, z, y of the law.
            wrench: (n,) as read now, compensated, not filtered [N].
            reference: (n,) wished [N].
            filtered: (n,) output of the wrench filter before this reading [N].
            x_ref: (n,) [m].
            ok: False where the tick says nothing: wrench lost, limits reached. Numbers that are
                not finite say nothing, either.

        Returns:
            A report at the end of each period, else None.
        """
        s = np.asarray(state, dtype=float)
        sums = (np.sum(part) for part in (s, wrench, reference, filtered, x_ref))
        if not (ok and isfinite(sum(sums))):
            self.forget()
            return None
        before = self._states[-1][:, 0] if self._states else s[:, 0]
        extended = np.column_stack([s, np.broadcast_to(filtered, self.n), before])
        if self.loop.delay:
            extended[:, 3] = self._lagged(extended[:, 3])
        row = np.empty((5, self.n))
        row[0], row[1], row[2], row[3] = wrench, reference, s[:, 0], x_ref
        row[4] = extended[:, 3]
        self._rows.append(row)
        self._states.append(extended)
        self._since += 1
        if len(self._rows) < self._length or self._since < self._every:
            return None
        return self._measure()

    def _lagged(self, first: Array) -> Array:
        """The servo's position, one tick later than the law's own y."""
        if not self._states:
            return first
        last = self._states[-1]
        keep = np.exp(-self.loop.dt / self.loop.tau) if self.loop.tau > 0 else 0.0
        lagged: Array = keep * last[:, 3] + (1 - keep) * last[:, 5]
        return lagged

    def _measure(self) -> Report:
        rows = np.stack(self._rows[-self._length :])
        states = self._states[-self._length]
        f, w, x, x_ref, y = (rows[:, i] for i in range(5))
        window = Window(f, w, x, x_ref, y, states)
        fresh = slice(-self._since, None)
        self._contact.add(y[fresh], f[fresh], w[fresh])
        self._rows, self._states = self._rows[-self._length :], self._states[-self._length :]
        self._since = 0
        return self._judge(window)

    def _judge(self, window: Window) -> Report:
        seen = measured(self.specification, window)
        rmse = float(np.sqrt(np.mean((window.f - window.w) ** 2)))
        contact = self._contact.estimate()
        if contact is None or contact.spread > self.config.spread_max:
            return Report("waiting", self.gains, seen, rmse, contact, None)
        self._calm(contact)
        least = self.config.interval
        interval = Interval(
            contact.low / max(least, 1.0 + 3.0 * contact.spread_low),
            contact.high * max(least, 1.0 + 3.0 * contact.spread_high),
        )
        verdict = self._improve(window, contact, interval, seen)
        radius = float(spectral_radius(self.gains, interval, self.loop)[0])
        return Report(verdict, self.gains, seen, rmse, contact, radius)

    def _calm(self, contact: ContactEstimate) -> None:
        """Let the walk become smaller with time, and start anew on another contact."""
        c = self.config
        if self._known is None or not 0.5 < contact.high / self._known < 2.0:
            self._known, self._age = contact.high, 0.0
        walk = c.walk_end + (c.walk - c.walk_end) * float(np.exp(-self._age / c.calm))
        self.filter.S_q = walk * np.eye(len(self.names))
        self._age += c.period

    def _improve(
        self, window: Window, contact: ContactEstimate, interval: Interval, seen: Array
    ) -> Verdict:
        old = self.filter.theta.copy()

        def h(theta: Array) -> Array:
            spec = predicted(
                self._rows_of(theta), self.specification, window, contact.K, interval, self.loop
            )
            return np.hstack([spec, self.config.stay * (theta - self._home)])

        def correction(Y: Array) -> Array:
            return np.concatenate([seen - Y[0, :4], np.zeros(Y.shape[1] - 4)])

        self.filter.predict()
        root = self.filter.S.copy()
        self.filter.update(np.zeros(SIZE + len(old)), h, offset=correction)
        step = np.clip(self.filter.theta - old, -self.config.step_max, self.config.step_max)
        step = self._bounded(old + step) - old
        tries = old + step * 0.5 ** np.arange(HALVINGS + 1)[:, None]
        cost = np.sum(h(np.vstack([old, tries])) ** 2, axis=1)
        sound = self.is_sound(self._rows_of(tries), interval)
        at_risk = not self.is_sound(self._rows_of(old[None]), interval)[0]
        good = sound & ((cost[1:] <= cost[0]) | at_risk)
        if not good.any():
            self.filter.theta, self.filter.S = old, root
            return "refused"
        k = int(np.argmax(good))
        self.filter.theta = tries[k]
        self.gains = self._gains_of(tries[k])
        return "taken" if k == 0 else "shrunk"

    def is_sound(self, gains: Array, interval: Interval) -> NDArray[np.bool_]:
        """(k,) gains (k, 6) whose loop is stable and damped over the interval, and in the air."""
        M, D, K, _f, _i, K_pi = gains.T
        free = (K_pi == 0) | (M * K_pi < D * K)
        radius = spectral_radius(gains, interval, self.loop)
        enough = damping(gains, interval, self.loop) >= self.config.damping_floor
        sound: NDArray[np.bool_] = free & (radius < 1.0) & enough
        return sound

    def _rows_of(self, theta: Array) -> Array:
        g = self.gains
        rows = np.tile([g.M, g.D, g.K, g.K_f, g.K_fi, g.K_pi], (len(theta), 1))
        at = {"D": 1, "K": 2, "K_f": 3, "K_fi": 4, "K_pi": 5}
        bounded = self._bounded(theta)
        for i, name in enumerate(self.names):
            rows[:, at[name]] = np.exp(bounded[:, i])
        return rows

    def _bounded(self, theta: Array) -> Array:
        """Log-gains (..., L) within their range."""
        return np.clip(theta, self._home - self._wide, self._home + self._wide)

    def _gains_of(self, theta: Array) -> AxisGains:
        values = dict(zip(self.names, (float(v) for v in np.exp(theta)), strict=True))
        return replace(self.gains, **values)
