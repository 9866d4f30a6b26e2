"""Trials of motions summed up: successes, times, torques, and how long the gears would last."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mobius.model.fatigue import ARM_GEAR, LEG_GEAR
from mobius.model.joints import JOINTS
from mobius.model.servo import servo_of

Array = NDArray[np.float64]

ESTIMATES = ("position_error_m", "yaw_error_deg")
ROLLING = ("speed_mps", "average_mps", "heading_error_deg")
"""Means over the runs that rolled."""


@dataclass
class TrialRun:
    """One seed of one trial."""

    trial: str
    seed: int
    success: bool
    why: str
    """Why it failed; empty if it did not."""
    seconds: float | None
    """From the begin of the motion to the stance [s]."""
    peak_Nm: list[float]
    """Largest torque of each joint of arms and legs [N m], order JOINTS."""
    rms_Nm: list[float]
    """Root mean square over the whole trial [N m]."""
    energy_J: float | None
    """Mechanical work of all servos until the stance [J]."""
    position_error_m: float
    """Distance over the floor between belief and truth in the stance [m]."""
    yaw_error_deg: float
    """And the difference of the headings [deg]."""
    speed_mps: float | None = None
    """Rolls: horizontal way over time, from where the hands let go of the floor until the trunk,
    turned over, is level to 20 deg again [m/s]."""
    average_mps: float | None = None
    """Rolls: with the stances between, from the begin of the first [m/s]."""
    heading_error_deg: float | None = None
    """Rolls: largest heading after one of them against that before the first [deg]."""
    push_ups: int | None = None
    """How often the trunk went 5 cm down and up."""
    gathers: tuple[int, int] = (0, 0)
    """How often it gathered, and how often it came to the end of that."""
    gather_lean_deg: float = 0.0
    """Farthest that the trunk was off the floor's normal meanwhile [deg]."""
    gather_slid_m: float = 0.0
    """Longest way that a foot slid while it pressed, once gathering [m]."""
    gather_force_N: float = 0.0
    """Hardest that a foot pressed on the floor [N]."""
    events: list[str] = field(default_factory=list)
    """Changes of mode."""


@dataclass
class Motions:
    """The outcome of ``mobius eval motions``."""

    seed: int
    """The first seed."""
    seeds: int
    """Seeds a trial."""
    motions: dict[str, dict[str, Any]]
    """Figures by trial."""
    runs: list[TrialRun] = field(default_factory=list)

    def as_json(self) -> dict[str, Any]:
        """Plain values."""
        return asdict(self)


def summarise(runs: Sequence[TrialRun], *, seeds: int, seed: int) -> Motions:
    """Figures of each trial, in the order of the runs."""
    names = dict.fromkeys(r.trial for r in runs)
    figures = {name: figures_of([r for r in runs if r.trial == name]) for name in names}
    return Motions(seed=seed, seeds=seeds, motions=figures, runs=list(runs))


def figures_of(runs: Sequence[TrialRun]) -> dict[str, Any]:
    """Figures of one trial: times and errors over its successes, torques over all runs."""
    well = [r for r in runs if r.success]
    peak = np.max([r.peak_Nm for r in runs], axis=0)
    rms = np.sqrt(np.mean(np.square([r.rms_Nm for r in runs]), axis=0))
    figures: dict[str, Any] = {
        "trials": len(runs),
        "successes": len(well),
        "median_s": _middle([r.seconds for r in well]),
        "peak_torque_Nm": float(peak.max()),
        "rms_torque_Nm": float(rms.max()),
        "energy_J": _middle([r.energy_J for r in well]),
        **{name: _middle([getattr(r, name) for r in well]) for name in ESTIMATES},
        "joints": {
            joint: {"peak_Nm": float(p), "rms_Nm": float(r)}
            for joint, p, r in zip(JOINTS, peak, rms, strict=False)
        },
        "gear_life_cycles": gear_lives(peak),
        "failures": {str(r.seed): r.why for r in runs if not r.success},
    }
    begun, ended = np.sum([r.gathers for r in runs], axis=0).tolist()
    if begun:
        of = [r for r in runs if r.gathers[0]]
        figures["gathers"] = {"begun": begun, "done": ended} | {
            name: {
                "median": float(np.median([getattr(r, f"gather_{name}") for r in of])),
                "most": float(max(getattr(r, f"gather_{name}") for r in of)),
            }
            for name in ("lean_deg", "slid_m", "force_N")
        }
    if any(r.heading_error_deg is not None for r in runs):
        figures |= {name: _mean([getattr(r, name) for r in well]) for name in ROLLING}
    return figures


def gear_lives(peak: Array) -> dict[str, float]:
    """Load cycles until a tooth of a five-bar's drive breaks at the motion's peak torque.

    Eq. (1) and Fig. 5 (:mod:`mobius.model.fatigue`), for the torque (20,) [N m] of each crank;
    where two servos share a shaft each gear carries half.
    """
    lives = {}
    for joint, torque in zip(JOINTS, peak, strict=False):
        if "motor" in joint and torque > 0:
            gear = ARM_GEAR if "shoulder" in joint else LEG_GEAR
            lives[joint] = float(gear.life(torque / servo_of(joint).count))
    return lives


def as_text(result: Motions) -> str:
    """A result as lines for a terminal."""
    lines = [f"{result.seeds} seeds each from seed {result.seed}"]
    lines.append(f"{'motion':16s} trials successes median_s peak_torque_Nm")
    for name, f in result.motions.items():
        line = (
            f"{name:16s} {f['trials']:6d} {f['successes']:9d} {_cell(f['median_s'], 2):>8}"
            f" {f['peak_torque_Nm']:14.2f}"
        )
        if "speed_mps" in f:
            line += (
                f"  speed_mps {_cell(f['speed_mps'], 2)}"
                f"  heading_error_deg {_cell(f['heading_error_deg'], 1)}"
            )
        if "gathers" in f:
            line += f"  gathered {f['gathers']['done']} of {f['gathers']['begun']}"
            for name, digits in (("lean_deg", 1), ("slid_m", 3), ("force_N", 0)):
                g = f["gathers"][name]
                line += f"  {name} {g['median']:.{digits}f} (most {g['most']:.{digits}f})"
        lines.append(line)
        lines += [f"    seed {seed}: {why}" for seed, why in f["failures"].items()]
    return "\n".join(lines)


def _cell(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"


def _middle(values: Sequence[float | None]) -> float | None:
    there = [v for v in values if v is not None]
    return float(np.median(there)) if there else None


def _mean(values: Sequence[float | None]) -> float | None:
    there = [v for v in values if v is not None]
    return float(np.mean(there)) if there else None
