"""``mobius tune`` and ``mobius eval tuning``: gains of the force loop, tuned while it works."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tyro.conf import Positional

from mobius.cli.common import Series, at_least, png_file
from mobius.errors import InvalidInput, UnknownName

if TYPE_CHECKING:
    from mobius.control.tuning import Report

CONTACTS = ("wall", "bar", "peg", "two_arms")


@dataclass
class Tune:
    """Tune admittance gains on a simulated contact and print the run."""

    contact: Positional[str] = "wall"
    """wall, bar, peg, or two_arms (two grippers that hold one rigid bar and fight)."""
    stiffness: float | None = None
    """Of the contact [N/m], > 0; 5000, for two_arms 15000."""
    start: str = "one_for_all"
    """First gains: one_for_all (safe with every contact up to 50 kN/m) or guess (for this
    contact, its stiffness guessed wrong by up to a factor of 3). two_arms has its own."""
    seed: int = 0
    """Of all that is drawn; any whole number >= 0."""
    json: bool = False
    """Print one JSON object and nothing else."""
    png: Path | None = None
    """Also draw the run into this .png file."""

    def __call__(self) -> int:
        """Tune, draw and print."""
        if self.contact not in CONTACTS:
            raise UnknownName("contact", self.contact, CONTACTS)
        if self.contact == "two_arms" and self.start != Tune.start:
            raise InvalidInput("--start does not go with two_arms, which has its own first gains")
        at_least("--seed", self.seed, 0)
        png_file("--png", self.png)
        if self.stiffness is not None and not 0 < self.stiffness < 1e9:
            raise InvalidInput(f"--stiffness: expected N/m > 0, got {self.stiffness:g}")
        result = self._two_arms() if self.contact == "two_arms" else self._one()
        if self.json:
            print(json.dumps(result, allow_nan=False))
            return 0
        print(self._as_text(result))
        if self.png is not None:
            print(f"written to {self.png}")
        return 0

    def _one(self) -> dict[str, Any]:
        from mobius.evaluate.tuning import tune_case

        stiffness = self.stiffness or 5000.0
        case, run = tune_case(self.contact, stiffness, seed=self.seed, start=self.start)
        if self.png is not None:
            self._draw_one(stiffness, case.gains_before, run)
        return {
            "contact": self.contact,
            "stiffness_N_per_m": stiffness,
            "force_rmse_before_N": case.before,
            "force_rmse_after_N": case.after,
            "force_rmse_change": case.change,
            "settled_s": case.settled_s,
            "unstable": case.unstable,
            "gains_before": case.gains_before,
            "gains_after": case.gains_after,
            "windows": _windows(run.reports),
        }

    def _draw_one(self, stiffness: float, first: dict[str, float], run: Any) -> None:
        import numpy as np

        from mobius.control.admittance import DT, AxisGains
        from mobius.evaluate.contact import Contact, references
        from mobius.evaluate.tuning import TUNE_S, own_seed
        from mobius.evaluate.tuning import run as play
        from mobius.view.tuning_picture import Curve

        contact = Contact(self.contact, stiffness)
        untuned = play(contact, AxisGains(**first), seconds=TUNE_S, seed=self.seed, wishes=1)
        w = references(
            contact, len(run.error), np.random.default_rng([*own_seed(contact, self.seed), 1])
        )
        t = np.linspace(0.0, (len(w) - 1) * DT, len(w))
        self._draw(
            [
                Curve("first gains kept", t, untuned.error[:, 0] + w[:, 0]),
                Curve("tuned", t, run.error[:, 0] + w[:, 0]),
            ],
            Curve("wished", t, w[:, 0]),
            run.reports,
            f"{self.contact}, {stiffness:g} N/m, first axis",
        )

    def _two_arms(self) -> dict[str, Any]:
        from mobius.control.tuning import Tuner
        from mobius.evaluate.two_arms import GRIP, bad_gains, hold_bar

        stiffness = self.stiffness or GRIP
        gains = bad_gains(stiffness)
        kept = hold_bar(gains, seed=self.seed, stiffness=stiffness)
        tuned = hold_bar(gains, seed=self.seed, stiffness=stiffness, tuner=Tuner(gains, 1))
        if self.png is not None:
            from mobius.view.tuning_picture import Curve

            self._draw(
                [
                    Curve("bad gains kept", kept.t, kept.internal),
                    Curve("tuned", tuned.t, tuned.internal),
                ],
                Curve("wished", tuned.t, tuned.wished),
                tuned.reports,
                f"two arms on one bar, grips of {stiffness:g} N/m: internal force",
            )
        return {
            "contact": "two_arms",
            "stiffness_N_per_m": stiffness,
            "force_rmse_before_N": kept.rmse(),
            "force_rmse_after_N": tuned.rmse(),
            "force_rmse_change": tuned.rmse() / kept.rmse() - 1.0,
            "grip_broke_before_s": float(kept.t[-1]) if kept.broke else None,
            "grip_broke_after_s": float(tuned.t[-1]) if tuned.broke else None,
            "gains_before": asdict(gains),
            "gains_after": asdict(tuned.gains),
            "windows": _windows(tuned.reports),
        }

    def _draw(self, curves: Any, wished: Any, reports: Any, title: str) -> None:
        from mobius.view.tuning_picture import draw_tuning

        assert self.png is not None
        names = ("D", "K", "K_f", "K_fi", "K_pi")
        draw_tuning(
            self.png,
            curves=curves,
            wished=wished,
            t=[t for t, _r in reports],
            gains={k: [getattr(r.gains, k) for _t, r in reports] for k in names},
            rmse=[r.force_rmse for _t, r in reports],
            title=title,
        )

    def _as_text(self, result: dict[str, Any]) -> str:
        lines = [" time  error, rms  stiffest, estimated  step     D [N s/m]  K_f"]
        for w in result["windows"][::2]:
            k = "-" if w["stiffness_N_per_m"] is None else f"{w['stiffness_N_per_m']:.0f} N/m"
            lines.append(
                f"{w['t']:5.1f}  {w['force_rmse_N']:8.2f} N  {k:>19s}  {w['verdict']:8s}"
                f" {w['gains']['D']:9.0f} {w['gains']['K_f']:5.2f}"
            )
        lines.append("gain      before     after")
        for name, value in result["gains_before"].items():
            lines.append(f"{name:5s} {value:10.4g} {result['gains_after'][name]:9.4g}")
        lines.append(
            f"force error {result['force_rmse_before_N']:.2f} -> {result['force_rmse_after_N']:.2f}"
            f" N ({100 * result['force_rmse_change']:+.0f} %)"
        )
        if result["contact"] == "two_arms":
            for what in ("before", "after"):
                at = result[f"grip_broke_{what}_s"]
                told = "held" if at is None else f"a grip broke at {at:.1f} s"
                lines.append(f"{what}: {told}")
        else:
            lines.append(
                f"settled after {result['settled_s']:.0f} s;"
                f" {'UNSTABLE at some time' if result['unstable'] else 'never unstable'}"
            )
        return "\n".join(lines)


def _windows(reports: Sequence[tuple[float, Report]]) -> list[dict[str, Any]]:
    return [
        {
            "t": round(t, 3),
            "verdict": r.verdict,
            "force_rmse_N": r.force_rmse,
            "stiffness_N_per_m": None if r.contact is None else r.contact.high,
            "spectral_radius": r.radius,
            "gains": asdict(r.gains),
        }
        for t, r in reports
    ]


@dataclass
class EvalTuning(Series):
    """How much tuning helps: 20 stiffnesses from 500 to 50000 N/m, wall, bar and peg."""

    seeds: int = 1
    """Number of seeds of each contact, >= 1."""
    start: str = "one_for_all"
    """First gains: one_for_all or guess, see mobius tune --help."""

    def __call__(self) -> int:
        """Evaluate and print."""
        from mobius.evaluate.tuning import tuning

        self.check()
        return self.judge("tuning", partial(tuning, start=self.start), _as_text)


def _as_text(tuned: Any) -> str:
    """A line a contact, and the sum of it."""
    result = tuned.as_json()
    lines = ["kind   stiffness   before    after  change  settled"]
    for c in result["runs"]:
        lines.append(
            f"{c['kind']:5s} {c['stiffness']:7.0f} N/m {c['before']:6.2f} N {c['after']:6.2f} N"
            f" {100 * c['change']:+5.0f} %  {c['settled_s']:4.0f} s"
            f"{'  UNSTABLE' if c['unstable'] else ''}"
        )
    lines.append(
        f"force error: median {100 * result['force_rmse_change']:+.0f} %, worst"
        f" {100 * result['force_rmse_change_worst']:+.0f} %; settled after"
        f" {result['settled_s']:.0f} s, at most {result['settled_s_worst']:.0f} s; unstable"
        f" {result['unstable']} of {result['cases']}"
    )
    return "\n".join(lines)
