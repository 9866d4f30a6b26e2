"""``mobius eval grasp``: what a hand holds on a bar (Table IX)."""

from __future__ import annotations

from dataclasses import dataclass

from mobius.cli.common import Series


@dataclass
class EvalGrasp(Series):
    """Pull the spine grasp on a bar to failure, along the groove (x) and across it (z)."""

    seeds: int = 1000
    """Pulls along each axis, >= 1; each is a fresh grasp with its own limits."""

    def __call__(self) -> int:
        """Pull, write and print."""
        from mobius.headless import import_mujoco

        self.check()
        import_mujoco()
        from mobius.pulls import pull_to_failure
        from mobius.reproduce.common import as_text

        return self.judge("grasp", pull_to_failure, lambda result: as_text(result.rows()))
