"""``mobius eval energy``: what a metre costs in each mode."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

from mobius.cli.common import Bar, at_least
from mobius.errors import InvalidInput


@dataclass
class EvalEnergy:
    """Measure joule per metre and cell, speed and changes of body of each mode in physics.

    The file that --out names is what ``mobius plan --costs`` reads.
    """

    modes: tuple[str, ...] = ("crawl", "biped", "roll")
    """Modes to measure: crawl, biped, roll."""
    switches: bool = True
    """Also measure changes between crawl and biped, if both are measured."""
    seeds: int = 5
    """Number of seeds, >= 1."""
    seed: int = 0
    """The first seed; any whole number >= 0."""
    randomised: bool = True
    """Draw robot, floor and sensors from each seed."""
    workers: int = 0
    """Processes, >= 0; 0 takes one a CPU."""
    json: bool = False
    """Print one JSON object with every figure and nothing else."""
    out: Path | None = None
    """JSON file for the planner's costs; replaced if it is there."""

    def __call__(self) -> int:
        """Measure, write and print."""
        from mobius.files import write_json_atomic
        from mobius.headless import import_mujoco

        at_least("--seeds", self.seeds, 1)
        at_least("--seed", self.seed, 0)
        at_least("--workers", self.workers, 0)
        if self.out is not None and (self.out.is_dir() or not self.out.parent.is_dir()):
            raise InvalidInput(f"--out: {self.out} is no file in a folder that is there")
        import_mujoco()
        from mobius.evaluate.energy import energy

        names = [n.strip() for word in self.modes for n in word.split(",") if n.strip()]
        with Bar() as bar:
            result = energy(
                modes=names,
                switches=self.switches,
                seeds=self.seeds,
                seed=self.seed,
                randomised=self.randomised,
                workers=self.workers,
                progress=lambda share: bar("energy", share),
            )
        if self.out is not None:
            write_json_atomic(self.out, result.travel().as_json())
        if self.json:
            print(json.dumps(result.as_json(), allow_nan=False))
            return 0
        print("mode      m/s    J/m  J/cell  cost of transport  trials  failed")
        for name, m in result.modes.items():
            cell = "-" if m.J_per_cell is None else f"{m.J_per_cell:.1f}"
            print(
                f"{name:6s} {m.m_per_s:6.3f} {m.J_per_m:6.1f} {cell:>7s}"
                f" {m.cost_of_transport:18.2f} {m.trials:7d} {m.failures:7d}"
            )
        for name, s in result.switches.items():
            print(f"{name}: {s.s:.1f} s, {s.J:.0f} J ({s.failures} of {s.trials} failed)")
        if self.out is not None:
            print(f"written to {self.out}")
        return 0
