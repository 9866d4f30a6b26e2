"""``mobius bench`` and ``mobius doctor``: about this machine."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass
class Bench:
    """Time the planner, the physics and the loop on this machine."""

    out: Path | None = None
    """Write the figures as JSON here as well."""

    def __call__(self) -> int:
        """Measure and print."""
        from mobius.bench import bench
        from mobius.headless import import_mujoco

        import_mujoco()
        figures = bench()
        for name, value in figures.items():
            print(f"{name:40s} {value:12.4g}")
        if self.out is not None:
            from mobius.files import write_json_atomic

            self.out.parent.mkdir(parents=True, exist_ok=True)
            write_json_atomic(self.out, figures)
        return 0


@dataclass
class Doctor:
    """Print versions, graphics and known-bad combinations, for bug reports."""

    json: bool = False
    """Print one JSON object and nothing else."""

    def __call__(self) -> int:
        """Examine this environment."""
        from mobius.doctor import main as doctor

        return int(doctor(as_json=self.json))
