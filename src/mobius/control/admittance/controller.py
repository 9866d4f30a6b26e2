"""The admittance controller of n grippers: wrenches in, poses (as deviations) out.

Without a wrench it comes to rest within ``hold_time`` and keeps its position and its
integrals; when the wrench is back the law takes over by degrees within ``resume_time``. x
and v are continuous throughout, and whatever is clipped is told.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.control.admittance.config import AXES, AdmittanceConfig
from mobius.control.admittance.law import DT, SERVO_LAG, AxisGains, batch_steps
from mobius.control.admittance.wrench import Wrenches
from mobius.errors import InvalidInput

__all__ = ["Admittance", "Governed", "Governor", "Motion"]

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


class Governor(Protocol):
    """Lets a reference through as far as it is safe, built from the law of one axis.

    One that keeps its last reference should have ``reset(x, v)`` as well, see
    :meth:`Admittance.reset`.
    """

    def step(self, x: Array, r: Array) -> Array:
        """Reference v (2,) to use now, for the law's state x (4,) and the wished r (2,).

        x is (x, v, z, y) as in :mod:`mobius.control.admittance.law`, r is (x_ref, W_ref).
        One that serves k axes together gets (k, 4) and (k, 2), and gives (k, 2).
        """


Governed = str | tuple[str, ...]
"""One axis, or several that one governor serves in one call."""


@dataclass(frozen=True, eq=False)
class Motion:
    """What the controller commands at one tick, for n grippers."""

    x: Array
    """(n, 6) deviation from the pose at the start [m, rad], axes C."""
    v: Array
    """(n, 6) its rate."""
    holding: Flags
    """(n,) no wrench, or references that are not finite: it comes to rest or stands."""
    position_clipped: Flags
    """(n, 6) the law wanted beyond ``position_min`` or ``position_max``."""
    velocity_clipped: Flags
    """(n, 6)."""
    integral_clipped: Flags
    """(n, 6) the integral stands still."""
    governed: Flags
    """(n, 6) a governor changed the reference."""


class Admittance:
    """n grippers, each with a configuration; gains may change while it runs."""

    def __init__(
        self,
        configs: Sequence[AdmittanceConfig],
        *,
        tau: float = SERVO_LAG,
        dt: float = DT,
        governors: Mapping[tuple[int, Governed], Governor] | None = None,
    ) -> None:
        """One controller.

        Args:
            configs: One per gripper.
            tau: Servo lag in the state that governors see [s].
            dt: Tick [s].
            governors: By gripper and axis, ``{(0, "z"): governor}``, or by gripper and axes that
                one governor serves, ``{(0, ("x", "y")): governor}``.

        Raises:
            InvalidInput: There is no such gripper or axis, or an axis has two governors.
        """
        self.configs, self.dt, self.tau = tuple(configs), dt, tau
        self.n = len(self.configs)
        if not self.n:
            raise InvalidInput("Admittance: expected at least one configuration, got none")
        self.governors = dict(governors or {})
        self._places = [self._place(*key) for key in self.governors]
        self._gains = np.stack([c.gains for c in self.configs])
        self._selected = np.stack([c.selected_axes for c in self.configs])
        for name in ("position", "velocity"):
            for end in ("min", "max"):
                both = np.stack([getattr(c, f"{name}_{end}") for c in self.configs])
                setattr(self, f"_{name}_{end}", both)
        self._integral_max = np.stack([c.integral_max for c in self.configs])
        self._slow = np.array([[np.exp(-dt / c.hold_time)] for c in self.configs])
        self._resume = np.array([dt / c.resume_time for c in self.configs])
        self._build()
        self.reset()

    _position_min: Array
    _position_max: Array
    _velocity_min: Array
    _velocity_max: Array

    def _build(self) -> None:
        A, B, E = batch_steps(self._gains.reshape(-1, 6), self.tau, self.dt)
        self._step = np.concatenate([A, B, E], axis=2).reshape(self.n, 6, 4, 7)

    @property
    def gains(self) -> Array:
        """(n, 6, 6) M, D, K, K_f, K_fi, K_pi of every axis; a copy."""
        return self._gains.copy()

    @property
    def resuming(self) -> Flags:
        """(n,) the law does not act in full: no wrench, or it takes over by degrees."""
        below: Flags = self._trust < 1.0
        return below

    def set_gains(self, arm: int, axis: str, gains: AxisGains) -> None:
        """Change the gains of an axis; x, v and the integral stay as they are."""
        if axis not in AXES:
            raise InvalidInput(f"set_gains: expected an axis of {' '.join(AXES)}, got {axis!r}")
        g = gains
        row = np.array([[g.M, g.D, g.K, g.K_f, g.K_fi, g.K_pi]])
        A, B, E = batch_steps(row, self.tau, self.dt)
        at = AXES.index(axis)
        self._gains[arm, at] = row[0]
        self._step[arm, at] = np.concatenate([A[0], B[0], E[0]], axis=1)

    def reset(self, x: ArrayLike | None = None) -> None:
        """Stand still at deviation x (n, 6), zero if not given, with empty integrals.

        Governors with a method ``reset(x, v)`` begin there, too, with the reference that stands
        still.
        """
        self.state = np.zeros((self.n, 6, 4))
        """(n, 6, 4) x, v, z, y of every axis."""
        if x is not None:
            self.state[..., 0] = self.state[..., 3] = x
        self._trust = np.ones(self.n)
        for (arm, at), governor in zip(self._places, self.governors.values(), strict=True):
            begin = getattr(governor, "reset", None)
            if begin is not None:
                state = self.state[arm, at].copy()
                begin(state, np.stack([state[..., 0], 0.0 * state[..., 0]], axis=-1))

    def stand(self, grippers: Flags, before: Array) -> None:
        """Grippers that could not follow the last tick stand where they were before it.

        Their integrals may only shrink meanwhile, as at any other limit.

        Args:
            grippers: (n,) which.
            before: (n, 6, 4) state before the tick.
        """
        s, b = self.state, before
        s[grippers, :, 0] = b[grippers, :, 0]
        s[grippers, :, 1] = 0.0
        grows = grippers[:, None] & (np.abs(s[..., 2]) > np.abs(b[..., 2]))
        s[..., 2] = np.where(grows, b[..., 2], s[..., 2])

    def step(self, wrenches: Wrenches, x_ref: Array, wrench_ref: Array) -> Motion:
        """One tick. A gripper whose references are not finite holds, as without a wrench.

        Args:
            wrenches: Of all grippers, law axes.
            x_ref: (n, 6) wished deviation [m, rad].
            wrench_ref: (n, 6) wished wrench by the environment on the gripper [N, N m].

        Raises:
            InvalidInput: A reference has the wrong shape.
        """
        s, fresh = self.state, wrenches.fresh
        if x_ref.shape != (self.n, 6) or wrench_ref.shape != (self.n, 6):
            raise InvalidInput(
                f"Admittance.step: x_ref, wrench_ref: expected shape ({self.n}, 6), a row a"
                f" gripper, got {x_ref.shape} and {wrench_ref.shape}"
            )
        # squares add up to a finite number only if all are
        if not isfinite(np.vdot(x_ref, x_ref) + np.vdot(wrench_ref, wrench_ref)):
            both = np.isfinite(np.concatenate([x_ref, wrench_ref], axis=1))
            sound: Flags = np.logical_and.reduce(both, axis=1)
            fresh = fresh & sound
            x_ref = np.where(sound[:, None], x_ref, s[..., 0])
            wrench_ref = np.where(sound[:, None], wrench_ref, 0.0)
        # a lost wrench is felt at once, a found one by degrees
        self._trust = np.where(fresh, np.minimum(self._trust + self._resume, 1.0), 0.0)
        u = np.empty((self.n, 6, 7))
        u[..., :4] = s
        heard = np.where(fresh[:, None], wrenches.wrench_C, wrench_ref)
        u[..., 4], u[..., 5], u[..., 6] = x_ref, wrench_ref, heard
        governed = self._govern(u)
        new = (self._step @ u[..., None])[..., 0]
        if not (self._trust >= 1.0).all():
            new = self._blend(s, new)
        self._follow_where_not_selected(s, new, x_ref)
        motion = self._clip(s, new, ~fresh, governed)
        self.state = new
        return motion

    def _place(self, arm: int, axes: Governed) -> tuple[int, int | list[int]]:
        """Where a governor's states stand in (n, 6, ...)."""
        names = (axes,) if isinstance(axes, str) else axes
        taken = [
            (a, name)
            for a, other in self.governors
            for name in ((other,) if isinstance(other, str) else other)
        ]
        if not 0 <= arm < self.n or not names or set(names) - set(AXES):
            raise InvalidInput(
                f"Admittance.governors: expected (0..{self.n - 1}, one of {' '.join(AXES)} or some"
                f" of them in a tuple), got ({arm}, {axes!r})"
            )
        for name in names:
            if taken.count((arm, name)) > 1:
                raise InvalidInput(
                    f"Admittance.governors: axis {name} of gripper {arm} has more than one"
                )
        at = [AXES.index(name) for name in names]
        return arm, (at[0] if isinstance(axes, str) else at)

    def _govern(self, u: Array) -> Flags:
        governed = np.zeros((self.n, 6), dtype=bool)
        for (arm, at), governor in zip(self._places, self.governors.values(), strict=True):
            wished = u[arm, at, 4:6].copy()
            given = governor.step(u[arm, at, :4].copy(), wished)
            u[arm, at, 4:6] = given
            governed[arm, at] = (given != wished).any(axis=-1)
        return governed

    def _blend(self, s: Array, law: Array) -> Array:
        """Between coming to rest and the law, by how far the wrench is trusted."""
        rest = s.copy()
        rest[..., 1] = self._slow * s[..., 1]
        rest[..., 0] = s[..., 0] + self.dt * rest[..., 1]
        if self.tau > 0:
            rest[..., 3] += (1 - np.exp(-self.dt / self.tau)) * (s[..., 0] - s[..., 3])
        else:
            rest[..., 3] = rest[..., 0]
        out: Array = rest + self._trust[:, None, None] * (law - rest)
        return out

    def _follow_where_not_selected(self, s: Array, new: Array, x_ref: Array) -> None:
        if self._selected.all():
            return
        free = ~self._selected
        v = np.clip((x_ref - s[..., 0]) / self.dt, self._velocity_min, self._velocity_max)
        new[..., 1] = np.where(free, v, new[..., 1])
        new[..., 0] = np.where(free, s[..., 0] + self.dt * v, new[..., 0])
        new[..., 2] = np.where(free, 0.0, new[..., 2])

    def _clip(self, s: Array, new: Array, holding: Flags, governed: Flags) -> Motion:
        v = np.minimum(np.maximum(new[..., 1], self._velocity_min), self._velocity_max)
        fast = v != new[..., 1]
        x = np.where(fast, s[..., 0] + self.dt * v, new[..., 0])
        inside = np.minimum(np.maximum(x, self._position_min), self._position_max)
        # a command that starts outside (a limit was moved) goes back no faster than v allows
        step = self.dt * np.maximum(self._velocity_max, -self._velocity_min)
        inside = np.minimum(np.maximum(inside, s[..., 0] - step), s[..., 0] + step)
        far = inside != x
        v = np.where(far, 0.0, v)
        # conditional integration: z may only shrink while its axis is at a limit
        grows = np.abs(new[..., 2]) > np.abs(s[..., 2])
        z = np.where((fast | far) & grows, s[..., 2], new[..., 2])
        z = np.minimum(np.maximum(z, -self._integral_max), self._integral_max)
        full = z != new[..., 2]
        new[..., 0], new[..., 1], new[..., 2] = inside, v, z
        return Motion(
            x=inside,
            v=v,
            holding=holding,
            position_clipped=far,
            velocity_clipped=fast,
            integral_clipped=full,
            governed=governed,
        )
