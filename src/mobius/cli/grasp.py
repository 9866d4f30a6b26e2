"""``mobius eval grasp``: what a hand holds on a bar (Table IX)."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

from mobius.cli.common import Bar, at_least


@dataclass
class EvalGrasp:
    """Pull the spine grasp on a bar to failure, along the groove (x) and across it (z)."""

    seeds: int = 1000
    """Pulls along each axis, >= 1; each is a fresh grasp with its own limits."""
    seed: int = 0
    """The first seed; any whole number >= 0."""
    workers: int = 0
    """Processes, >= 0; 0 takes one a CPU."""
    json: bool = False
    """Print one JSON object and nothing else."""
    out: Path | None = None
    """Folder for grasp.json; new or empty."""

    def __call__(self) -> int:
        """Pull, write and print."""
        from mobius.headless import import_mujoco

        at_least("--seeds", self.seeds, 1)
        at_least("--seed", self.seed, 0)
        at_least("--workers", self.workers, 0)
        import_mujoco()
        from contextlib import nullcontext

        from mobius.files import write_json_atomic
        from mobius.pulls import pull_to_failure
        from mobius.reproduce.common import as_text
        from mobius.results import staged

        with nullcontext() if self.out is None else staged(self.out) as folder:
            with Bar() as bar:
                result = pull_to_failure(
                    seeds=self.seeds,
                    seed=self.seed,
                    workers=self.workers,
                    progress=lambda share: bar("grasp", share),
                )
            if folder is not None:
                write_json_atomic(folder / "grasp.json", result.as_json())
        text = as_text(result.rows())
        print(json.dumps(result.as_json(), allow_nan=False) if self.json else text)
        return 0
