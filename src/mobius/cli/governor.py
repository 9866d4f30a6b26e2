"""``mobius moas`` and ``mobius eval governor``: the admissible set, and whether it is kept."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mobius.cli.common import Bar, at_least, png_file
from mobius.errors import InvalidInput, UnknownName

if TYPE_CHECKING:
    from mobius.control.governor import AdmissibleSet, Axis


@dataclass
class EvalGovernor:
    """Random and adversarial references with and without a governor, on the model or the arms."""

    arm: bool = False
    """On both simulated arms in MuJoCo instead of the model."""
    seeds: int = 100
    """Number of episodes, >= 1; 10,000 steps of 1/300 s each, with --arm 3,000."""
    seed: int = 0
    """The first seed; any whole number >= 0."""
    margin: tuple[float, ...] = ()
    """With --arm: share of every limit that governors keep free, or one each of position, velocity
    and wrench, >= 0 and < 1; 0.3 if left out."""
    variant: tuple[str, ...] = ()
    """none, algorithm_3, algorithm_3_repaired (not with --arm), exact; all if left out."""
    workers: int = 0
    """Processes, >= 0; 0 takes one a CPU."""
    json: bool = False
    """Print one JSON object and nothing else."""
    out: Path | None = None
    """Folder for governor.json; new or empty."""

    def __call__(self) -> int:
        """Evaluate, write and print."""
        at_least("--seeds", self.seeds, 1)
        at_least("--seed", self.seed, 0)
        at_least("--workers", self.workers, 0)
        good = len(self.margin) in (1, 3) and all(0 <= m < 1 for m in self.margin)
        if self.margin and not (self.arm and good):
            raise InvalidInput(
                "--margin: expected --arm and a number >= 0 and < 1, or three, got"
                f" {' '.join(f'{m:g}' for m in self.margin)}"
            )
        from contextlib import nullcontext

        from mobius.files import write_json_atomic
        from mobius.results import staged

        with nullcontext() if self.out is None else staged(self.out) as folder:
            result, text = self._on_arm() if self.arm else self._on_model()
            if folder is not None:
                write_json_atomic(folder / "governor.json", result)
        print(json.dumps(result, allow_nan=False) if self.json else text)
        return 0

    def _on_model(self) -> tuple[dict[str, Any], str]:
        from mobius.evaluate.governor import VARIANTS, as_text, governor

        variants = self._variants(VARIANTS)
        with Bar() as bar:
            result = governor(
                seeds=self.seeds,
                seed=self.seed,
                variants=variants,
                workers=self.workers,
                progress=lambda share: bar("governor", share),
            )
        return result.as_json(), as_text(result)

    def _on_arm(self) -> tuple[dict[str, Any], str]:
        from mobius.evaluate.governed_arm import (
            ARM_MARGIN,
            ARM_VARIANTS,
            arm_as_text,
            governed_arm,
        )

        variants = self._variants(ARM_VARIANTS)
        with Bar() as bar:
            result = governed_arm(
                seeds=self.seeds,
                seed=self.seed,
                margin=ARM_MARGIN if not self.margin else self._shares(),
                variants=variants,
                workers=self.workers,
                progress=lambda share: bar("governor", share),
            )
        return result.as_json(), arm_as_text(result)

    def _shares(self) -> tuple[float, ...]:
        return self.margin * 3 if len(self.margin) == 1 else self.margin

    def _variants(self, known: tuple[str, ...]) -> tuple[str, ...]:
        for name in self.variant:
            if name not in known:
                raise UnknownName("variant", name, known)
        return self.variant or known


@dataclass
class Moas:
    """Build the maximal output admissible set of an axis of the admittance controller.

    Units are those of the axis: m and N, or rad and N m for torque. What is left out is ours.
    """

    axis: str = "x"
    """x, y, z or torque: whose gains and limits."""
    mass: float | None = None
    """M, > 0."""
    damping: float | None = None
    """D, > 0."""
    stiffness: float | None = None
    """K, >= 0."""
    force_gain: float | None = None
    """K_f, >= 0."""
    integral_position: float | None = None
    """K_Ix, >= 0."""
    integral_force: float | None = None
    """K_If, >= 0."""
    servo_lag: float | None = None
    """Of the servo [s], >= 0."""
    position_max: float | None = None
    """Limit of the position, > 0."""
    velocity_max: float | None = None
    """Limit of the velocity, > 0."""
    wrench_max: float | None = None
    """Limit of the wrench, > 0."""
    disturbance: float | None = None
    """Outside force that may act at any moment, >= 0."""
    environment: tuple[float, float] | None = None
    """Least and greatest contact stiffness; it may jump between them."""
    epsilon: float = 0.02
    """Share of the limits that steady states keep free, > 0 and < 1."""
    tolerance: float = 0.01
    """Relative size that may be lost for fewer rows, > 0 and < 0.5."""
    samples: int = 20_000
    """Random states for the volume beside Algorithm 3's, >= 1000."""
    json: bool = False
    """Print one JSON object and nothing else."""
    save: Path | None = None
    """Write the rows to this .npz file, and what is printed to a .json beside it."""
    png: Path | None = None
    """Draw slices of the set to this .png file."""

    def __call__(self) -> int:
        """Build, write, print."""
        import time

        at_least("--samples", self.samples, 1000)
        png_file("--png", self.png)
        if self.save is not None and self.save.suffix != ".npz":
            raise InvalidInput(f"--save: expected a file that ends in .npz, got {self.save}")
        axis = self._axis()
        from mobius.control.governor import axis_set
        from mobius.reproduce.moas import volumes

        start = time.process_time()
        rows = axis_set(axis, epsilon=self.epsilon, tolerance=self.tolerance)
        seconds = time.process_time() - start
        told = {**_told(axis, rows, seconds), **volumes(axis, rows, self.samples)}
        self._write(axis, rows, told)
        print(json.dumps(told, allow_nan=False) if self.json else _as_text(told))
        return 0

    def _axis(self) -> Axis:
        from dataclasses import fields, replace

        from mobius.control.governor import AXES

        named = {a.name: a for a in AXES}
        if self.axis not in named:
            raise UnknownName("axis", self.axis, named)
        asked = {f.name: getattr(self, f.name) for f in fields(AXES[0]) if hasattr(self, f.name)}
        return replace(named[self.axis], **{k: v for k, v in asked.items() if v is not None})

    def _write(self, axis: Axis, rows: AdmissibleSet, told: dict[str, Any]) -> None:
        if self.save is not None:
            from mobius.files import write_json_atomic

            try:
                rows.save(self.save)
                write_json_atomic(self.save.with_suffix(".json"), told)
            except OSError as error:
                raise InvalidInput(
                    f"--save: {self.save} cannot be written ({error.strerror}); choose another file"
                ) from None
        if self.png is not None:
            from mobius.reproduce.fig_18 import draw

            draw(self.png, axis, rows)


def _told(axis: Axis, rows: AdmissibleSet, seconds: float) -> dict[str, Any]:
    from dataclasses import asdict

    return {
        "axis": {**asdict(axis), "environment": list(axis.environment)},
        **rows.as_json(),
        "build_cpu_s": seconds,
        "steady_position": rows.steady_range([1.0, 0.0]),
        "steady_wrench_reference": rows.steady_range([0.0, 1.0]),
    }


def _as_text(told: dict[str, Any]) -> str:
    lines = [
        f"{told['rows']} rows over {told['states']} states and {told['references']} references,"
        f" built in {told['build_cpu_s']:.2f} s of processor time",
        f"looked ahead {told['horizon_steps']} steps; rows moved in by {100 * told['loss']:.1f} %"
        " for the pruning",
        f"references that can be held: position +-{told['steady_position']:.4g},"
        f" wrench +-{told['steady_wrench_reference']:.4g}",
        f"share of states within limits that is admissible: {told['exact_share']:.3f}",
        "the same in the air, without servo lag and outside force:"
        f" {told['bare_exact_share']:.3f} exact, {told['bare_sampled_share']:.3f} by Algorithm 3"
        f" repaired (volume ratio {told['sampled_over_exact']:.2f},"
        f" {100 * told['sampled_unsafe']:.1f} % of it unsafe)",
    ]
    return "\n".join(lines)
