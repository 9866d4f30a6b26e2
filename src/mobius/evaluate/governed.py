"""Many episodes of one governed axis at once, on the model: references, pushes, contacts.

Everything is drawn from the seeds. The contact's stiffness jumps within its interval, an outside
force acts within its bound, and references go far beyond what is admissible. A quarter of the
episodes is adversarial: the reference is, twelve times a second, the one that leads furthest out
from the state at that moment, and the force always pushes outwards.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mobius.control.governor import AdmissibleSet, Axis, axis_system
from mobius.control.governor.nearest import Nearest

__all__ = [
    "Adversary",
    "Choose",
    "Course",
    "Drawn",
    "draw",
    "exact",
    "nearest",
    "run",
    "smooth",
    "ungoverned",
]

Array = NDArray[np.float64]

KINDS = ("steps", "bang_bang", "sweep", "adversarial")
"""Of references; seed modulo four."""
REACH = 1.4
"""References go this many position limits far."""
WRENCH_REACH = 0.3
"""And so many wrench limits."""
AHEAD = (8, 16, 32, 64, 128, 256)
"""Steps at which an adversary looks."""
EVERY = 25
"""Steps between its choices."""
TOLERANCE = 1e-9
"""A limit exceeded by more is broken (m, m/s, N)."""


@dataclass(frozen=True, eq=False)
class Drawn:
    """What happens to b episodes over t ticks, whoever governs."""

    r: Array
    """(t, b, 2) x_ref, W_ref."""
    d: Array
    """(t, b) outside force [N]."""
    k_env: Array
    """(t, b) contact stiffness [N/m]."""
    adversarial: NDArray[np.bool_]
    """(b,)."""


@dataclass(frozen=True, eq=False)
class Course:
    """What became of b episodes."""

    worst: Array
    """(3,) largest |x_s|, |v|, |W| over their limits."""
    broken: NDArray[np.bool_]
    """(t, b) whether a limit was broken."""
    unchanged: Array
    """(b,) share of ticks with v = r."""
    error: Array
    """(b,) root mean square of x_s - x_ref [m]."""


Choose = Callable[[Array, Array, Array, Array], Array]
"""(state (b, 4), W (b,), last v (b, 2), wish (b, 2)) -> v (b, 2)."""


def ungoverned(state: Array, W: Array, v: Array, r: Array) -> Array:
    """The wish itself."""
    return r


def exact(rows: AdmissibleSet) -> Choose:
    """The scalar governor on an exact set."""

    def choose(state: Array, W: Array, v: Array, r: Array) -> Array:
        kappa = rows.fraction(state, v, r)[:, None]
        return np.where(kappa >= 1.0, r, v + kappa * (r - v))

    return choose


def nearest(look_up: Nearest) -> Choose:
    """Eq. (23) on samples."""

    def choose(state: Array, W: Array, v: Array, r: Array) -> Array:
        return look_up.choose(np.stack([state[:, 3], state[:, 1], W], axis=1), r, v)[0]

    return choose


def draw(axis: Axis, number: int, seeds: Sequence[int], ticks: int) -> Drawn:
    """References, forces and stiffnesses of an axis.

    Args:
        axis: Limits and assumptions.
        number: Of the axis, so that axes differ.
        seeds: One an episode.
        ticks: Length of the episodes.
    """
    parts = [_episode(axis, np.random.default_rng([s, number, 18]), s, ticks) for s in seeds]
    r, d, k_env = (np.stack(p, axis=1) for p in zip(*parts, strict=True))
    hard = np.array([KINDS[s % len(KINDS)] == "adversarial" for s in seeds])
    return Drawn(r, d, k_env, hard)


def smooth(axis: Axis, number: int, seeds: Sequence[int], ticks: int, *, reach: float) -> Drawn:
    """Gentle references within ``reach`` [m]: rests, and moves without jerk of 1.5 to 3 s."""
    refs = []
    base = draw(axis, number, seeds, ticks)
    for s in seeds:
        rng, x, here = np.random.default_rng([s, number, 19]), np.zeros(ticks), 0.0
        at = 0
        while at < ticks:
            there = rng.uniform(-reach, reach)
            move, rest = (int(rng.uniform(*span) / axis.dt) for span in ((1.5, 3.0), (0.5, 2.0)))
            s_ = np.clip(np.arange(min(move + rest, ticks - at)) / move, 0.0, 1.0)
            x[at : at + len(s_)] = here + (there - here) * s_**3 * (10 - 15 * s_ + 6 * s_**2)
            at, here = at + move + rest, there
        refs.append(np.stack([x, np.zeros(ticks)], axis=1))
    return Drawn(np.stack(refs, axis=1), base.d, base.k_env, np.zeros(len(seeds), bool))


def run(axis: Axis, drawn: Drawn, choose: Choose) -> Course:
    """Let a governor choose the references of all episodes."""
    low, high = axis_system(axis, 0.0), axis_system(axis, 1.0)
    A, dA, B, E = low.A, high.A - low.A, low.B, low.E  # A is affine in the stiffness
    limits = np.array([axis.position_max, axis.velocity_max, axis.wrench_max])
    adversary = Adversary(axis) if drawn.adversarial.any() else None
    ticks, count = drawn.d.shape
    x, v = np.zeros((count, 4)), np.zeros((count, 2))
    wish = drawn.r[0].copy()
    broken = np.zeros((ticks, count), bool)
    worst, same, off = np.zeros(3), np.zeros(count), np.zeros(count)
    for t in range(ticks):
        k, d = drawn.k_env[t], drawn.d[t]
        wish = np.where(drawn.adversarial[:, None], wish, drawn.r[t])
        if adversary is not None:
            if t % EVERY == 0:
                wish = np.where(drawn.adversarial[:, None], adversary(x, k), wish)
            outwards = axis.disturbance * np.where(x[:, 3] + 0.1 * x[:, 1] >= 0, 1.0, -1.0)
            d = np.where(drawn.adversarial, outwards, d)
        W = d - k * x[:, 3]
        v = choose(x, W, v, wish)
        y = np.abs(np.stack([x[:, 3], x[:, 1], W], axis=1))
        broken[t] = (y > limits + TOLERANCE).any(axis=1)
        worst = np.maximum(worst, (y / limits).max(axis=0))
        same += (v == wish).all(axis=1)
        off += np.square(x[:, 3] - wish[:, 0])
        x = x @ A.T + k[:, None] * (x @ dA.T) + v @ B.T + d[:, None] * E[:, 0]
    return Course(worst, broken, same / ticks, np.sqrt(off / ticks))


class Adversary:
    """The reference that, held, leads furthest out."""

    def __init__(self, axis: Axis) -> None:
        self.corners = np.array([[a, b] for a in (-1.0, 1.0) for b in (-1.0, 1.0)]) * [
            REACH * axis.position_max, WRENCH_REACH * axis.wrench_max
        ]  # fmt: skip
        self.grid = np.linspace(*axis.environment, 5)
        limits = np.array([axis.position_max, axis.velocity_max, axis.wrench_max])
        on_x, on_v = [], []
        for k in self.grid:
            s = axis_system(axis, float(k))
            power, total = np.eye(4), np.zeros((4, 2))
            for t in range(max(AHEAD) + 1):
                if t in AHEAD:
                    on_x.append(s.C[:3] @ power / limits[:, None])
                    on_v.append(s.C[:3] @ total / limits[:, None])
                power, total = power @ s.A, total + power @ s.B
        shape = (len(self.grid), 3 * len(AHEAD))
        self.on_x = np.array(on_x).reshape(*shape, 4)
        self.on_v = np.array(on_v).reshape(*shape, 2) @ self.corners.T

    def __call__(self, x: Array, k: Array) -> Array:
        """(b, 2) for states (b, 4) and stiffnesses (b,)."""
        at = np.abs(self.grid - k[:, None]).argmin(axis=1)
        y = np.einsum("brn,bn->br", self.on_x[at], x)[..., None] + self.on_v[at]
        return self.corners[np.abs(y).max(axis=1).argmax(axis=1)]


def _episode(
    axis: Axis, rng: np.random.Generator, seed: int, ticks: int
) -> tuple[Array, Array, Array]:
    reach = np.array([REACH * axis.position_max, WRENCH_REACH * axis.wrench_max])
    hold = (0.1, 1.5) if KINDS[seed % len(KINDS)] == "steps" else (0.15, 0.6)
    r = _held(rng, ticks, axis.dt, hold, lambda: rng.uniform(-1.0, 1.0, 2) * reach)
    if KINDS[seed % len(KINDS)] == "bang_bang":
        r = np.where(r >= 0, reach, -reach)
    if KINDS[seed % len(KINDS)] == "sweep":
        t = axis.dt * np.arange(ticks)
        r = np.stack([reach[0] * np.sin(t * (0.5 + 0.5 * t)), 0.0 * t], axis=1)
    d = _held(rng, ticks, axis.dt, (0.05, 1.0),
              lambda: axis.disturbance * rng.choice([-1.0, 1.0, rng.uniform(-1, 1)]))  # fmt: skip
    k_env = _held(rng, ticks, axis.dt, (0.5, 4.0), lambda: rng.uniform(*axis.environment)
                  if rng.random() < 0.5 else rng.choice(axis.environment))  # fmt: skip
    return r, d, k_env


def _held(
    rng: np.random.Generator, ticks: int, dt: float, hold: tuple[float, float],
    value: Callable[[], Array | float],
) -> Array:  # fmt: skip
    """Values (ticks, ...), each held for a random while [s]."""
    parts: list[Array] = []
    while sum(map(len, parts)) < ticks:
        length = max(1, int(rng.uniform(*hold) / dt))
        one = np.asarray(value(), float)
        parts.append(np.broadcast_to(one, (length, *one.shape)))
    return np.concatenate(parts)[:ticks]
