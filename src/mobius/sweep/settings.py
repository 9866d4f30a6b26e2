"""What a sweep goes through: every combination of a table of lists."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any

from mobius.errors import InvalidInput

__all__ = ["Row", "Setting", "product_of"]

Setting = dict[str, Any]
"""Name to value; plain JSON values only."""
Row = dict[str, Any]
"""What came out for a setting; plain JSON values only, the same names for every setting."""


def product_of(table: Mapping[str, Sequence[Any]]) -> list[Setting]:
    """Every combination, the last name running fastest.

    Args:
        table: Name to the values it takes, at least one each, none twice.
    """
    for name, values in table.items():
        if len(values) == 0:
            raise InvalidInput(f"{name}: an empty list; give at least one value")
        for k, value in enumerate(values):
            if value in values[:k]:
                raise InvalidInput(f"{name}: {value} is listed twice; remove one of them")
    return [dict(zip(table, values, strict=True)) for values in product(*table.values())]
