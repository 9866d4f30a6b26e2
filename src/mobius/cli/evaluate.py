"""``mobius eval``: measure a policy."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tyro.conf import Positional

from mobius.cli.common import Bar, at_least
from mobius.errors import InvalidInput, UnknownName

if TYPE_CHECKING:
    from mobius.evaluate import Outcome

SEEDS = {"tracking": 100, "push": 100, "terrain": 100, "robustness": 20}
"""Seeds where none are asked for."""
BELONGS = {"speed": "tracking", "kind": "terrain", "sweep": "robustness", "as_force": "push"}
"""Options that go with one evaluation only."""


@dataclass
class Eval:
    """Measure a policy in the whole stack over many seeds."""

    body: Positional[str]
    """Which body: crawl or biped. Motions between bodies, what a metre costs and the tuning of
    force gains have their own help: mobius eval motions --help, mobius eval energy --help,
    mobius eval tuning --help."""
    what: Positional[str] = "tracking"
    """What to measure: tracking (five commands held 4 s each), push (shoves of 0.1 s, harder
    until it falls), terrain (20 s on other ground) or robustness (one property changed)."""
    policy: str | None = None
    """ONNX file, flat, rough, zero (holds the stance) or random; the shipped flat one if left
    out."""
    seeds: int | None = None
    """Number of seeds, >= 1: 100, for robustness 20 a point."""
    seed: int = 0
    """The first seed; any whole number >= 0."""
    randomised: bool = True
    """Draw robot, floor and sensors from each seed (robustness never does)."""
    speed: float = 1.0
    """tracking: factor on all commands, > 0; crawl goes to 0.7 m/s with 1."""
    kind: tuple[str, ...] = ()
    """terrain: heightmap, slope, steps, slippery, soft; all if left out."""
    sweep: tuple[str, ...] = ()
    """robustness: friction, payload, delay, motor, noise; all if left out."""
    as_force: bool = False
    """push: as a force, which the accelerometer feels, not as a change of velocity."""
    workers: int = 0
    """Processes, >= 0; 0 takes one a CPU."""
    json: bool = False
    """Print one JSON object and nothing else."""
    out: Path | None = None
    """Folder for JSON, CSV tables and a PNG picture; new or empty."""

    def __call__(self) -> int:
        """Evaluate, write and print."""
        from mobius.headless import import_mujoco

        self._check()
        import_mujoco()
        from mobius.evaluate.tables import as_text

        with self._folder() as folder:
            result = self._evaluate()
            if folder is not None:
                self._write(folder, result)
        if self.json:
            print(json.dumps(result.as_json(), allow_nan=False))
            return 0
        print(as_text(result))
        if self.out is not None:
            print(f"written to {self.out}")
        return 0

    def _check(self) -> None:
        if self.what not in SEEDS:
            raise UnknownName("evaluation", self.what, SEEDS)
        at_least("--seeds", self._seeds, 1)
        at_least("--seed", self.seed, 0)
        at_least("--workers", self.workers, 0)
        for option, what in BELONGS.items():
            if getattr(self, option) != getattr(Eval, option) and self.what != what:
                raise InvalidInput(
                    f"--{option.replace('_', '-')} goes with {what}, not with {self.what}"
                )

    @property
    def _seeds(self) -> int:
        return SEEDS[self.what] if self.seeds is None else self.seeds

    @contextmanager
    def _folder(self) -> Iterator[Path | None]:
        """Where to write; it gets its name when everything is there."""
        if self.out is None:
            yield None
            return
        from mobius.results import staged

        with staged(self.out) as folder:
            yield folder

    def _evaluate(self) -> Outcome:
        from mobius import evaluate
        from mobius.control.peers import controller_of

        controller_of(self.policy, self.body)  # a mistake shows before the work begins
        with Bar() as bar:
            common: dict[str, Any] = {
                "seeds": self._seeds,
                "seed": self.seed,
                "policy": self.policy,
                "workers": self.workers,
                "progress": lambda share: bar(self.what, share),
            }
            drawn = {**common, "randomised": self.randomised}
            if self.what == "tracking":
                return evaluate.tracking(self.body, speed=self.speed, **drawn)
            if self.what == "push":
                return evaluate.push(self.body, as_force=self.as_force, **drawn)
            if self.what == "terrain":
                return evaluate.terrain(self.body, kinds=self.kind or evaluate.KINDS, **drawn)
            sweeps = self.sweep or tuple(evaluate.SWEEPS)
            return evaluate.robustness(self.body, sweeps=sweeps, **common)

    def _write(self, folder: Path, result: Outcome) -> None:
        from mobius.evaluate.episode import Setup
        from mobius.evaluate.motions import motions
        from mobius.evaluate.write import write_outcome

        series = []
        if self.what == "tracking":
            setup = Setup(self.body, self.seed, self.policy, self.randomised)
            series = motions(setup, speed=self.speed, workers=self.workers)
        write_outcome(folder, result, series=series)
