"""Results as files: the figures as JSON, a CSV a table, a picture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from mobius.evaluate.motions import Series
from mobius.evaluate.push import Push
from mobius.evaluate.robustness import Robustness
from mobius.evaluate.tables import Outcome, as_csv, series_table, tables
from mobius.evaluate.terrain import Terrain
from mobius.files import write_json_atomic, write_text_atomic


def name_of(result: Outcome) -> str:
    """``tracking``, ``push``, ``terrain`` or ``robustness``."""
    return type(result).__name__.lower()


def write_outcome(folder: Path, result: Outcome, *, series: Sequence[Series] = ()) -> None:
    """Write ``NAME.json``, ``NAME_TABLE.csv`` and ``NAME.png`` of a result into a folder.

    Args:
        folder: Exists.
        result: Of one evaluation.
        series: Motions over time, for the picture of a tracking result.
    """
    from mobius.evaluate import figures

    name = name_of(result)
    write_json_atomic(folder / f"{name}.json", result.as_json())
    for table, rows in tables(result).items():
        write_text_atomic(folder / f"{name}_{table}.csv", as_csv(rows))
    picture = folder / f"{name}.png"
    if isinstance(result, Push):
        figures.draw_push(picture, result)
    elif isinstance(result, Terrain):
        figures.draw_terrain(picture, result)
    elif isinstance(result, Robustness):
        figures.draw_robustness(picture, result)
    elif series:
        write_text_atomic(folder / f"{name}_series.csv", as_csv(series_table(series)))
        figures.draw_tracking(picture, result.body, series)
