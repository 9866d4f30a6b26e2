"""Does a governor keep the limits, and what does it cost: ``mobius eval governor``."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from functools import cache
from typing import Any

import numpy as np

from mobius.control.governor import AXES, AdmissibleSet, Axis, SampledSet, algorithm_3, axis_set
from mobius.control.governor.nearest import Nearest
from mobius.evaluate import governed
from mobius.evaluate.jobs import Progress, run_jobs

__all__ = ["VARIANTS", "Governing", "as_text", "governor"]

VARIANTS = ("none", "algorithm_3", "algorithm_3_repaired", "exact")
"""What stands between the wish and the loop."""
TICKS = 10_000
"""Of an episode: 33 s."""
CHUNK = 50
"""Episodes that are computed together."""
SAFE_REACH = 0.6
"""Share of the position limit that gentle references use."""
OUTPUTS = ("position", "velocity", "wrench")


@dataclass
class Governing:
    """The outcome. A step is one tick of 1/300 s of all four axes."""

    seeds: int
    seed: int
    """The first."""
    steps: int
    """Of every variant."""
    violations: dict[str, int]
    """Steps with a limit of any axis broken, by variant."""
    worst: dict[str, dict[str, float]]
    """Largest position, velocity and wrench over their limits, by variant."""
    safe_episodes: int
    """Axis episodes of gentle references that broke no limit ungoverned."""
    safe_unchanged: float
    """Share of their steps that the exact governor left as they were."""
    safe_tracking: float
    """Median over them of the tracking error over the ungoverned one, less 1."""
    rows: dict[str, int] = field(default_factory=dict)
    """Half-spaces of the exact set, by axis."""

    def as_json(self) -> dict[str, Any]:
        """Plain values."""
        return asdict(self)


def shape_of(axis: Axis) -> Axis:
    """The axis without its name: equal ones share a set."""
    return Axis(**{**asdict(axis), "name": "any", "environment": tuple(axis.environment)})


@cache
def set_of(axis: Axis) -> AdmissibleSet:
    """The exact set, built once a process."""
    return axis_set(axis)


@cache
def samples_of(axis: Axis, repaired: bool) -> SampledSet:
    """The sampled set, built once a process."""
    return algorithm_3(axis, repaired=repaired)


def chooser(axis: Axis, variant: str) -> governed.Choose:
    """What a variant does on an axis."""
    axis = shape_of(axis)
    if variant == "none":
        return governed.ungoverned
    if variant == "exact":
        return governed.exact(set_of(axis))
    return governed.nearest(Nearest(samples_of(axis, variant == "algorithm_3_repaired")))


Part = tuple[dict[str, int], dict[str, Any], list[tuple[float, float]]]


def _work(job: tuple[tuple[int, ...], int, tuple[str, ...], tuple[Axis, ...]]) -> Part:
    """Violations, worst ratios, and (unchanged, tracking) of gentle episodes of some seeds."""
    seeds, ticks, variants, axes = job
    violations: dict[str, int] = {}
    worst: dict[str, Any] = {}
    for variant in variants:
        courses = [
            governed.run(axis, governed.draw(axis, k, seeds, ticks), chooser(axis, variant))
            for k, axis in enumerate(axes)
        ]
        broken = np.logical_or.reduce([c.broken for c in courses])
        violations[variant] = int(broken.sum())
        worst[variant] = np.maximum.reduce([c.worst for c in courses])
    gentle: list[tuple[float, float]] = []
    for k, axis in enumerate(axes):
        drawn = governed.smooth(axis, k, seeds, ticks, reach=SAFE_REACH * axis.position_max)
        free = governed.run(axis, drawn, governed.ungoverned)
        held = governed.run(axis, drawn, chooser(axis, "exact"))
        safe = ~free.broken.any(axis=0)
        gentle += zip(held.unchanged[safe], (held.error / free.error)[safe] - 1.0, strict=True)
    return violations, worst, [(float(a), float(b)) for a, b in gentle]


def governor(
    *,
    seeds: int,
    seed: int = 0,
    ticks: int = TICKS,
    variants: tuple[str, ...] = VARIANTS,
    axes: tuple[Axis, ...] = AXES,
    workers: int = 0,
    progress: Progress | None = None,
) -> Governing:
    """Episodes of random and adversarial references on the model, one a seed and axis.

    Args:
        seeds: Number of episodes, >= 1.
        seed: The first.
        ticks: Of an episode.
        variants: Some of :data:`VARIANTS`.
        axes: Gains, limits and assumptions.
        workers: Processes; 0 takes one a CPU.
        progress: Called with the share done.
    """
    numbers = list(range(seed, seed + seeds))
    jobs = [(tuple(numbers[k : k + CHUNK]), ticks, variants, axes) for k in range(0, seeds, CHUNK)]
    parts = run_jobs(_work, jobs, workers=workers, progress=progress)
    gentle = np.array([pair for part in parts for pair in part[2]]).reshape(-1, 2)
    none = not len(gentle)
    return Governing(
        seeds=seeds,
        seed=seed,
        steps=seeds * ticks,
        violations={v: sum(p[0][v] for p in parts) for v in variants},
        worst={
            v: dict(zip(OUTPUTS, np.max([p[1][v] for p in parts], axis=0).tolist(), strict=True))
            for v in variants
        },
        safe_episodes=len(gentle),
        safe_unchanged=0.0 if none else float(gentle[:, 0].mean()),
        safe_tracking=0.0 if none else float(np.median(gentle[:, 1])),
        rows={a.name: set_of(shape_of(a)).sizes[0] for a in axes},
    )


def as_text(result: Governing) -> str:
    """The outcome as lines."""
    lines = [f"{'':22s}{'violations':>12s}" + "".join(f"{o:>12s}" for o in OUTPUTS)]
    for variant, count in result.violations.items():
        ratios = "".join(f"{result.worst[variant][o]:12.3f}" for o in OUTPUTS)
        lines.append(f"{variant:22s}{count:12d}{ratios}")
    lines += [
        f"{result.steps} steps of 1/300 s; largest value over its limit by output",
        f"gentle references, safe ungoverned ({result.safe_episodes} axis episodes):"
        f" {100 * result.safe_unchanged:.2f} % of steps unchanged, tracking error"
        f" {100 * result.safe_tracking:+.2f} %",
    ]
    return "\n".join(lines)
