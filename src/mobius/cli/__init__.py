"""``mobius``: one command for everything. Each verb imports what it needs when it runs."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from typing import Any

import tyro

from mobius.cli.drive import Demo, Run
from mobius.cli.energy import EvalEnergy
from mobius.cli.evaluate import Eval
from mobius.cli.export import Export
from mobius.cli.export_model import Model
from mobius.cli.governor import EvalGovernor, Moas
from mobius.cli.grasp import EvalGrasp
from mobius.cli.live import Drive
from mobius.cli.machine import Bench, Doctor
from mobius.cli.motions import EvalMotions
from mobius.cli.plan import PlanVerb
from mobius.cli.pullup import EvalPullUp, PullUpVerb
from mobius.cli.reel import Reel
from mobius.cli.replay import Replay
from mobius.cli.ros2 import Ros2
from mobius.cli.sweep import Sweep
from mobius.cli.train import Train
from mobius.cli.tune import EvalTuning, Tune
from mobius.errors import MobiusError, UnknownName

VERBS: dict[str, Callable[..., Any]] = {
    "demo": Demo,
    "run": Run,
    "drive": Drive,
    "plan": PlanVerb,
    "replay": Replay,
    "export": Export,
    "ros2": Ros2,
    "model": Model,
    "reel": Reel,
    "pullup": PullUpVerb,
    "sweep": Sweep,
    "train": Train,
    "tune": Tune,
    "eval": Eval,
    "moas": Moas,
    "bench": Bench,
    "doctor": Doctor,
}
EVALS: dict[str, Callable[..., Any]] = {
    "motions": EvalMotions,
    "energy": EvalEnergy,
    "grasp": EvalGrasp,
    "governor": EvalGovernor,
    "tuning": EvalTuning,
    "pullup": EvalPullUp,
}
"""What ``mobius eval`` knows beside the walking bodies, each with options of its own."""


def main(argv: list[str] | None = None) -> int:
    """Entry point; returns the exit code."""
    args = sys.argv[1:] if argv is None else argv
    try:
        if args and not args[0].startswith("-") and args[0] not in VERBS:
            raise UnknownName("verb", args[0], VERBS)
        if args[:1] == ["eval"] and args[1:2] and args[1] in EVALS:
            return int(tyro.cli(EVALS[args[1]], prog=f"mobius eval {args[1]}", args=args[2:])())
        verb = tyro.extras.subcommand_cli_from_dict(
            VERBS,
            prog="mobius",
            description="The software stack of a robot that walks, crawls, rolls and climbs.",
            args=args,
        )
        return int(verb())
    except MobiusError as error:
        print(f"mobius: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("mobius: stopped by the user; no half-written folder was left", file=sys.stderr)
        return 130


def entry() -> None:
    """Console script; ends quietly where the reader of its output has gone (``| head``)."""
    try:
        code = main()
        sys.stdout.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = 128 + 13
    sys.exit(code)
