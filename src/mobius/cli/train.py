"""``mobius train``: learn a policy."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tyro.conf import Positional

from mobius.cli.common import Bar, at_least, need_train


@dataclass
class Train:
    """Learn a locomotion policy with PPO and export it as ONNX (needs mobius[train])."""

    body: Positional[str]
    """Which body learns: crawl or biped."""
    preset: str = "fast"
    """smoke (seconds, learns nothing) or fast (two cores; crawl a quarter of an hour)."""
    out: Path = Path("runs/train")
    """Run folder: checkpoint, progress, policy.onnx."""
    seed: int = 0
    """Seed of network, sampling and simulation; any whole number >= 0."""
    steps: int | None = None
    """Environment steps in all, > 0; the preset's own if left out."""
    threads: int = 0
    """CPU threads, >= 0; 0 takes all."""
    resume: bool = False
    """Continue the run in --out."""

    def __call__(self) -> int:
        """Train, export, say where."""
        import os
        from dataclasses import replace

        os.environ.setdefault("OMP_WAIT_POLICY", "passive")
        need_train()
        from mobius.headless import import_mujoco

        import_mujoco()
        from mobius.train.export import export
        from mobius.train.learn import train
        from mobius.train.presets import preset_of

        preset = preset_of(self.body, self.preset)
        at_least("--seed", self.seed, 0)
        at_least("--threads", self.threads, 0)
        if self.steps is not None:
            at_least("--steps", self.steps, 1)
            preset = replace(preset, steps=self.steps)
        with Bar() as bar:

            def show(figures: dict[str, float]) -> None:
                done = figures["steps"] / preset.steps
                bar(
                    f"{figures['steps'] / 1e6:.2f}M steps {figures['steps_per_s']:.0f}/s"
                    f" error {figures['error/linear']:.3f} m/s {figures['error/yaw']:.3f} rad/s",
                    done,
                )

            train(
                preset,
                self.out,
                seed=self.seed,
                threads=self.threads,
                resume=self.resume,
                progress=show,
            )
        policy = self.out / "policy.onnx"
        difference = export(preset, self.preset, self.out, policy)
        print(f"{policy} (torch and onnxruntime differ by {difference:.1e})")
        return 0
