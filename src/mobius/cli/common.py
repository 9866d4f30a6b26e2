"""What several verbs share: checks of options and a progress bar."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mobius.errors import InvalidInput

XY = tuple[float, float]
"""x and y [m]."""
FAR = 1e9
"""No map reaches this far [m]."""


def at_least(option: str, value: int, low: int) -> None:
    """Refuse a whole number below ``low``."""
    if value < low:
        raise InvalidInput(f"{option}: expected a whole number >= {low}, got {value}")


def need_train() -> None:
    """Refuse to train without what training needs."""
    from importlib.util import find_spec

    from mobius.errors import MissingDependency

    for package in ("torch", "rsl_rl", "onnx", "safetensors"):
        if find_spec(package) is None:
            raise MissingDependency(package, "train", "training")


class Bar:
    """A progress bar on standard error; silent where that is no terminal."""

    def __enter__(self) -> Bar:
        from tqdm import tqdm

        self._bar = tqdm(total=100, unit="%", disable=None, leave=False, file=sys.stderr)
        return self

    def __call__(self, what: str, share: float) -> None:
        """Show what is going on and how much of it is done (0 to 1)."""
        self._bar.set_description(what)
        self._bar.n = round(100 * share)
        self._bar.refresh()

    def __exit__(self, *_: object) -> None:
        self._bar.close()


def place(option: str, xy: XY | None) -> None:
    """Refuse a point that can lie on no map."""
    if xy is not None and not all(abs(v) < FAR for v in xy):
        raise InvalidInput(
            f"{option}: expected two numbers x y [m] of less than {FAR:g}, got {xy[0]:g} {xy[1]:g}"
        )


def png_file(option: str, path: Path | None) -> None:
    """Refuse, before any work, a picture that could not be written in the end."""
    if path is None:
        return
    if path.suffix.lower() != ".png":
        raise InvalidInput(f"{option}: expected a file that ends in .png, got {path}")
    if path.is_dir():
        raise InvalidInput(f"{option}: {path} is a folder; name a file in it")


@dataclass
class Series:
    """Options of a judgement over many seeds, and what becomes of its result."""

    seeds: int = 100
    """Number of seeds, >= 1."""
    seed: int = 0
    """The first seed; any whole number >= 0."""
    workers: int = 0
    """Processes, >= 0; 0 takes one a CPU."""
    json: bool = False
    """Print one JSON object and nothing else."""
    out: Path | None = None
    """Folder for the JSON file; new or empty."""

    def check(self) -> None:
        """Refuse numbers that make no sense, before any work."""
        at_least("--seeds", self.seeds, 1)
        at_least("--seed", self.seed, 0)
        at_least("--workers", self.workers, 0)

    def judge(self, name: str, run: Callable[..., Any], as_text: Callable[[Any], str]) -> int:
        """Run, write ``name.json`` where asked to, and print.

        Args:
            name: Of the series.
            run: Called with ``seeds``, ``seed``, ``workers`` and ``progress``; its result has
                ``as_json()``.
            as_text: The result as a table.
        """
        from mobius.files import write_json_atomic
        from mobius.results import staged

        with nullcontext() if self.out is None else staged(self.out) as folder:
            with Bar() as bar:
                result = run(
                    seeds=self.seeds,
                    seed=self.seed,
                    workers=self.workers,
                    progress=lambda share: bar(name, share),
                )
            if folder is not None:
                write_json_atomic(folder / f"{name}.json", result.as_json())
        print(json.dumps(result.as_json(), allow_nan=False) if self.json else as_text(result))
        return 0
