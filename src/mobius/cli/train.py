"""The verb that trains a policy, and the one option that looks at what stopped a training."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro
from tyro.conf import Positional

from mobius.cli.common import at_least, need_train
from mobius.errors import InvalidInput


@dataclass
class Train:
    """Learn a locomotion policy with PPO and export it as ONNX (needs mobius[train])."""

    body: Positional[str] = ""
    """Which body learns: crawl or biped."""
    preset: str = "fast"
    """smoke (seconds, learns nothing), fast, fast-rough (two cores), paper, paper-rough; crawl
    has fast-low, too, with lower swings, fast-polish, which goes on from fast-low, and fast-narrow,
    the stance of the keyframe, which fast-rough goes on from."""
    out: Path = Path("runs/train")
    """Run folder: checkpoint, progress, policy.onnx."""
    seed: int = 0
    """Seed of network, sampling and simulation; any whole number >= 0."""
    steps: int | None = None
    """Environment steps in all, > 0; the preset's own if left out."""
    threads: int = 0
    """CPU threads of the physics, >= 0; 0 takes all. What is learned does not depend on it."""
    resume: bool = False
    """Continue the run in --out exactly where its last checkpoint was."""
    init: Annotated[Path | None, tyro.conf.arg(name="from")] = None
    """Run folder whose networks to start from, e.g. flat ground before uneven; nothing else."""
    replay: Path | None = None
    """Do again what stopped a run: a file from its nan folder. Nothing is trained."""

    def __call__(self) -> int:
        """Train, export, say where."""
        import os
        from dataclasses import replace

        os.environ.setdefault("OMP_WAIT_POLICY", "passive")
        need_train()
        from mobius.headless import import_mujoco

        import_mujoco()
        if self.replay is not None:
            return _replay(self.replay)
        from mobius.train.export import export
        from mobius.train.learn import train
        from mobius.train.presets import preset_of

        if not self.body:
            raise InvalidInput("expected a body; type mobius train crawl or mobius train biped")
        preset = preset_of(self.body, self.preset)
        if preset.warm is not None and self.init is None and not self.resume:
            raise InvalidInput(
                f"{self.preset} goes on from a run of '{preset.warm}'; name its folder with --from"
            )
        at_least("--seed", self.seed, 0)
        at_least("--threads", self.threads, 0)
        if self.steps is not None:
            at_least("--steps", self.steps, 1)
            preset = replace(preset, steps=self.steps)
        with TrainBar(f"{self.body} {self.preset}", preset.steps) as bar:
            train(
                preset,
                self.out,
                seed=self.seed,
                threads=self.threads,
                resume=self.resume,
                init=self.init,
                progress=bar,
            )
        policy = self.out / "policy.onnx"
        difference = export(preset, self.preset, self.out, policy)
        print(f"{policy} (torch and onnxruntime differ by {difference:.1e})")
        return 0


def _replay(path: Path) -> int:
    """Exit code 1 when it happens again."""
    from mobius.train.guard import replay

    again = replay(path)
    print(f"recorded, not finite: {again.recorded}")
    if again.seen is None:
        print("replayed: everything is finite")
        return 0
    print(f"replayed, not finite: {again.seen}")
    return 1


class TrainBar:
    """Steps, steps a second, time left and tracking error; silent where that is no terminal."""

    def __init__(self, what: str, steps: int) -> None:
        from tqdm import tqdm

        self._bar = tqdm(
            total=steps,
            desc=what,
            unit=" steps",
            unit_scale=True,
            disable=None,
            leave=False,
            file=sys.stderr,
            smoothing=0.1,
        )

    def __enter__(self) -> TrainBar:
        return self

    def __call__(self, figures: dict[str, float]) -> None:
        """Show the figures of an iteration."""
        done = int(figures["steps"])
        if self._bar.n == 0:  # what a resumed run did before counts for no rate
            self._bar.initial = self._bar.n = done - done // int(figures["iteration"])
        self._bar.set_postfix_str(
            f"error {figures['error/linear']:.3f} m/s {figures['error/yaw']:.3f} rad/s",
            refresh=False,
        )
        self._bar.update(min(done, self._bar.total) - self._bar.n)
        self._bar.refresh()

    def __exit__(self, *_: object) -> None:
        self._bar.close()
