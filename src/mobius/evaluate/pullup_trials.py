"""Many pull-ups, and what they say together."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from mobius.evaluate.jobs import run_jobs
from mobius.evaluate.pullup import PUSHES, PullUpTrial, draw_of, run_pullup

__all__ = ["PullUps", "as_text", "pullup_trials"]


@dataclass(frozen=True, eq=False)
class PullUps:
    """The outcome of ``mobius eval pullup``."""

    first_seed: int
    pushes: tuple[float, ...]
    """[N]."""
    trials: list[PullUpTrial]

    @property
    def successes(self) -> int:
        """Trials without a fault."""
        return sum(t.success for t in self.trials)

    @property
    def impossible(self) -> int:
        """Trials that failed and whose grasps could not have borne weight and push."""
        return sum(not t.success and not t.possible for t in self.trials)

    def as_json(self) -> dict[str, Any]:
        """Plain values."""
        pushed = [t.truth.return_error_m for t in self.trials if t.truth.return_error_m]
        worst = np.array([max(e) for e in pushed] or [np.nan])
        good = [t for t in self.trials if t.success]

        def over(values: list[float]) -> float | None:
            return float(np.max(values)) if values else None

        return {
            "trials": len(self.trials),
            "successes": self.successes,
            "impossible_grasps": self.impossible,
            "return_error_m": float(np.median(worst)) if pushed else None,
            "return_error_max_m": over(
                [max(t.truth.return_error_m) for t in good if t.truth.return_error_m]
            ),
            "head_min_m": None if not good else float(min(t.truth.head_m for t in good)),
            "lifted_median_m": None
            if not good
            else float(np.median([t.truth.lifted_m for t in good])),
            "slip_max_m": over([max(t.truth.slip_m) for t in good]),
            "torque_max": over([t.truth.torque_max for t in good]),
            "saturated_share_max": over([t.truth.saturated_share for t in good]),
            "pushes_N": list(self.pushes),
            "first_seed": self.first_seed,
            "failures": {str(t.seed): t.why for t in self.trials if not t.success},
            "runs": [
                {"seed": t.seed, "success": t.success, "possible": t.possible, "why": t.why}
                | t.truth.as_json()
                for t in self.trials
            ],
        }


def pullup_trials(
    *,
    seeds: int,
    seed: int = 0,
    pushes: tuple[float, ...] = PUSHES,
    workers: int = 0,
    progress: Callable[[float], None] | None = None,
) -> PullUps:
    """One pull-up a seed.

    Args:
        seeds: Number of them.
        seed: The first.
        pushes: Down on the trunk [N].
        workers: Processes; 0 takes one a CPU.
        progress: Called with the share done.
    """
    jobs = [(s, pushes) for s in range(seed, seed + seeds)]
    return PullUps(seed, pushes, run_jobs(_one, jobs, workers=workers, progress=progress))


def _one(job: tuple[int, tuple[float, ...]]) -> PullUpTrial:
    seed, pushes = job
    return run_pullup(draw_of(seed), pushes=pushes)


def as_text(result: PullUps) -> str:
    """For people."""
    figures = result.as_json()
    n, possible = len(result.trials), len(result.trials) - result.impossible
    lines = [
        f"pull-ups {result.successes} of {n}"
        f" ({result.successes} of {possible} where the grasps could bear it)",
    ]
    if figures["return_error_m"] is not None:
        back = f"{1e3 * figures['return_error_m']:.1f} mm in the median"
        worst = figures["return_error_max_m"]
        more = "" if worst is None else f", {1e3 * worst:.1f} mm at most where it succeeded"
        lines.append(f"3 s after a push the trunk is off by {back}{more}")
    if figures["head_min_m"] is not None:
        lines.append(
            f"head above the bar by {1e3 * figures['head_min_m']:.0f} mm or more,"
            f" lifted by {1e2 * figures['lifted_median_m']:.0f} cm;"
            f" greatest torque {figures['torque_max']:.2f} of stall,"
            f" saturated {1e2 * figures['saturated_share_max']:.2f} % of the time at most"
        )
    lines += [f"seed {s}: {why}" for s, why in figures["failures"].items()]
    return "\n".join(lines)
