"""``mobius pullup`` and ``mobius eval pullup``: one pull-up on film, many as figures."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from mobius.cli.common import Bar, Series, at_least
from mobius.errors import InvalidInput

MOST_PUSH = 60.0
"""Harder pushes than this are surely typing errors [N]."""


def _pushes(push: tuple[float, ...]) -> tuple[float, ...]:
    for force in push:
        if not 0.0 < force <= MOST_PUSH:
            raise InvalidInput(f"--push: expected newtons in (0, {MOST_PUSH:g}], got {force:g}")
    return push


@dataclass
class PullUpVerb:
    """One simulated pull-up: dead hang, head above the bar, pushes down, and back."""

    push: tuple[float, ...] = (15.0, 30.0)
    """Down on the trunk while it holds, for 1 s each [N], in (0, 60]."""
    seed: int = 0
    """Seed of bar, mass, grasps and sensor noise; any whole number >= 0."""
    randomised: bool = True
    """Draw bar, robot and grasps from the seed; --no-randomised runs the drawing itself."""
    video: bool = True
    """Draw the video; --no-video leaves sheet, plot and JSON."""
    out: Path = Path("runs/pullup")
    """Folder for the files; new or empty."""

    def __call__(self) -> int:
        """Run, write, say how it went; 1 where it was no success."""
        from mobius.headless import import_mujoco

        at_least("--seed", self.seed, 0)
        pushes = _pushes(self.push)
        import_mujoco()
        from mobius.evaluate.pullup import PullUpDraw, draw_of
        from mobius.evaluate.pullup_report import record_pullup, write_pullup
        from mobius.evaluate.pullup_trials import PullUps, as_text
        from mobius.results import staged
        from mobius.view.gl import gl_backend

        gl_backend()  # says now, not after the run, that nothing can be drawn here
        draw = draw_of(self.seed) if self.randomised else PullUpDraw(seed=self.seed)
        with Bar() as bar, staged(self.out) as folder:
            bar("pull up", 0.0)
            trial, recording = record_pullup(draw, pushes=pushes)
            files = write_pullup(folder, draw, trial, recording, video=self.video, progress=bar)
        print(as_text(PullUps(self.seed, pushes, [trial])))
        for file in files:
            print(self.out / file.name)
        if not trial.success:
            print(f"mobius: {trial.why}", file=sys.stderr)
        return 0 if trial.success else 1


@dataclass
class EvalPullUp(Series):
    """Pull-ups over many seeds: bar, mass, friction and both grasps' limit surfaces drawn."""

    push: tuple[float, ...] = (15.0, 30.0)
    """Down on the trunk while it holds, for 1 s each [N], in (0, 60]."""

    def __call__(self) -> int:
        """Run the trials and print."""
        from mobius.headless import import_mujoco

        self.check()
        pushes = _pushes(self.push)
        import_mujoco()
        from mobius.evaluate.pullup_trials import as_text, pullup_trials

        return self.judge("pullup", partial(pullup_trials, pushes=pushes), as_text)
