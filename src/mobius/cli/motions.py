"""``mobius eval motions``: trials of the motions between bodies."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

from tyro.conf import Positional

from mobius.cli.common import Bar, at_least


@dataclass
class EvalMotions:
    """Trials of standing up, lying down, getting up from falls, rolling and push-ups."""

    names: Positional[tuple[str, ...]] = ()
    """prone_to_crawl, stand_to_crawl, crawl_to_stand, supine_recovery, head_recovery, any_fall,
    roll, five_rolls, push_ups; all if left out."""
    seeds: int = 100
    """Number of seeds of each, >= 1."""
    seed: int = 0
    """The first seed; any whole number >= 0."""
    workers: int = 0
    """Processes, >= 0; 0 takes one a CPU."""
    json: bool = False
    """Print one JSON object and nothing else."""
    out: Path | None = None
    """Folder for motions.json; new or empty."""

    def __call__(self) -> int:
        """Run the trials and print."""
        from mobius.headless import import_mujoco

        at_least("--seeds", self.seeds, 1)
        at_least("--seed", self.seed, 0)
        at_least("--workers", self.workers, 0)
        import_mujoco()
        from contextlib import nullcontext

        from mobius.evaluate.trial_report import as_text
        from mobius.evaluate.trials import motion_trials
        from mobius.files import write_json_atomic
        from mobius.results import staged

        with nullcontext() if self.out is None else staged(self.out) as folder:
            with Bar() as bar:
                result = motion_trials(
                    self.names,
                    seeds=self.seeds,
                    seed=self.seed,
                    workers=self.workers,
                    progress=lambda share: bar("motions", share),
                )
            if folder is not None:
                write_json_atomic(folder / "motions.json", result.as_json())
        text = json.dumps(result.as_json(), allow_nan=False) if self.json else as_text(result)
        print(text)
        return 0
