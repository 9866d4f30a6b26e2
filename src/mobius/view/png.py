"""A matplotlib figure as a PNG file that is whole or absent."""

from __future__ import annotations

import io
from pathlib import Path

from matplotlib.figure import Figure

from mobius.errors import InvalidInput
from mobius.files import write_bytes_atomic

__all__ = ["save_png", "write_picture"]


def save_png(path: str | Path, figure: Figure, *, dpi: int, what: str) -> None:
    """Draw a figure and write it.

    Args:
        path: A ``.png``; written whole or not at all.
        figure: What to draw.
        dpi: Pixels per inch.
        what: What the picture shows, for messages.

    Raises:
        InvalidInput: Another suffix, or a place that cannot be written.
    """
    if Path(path).suffix.lower() != ".png":
        raise InvalidInput(f"{path}: {what} is drawn as .png; give a name that ends in .png")
    sink = io.BytesIO()
    figure.savefig(sink, format="png", dpi=dpi)
    write_picture(path, sink.getvalue())


def write_picture(path: str | Path, data: bytes) -> None:
    """Write a finished picture, or raise :class:`InvalidInput` in one line."""
    try:
        write_bytes_atomic(path, data)
    except OSError as error:
        raise InvalidInput(
            f"{path} cannot be written ({error.strerror}); choose another file"
        ) from None
