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
from mobius.cli.machine import Bench, Doctor
from mobius.cli.motions import EvalMotions
from mobius.cli.plan import PlanVerb
from mobius.cli.pullup import EvalPullUp, PullUpVerb
from mobius.cli.reel import Reel
from mobius.cli.sweep import Sweep
from mobius.cli.train import Train
from mobius.errors import MobiusError, UnknownName

VERBS: dict[str, Callable[..., Any]] = {
    "demo": Demo,
    "run": Run,
    "plan": PlanVerb,
    "reel": Reel,
    "pullup": PullUpVerb,
    "sweep": Sweep,
    "train": Train,
    "eval": Eval,
    "bench": Bench,
    "doctor": Doctor,
}


def main(argv: list[str] | None = None) -> int:
    """Entry point; returns the exit code."""
    args = sys.argv[1:] if argv is None else argv
    try:
        if args and not args[0].startswith("-") and args[0] not in VERBS:
            raise UnknownName("verb", args[0], VERBS)
        if args[:2] == ["eval", "motions"]:
            return int(tyro.cli(EvalMotions, prog="mobius eval motions", args=args[2:])())
        if args[:2] == ["eval", "energy"]:
            return int(tyro.cli(EvalEnergy, prog="mobius eval energy", args=args[2:])())
        if args[:2] == ["eval", "pullup"]:
            return int(tyro.cli(EvalPullUp, prog="mobius eval pullup", args=args[2:])())
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
