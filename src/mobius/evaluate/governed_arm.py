"""The governor on the simulated arms: ``mobius eval governor --arm``.

The reference, contacts and forces are those of the evaluation on the model
(:mod:`mobius.evaluate.governed`); what they act on is both arms in MuJoCo under the force loop. In
every episode each arm is driven along one axis, x, y or z as the seed draws it, and holds the other
two; all six are governed. The contact along it is a spring at rest at the start or a wall that only
pushes, and its stiffness jumps.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mobius.control.admittance import AdmittanceConfig, ForceLoop, Governed, mobius_config
from mobius.control.governor import AXES, Axis, NearestGovernor, ScalarGovernor
from mobius.control.governor.plant import with_margin
from mobius.evaluate import governed
from mobius.evaluate.arm_rig import LEVEL, ArmRig, Contacts
from mobius.evaluate.governor import samples_of, set_of, shape_of
from mobius.evaluate.jobs import Progress, run_jobs

__all__ = ["ARM_MARGIN", "ARM_TICKS", "ARM_VARIANTS", "ArmGoverning", "arm_as_text", "governed_arm"]

Array = NDArray[np.float64]

ARM_VARIANTS = ("none", "algorithm_3", "exact")
"""What stands between the wish and the loop."""
ARM_MARGIN = (0.30, 0.30, 0.30)
"""Shares of the limits of position, velocity and wrench kept free on the arm. They cover what the
model of an axis leaves out: second order of servos and links (the hand overshoots its command),
servos that give way to a force, sag that changes with the pose, the other axes and joints (IK), and
filter, noise and drift of the wrists. Nearly all of it is the speed of the hand."""
ARM_TICKS = 3_000
"""Of an episode: 10 s."""
LIMITS = ("position", "command_velocity", "hand_velocity", "wrench")
"""What is counted: the true hand, the law's command, the true hand, the true contact."""
WALL_REACH = 0.5
"""Walls stand up to this share of the position limit away."""
TARE_TICKS = 60
"""Over which the wrists are tared."""


@dataclass
class ArmGoverning:
    """The outcome. A step is one tick of 1/300 s of both arms."""

    seeds: int
    seed: int
    """The first."""
    steps: int
    """Of every variant."""
    margin: tuple[float, ...]
    """Shares of the limits of position, velocity and wrench that the governors keep free;
    violations are of the whole limits."""
    violations: dict[str, int]
    """Steps with a limit of any axis of any arm broken, by variant."""
    by_limit: dict[str, dict[str, int]]
    """Steps with this limit broken, by variant and limit."""
    worst: dict[str, dict[str, float]]
    """Largest value over its limit, by variant and limit."""
    unreachable: dict[str, int]
    """Steps in which an arm could not reach what the law commanded, by variant."""
    held: dict[str, int]
    """Steps in which a governor found its state outside of its set and held, by variant."""

    def as_json(self) -> dict[str, Any]:
        """Plain values."""
        return asdict(self)


class _Late:
    """A governor on (x, v, W) as a hook of the law: W is that of the tick before."""

    def __init__(self, governor: NearestGovernor) -> None:
        self.governor, self.wrench = governor, 0.0

    def step(self, x: Array, r: Array) -> Array:
        """As the hook of the law wants it."""
        return self.governor.step(np.array([x[3], x[1], self.wrench]), r)


def config_of(axis: Axis) -> AdmittanceConfig:
    """An arm whose three translations have the gains of the axis; rotations hold.

    The controller's own clips are wide, so that it is the governor that keeps the limits.
    """

    def six(value: float, other: float) -> list[float]:
        return [value] * 3 + [other] * 3

    return mobius_config(
        selected_axes=np.arange(6) < 3,
        mass=six(axis.mass, 1.0),
        damping=six(axis.damping, 100.0),
        stiffness=six(axis.stiffness, 0.0),
        force_gain=six(axis.force_gain, 1.0),
        integral_force=six(axis.integral_force, 0.0),
        integral_position=six(axis.integral_position, 0.0),
        integral_max=six(1e4, 5.0),
        position_min=six(-1.0, -0.6),
        position_max=six(1.0, 0.6),
        velocity_min=six(-10.0, -2.0),
        velocity_max=six(10.0, 2.0),
    )


class _Episode:
    """What is drawn for one seed: references, contacts and forces of both arms."""

    def __init__(self, axis: Axis, seed: int, ticks: int) -> None:
        rng = np.random.default_rng([seed, 21])
        self.axis, self.driven = axis, rng.integers(3, size=2)
        parts = [governed.draw(axis, 10 + k, [seed], ticks) for k in range(6)]
        self.force = np.stack([p.d[:, 0] for p in parts], axis=1).reshape(ticks, 2, 3)
        self.r = np.stack([parts[3 * a].r[:, 0] for a in (0, 1)], axis=1)  # (t, 2, 2)
        self.k_env = np.stack([parts[3 * a].k_env[:, 0] for a in (0, 1)], axis=1)
        side = rng.choice([-1.0, 1.0], 2) * rng.uniform(1e-6, WALL_REACH, 2) * axis.position_max
        self.wall = np.where(rng.integers(2, size=2) == 1, side, 0.0)
        self.adversary = governed.Adversary(axis) if parts[0].adversarial[0] else None
        self._wish = self.r[0]

    def wish(self, t: int, state: Array) -> Array:
        """References (2, 2) of the driven axes, whose states are (2, 4)."""
        if self.adversary is None:
            return np.asarray(self.r[t])
        if t % governed.EVERY == 0:
            self._wish = self.adversary(state, self.k_env[t])
        return self._wish

    def contacts(self, t: int, state: Array) -> Contacts:
        """What pushes on the hands."""
        arms = np.arange(2)
        k_env, wall, force = np.zeros((2, 3)), np.zeros((2, 3)), self.force[t].copy()
        k_env[arms, self.driven], wall[arms, self.driven] = self.k_env[t], self.wall
        if self.adversary is not None:
            ahead = state[:, 3] + 0.1 * state[:, 1]
            force[arms, self.driven] = self.axis.disturbance * np.where(ahead >= 0, 1.0, -1.0)
        return Contacts(k_env, wall, force)


@dataclass
class _Count:
    """Of one episode."""

    broken: int
    by_limit: Array
    worst: Array
    unreachable: int
    held: int


def governors_of(variant: str, axis: Axis) -> dict[tuple[int, str], Any]:
    """Hooks for three axes of both arms; ``axis`` is what is governed, margin included."""
    keys = [(arm, name) for arm in (0, 1) for name in "xyz"]
    if variant == "none":
        return {}
    if variant == "exact":
        return {key: ScalarGovernor(set_of(axis)) for key in keys}
    return {key: _Late(NearestGovernor(samples_of(axis, False))) for key in keys}


def episode(axis: Axis, variant: str, margin: Sequence[float], seed: int, ticks: int) -> _Count:
    """One episode; the limits of ``axis`` are counted, those less the margin are governed."""
    rig, drawn = ArmRig(seed), _Episode(axis, seed, ticks)
    hooks = governors_of(variant, with_margin(axis, margin))
    keyed: dict[tuple[int, Governed], Any] = dict(hooks.items())  # type: ignore[arg-type]
    loop = ForceLoop(config_of(axis), config_of(axis), governors=keyed)
    loop.start(rig.targets)
    _tare(loop, rig)
    limits = np.array([axis.position_max, axis.velocity_max, axis.velocity_max, axis.wrench_max])
    count = _Count(0, np.zeros(4, int), np.zeros(4), 0, 0)
    arms = np.arange(2)
    for t in range(ticks):
        state = loop.law.state[arms, drawn.driven]
        r = drawn.wish(t, state)
        loop.x_ref[arms, drawn.driven], loop.wrench_reference[arms, drawn.driven] = r.T
        out = loop.step(rig.frame(), LEVEL)
        truth = rig.tick(out.command.q, drawn.contacts(t, state))
        largest = [truth.x, out.motion.v[:, :3], truth.v, truth.wrench]
        over = np.array([np.abs(part).max() for part in largest]) / limits
        count.broken += bool((over > 1.0).any())
        count.by_limit += over > 1.0
        count.worst = np.maximum(count.worst, over)
        count.unreachable += bool(out.unreachable.any())
        count.held += any(_holds(h) for h in hooks.values())
        for (arm, name), hook in hooks.items():
            if isinstance(hook, _Late):
                hook.wrench = float(out.wrenches.wrench_C[arm, "xyz".index(name)])
    return count


def _holds(hook: Any) -> bool:
    return isinstance(hook, ScalarGovernor) and not hook.verdict.ok


def _work(job: tuple[Axis, str, Sequence[float], int, int]) -> _Count:
    return episode(*job)


def governed_arm(
    *,
    seeds: int,
    seed: int = 0,
    ticks: int = ARM_TICKS,
    margin: float | Sequence[float] = ARM_MARGIN,
    variants: tuple[str, ...] = ARM_VARIANTS,
    axis: Axis = AXES[0],
    workers: int = 0,
    progress: Progress | None = None,
) -> ArmGoverning:
    """Episodes on the simulated arms, one a seed.

    Args:
        seeds: Number of episodes, >= 1.
        seed: The first.
        ticks: Of an episode.
        margin: Share of every limit that governors keep free, or one each of position, velocity
            and wrench.
        variants: Some of :data:`ARM_VARIANTS`.
        axis: Gains, limits and assumptions of all three translations of both arms.
        workers: Processes; 0 takes one a CPU.
        progress: Called with the share done.
    """
    axis = shape_of(axis)
    shares = (margin,) * 3 if isinstance(margin, int | float) else tuple(margin)
    jobs = [(axis, v, shares, s, ticks) for v in variants for s in range(seed, seed + seeds)]
    counts = run_jobs(_work, jobs, workers=workers, progress=progress)
    by_variant = {v: counts[k * seeds : (k + 1) * seeds] for k, v in enumerate(variants)}

    def told(values: Array) -> dict[str, Any]:
        return dict(zip(LIMITS, values.tolist(), strict=True))

    return ArmGoverning(
        seeds=seeds,
        seed=seed,
        steps=seeds * ticks,
        margin=shares,
        violations={v: sum(c.broken for c in part) for v, part in by_variant.items()},
        by_limit={v: told(np.sum([c.by_limit for c in p], axis=0)) for v, p in by_variant.items()},
        worst={v: told(np.max([c.worst for c in p], axis=0)) for v, p in by_variant.items()},
        unreachable={v: sum(c.unreachable for c in part) for v, part in by_variant.items()},
        held={v: sum(c.held for c in part) for v, part in by_variant.items()},
    )


def arm_as_text(result: ArmGoverning) -> str:
    """The outcome as lines."""
    lines = [f"{'':14s}{'violations':>12s}" + "".join(f"{o:>18s}" for o in LIMITS)]
    for variant, count in result.violations.items():
        each = result.worst[variant], result.by_limit[variant]
        ratios = "".join(f"{each[0][o]:10.3f} ({each[1][o]:5d})" for o in LIMITS)
        lines.append(f"{variant:14s}{count:12d}{ratios}")
    lines += [
        f"{result.steps} steps of 1/300 s of both simulated arms; largest value over its limit, and"
        " steps beyond it",
        "governors keep free of the limits of position, velocity, wrench:"
        f" {', '.join(f'{100 * m:.0f} %' for m in result.margin)}; steps out of reach:"
        f" {' '.join(f'{v} {n}' for v, n in result.unreachable.items())}",
    ]
    return "\n".join(lines)


def _tare(loop: ForceLoop, rig: ArmRig) -> None:
    """The mean of a fifth of a second, untouched, counts as no load."""
    free = Contacts(*np.zeros((3, 2, 3)))
    frames = []
    for _ in range(TARE_TICKS):
        rig.tick(rig.targets, free)
        frames.append(rig.frame())
    up_S, R_CS = loop.frames(frames[-1], LEVEL)
    loop.wrench.tare_load(np.stack([f.wrench_S for f in frames]), up_S, R_CS)
