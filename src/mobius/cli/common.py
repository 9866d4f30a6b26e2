"""What several verbs share: checks of options and a progress bar."""

from __future__ import annotations

import sys
from pathlib import Path

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
