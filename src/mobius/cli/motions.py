"""``mobius eval motions``: trials of the motions between bodies."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path

from tyro.conf import Positional

from mobius.cli.common import Series


@dataclass
class EvalMotions(Series):
    """Trials of standing up, lying down, getting up from falls, rolling and push-ups."""

    names: Positional[tuple[str, ...]] = ()
    """prone_to_crawl, stand_to_crawl, crawl_to_stand, supine_recovery, head_recovery, any_fall,
    roll, five_rolls, push_ups, gather_stand, gather_roll; all if left out."""
    policy: Path | None = None
    """ONNX file that crawls; the shipped one if left out."""

    def __call__(self) -> int:
        """Run the trials and print."""
        from mobius.headless import import_mujoco

        self.check()
        import_mujoco()
        from mobius.evaluate.trial_report import as_text
        from mobius.evaluate.trials import motion_trials

        return self.judge(
            "motions", partial(motion_trials, self.names, policy=self.policy), as_text
        )
