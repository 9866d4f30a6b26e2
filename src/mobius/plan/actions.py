"""What one planner step can be: (8)-(10) of Table IV as a finite list of actions.

Lengths: biped exactly 1 cell, crawl 1 or 2, roll exactly 3. The table leaves open how the
two axes share a step, hence the argument ``connectivity``:

- ``axis``: one axis at a time (the project's default);
- ``diagonal``: both axes move in every step, which is what the table says word for word;
- ``box``: each axis moves by one of the mode's lengths or rests, not both resting.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from itertools import pairwise, product
from typing import Literal

from mobius import paper
from mobius.types import Mode

__all__ = ["STEP_LENGTHS", "Action", "Connectivity", "actions_for", "line_between"]

Connectivity = Literal["axis", "box", "diagonal"]
Offset = tuple[int, int]

PLANNABLE = (Mode.BIPED, Mode.CRAWL, Mode.ROLL)
"""Modes of Table IV."""

STEP_LENGTHS: dict[Mode, tuple[int, ...]] = {
    mode: tuple(d for d in paper.STEPS[mode] if d > 0) for mode in PLANNABLE
}
"""Cells per step and axis, Table IV (8)-(10)."""

STAYING_MODES = (Mode.BIPED, Mode.CRAWL)
"""Modes that can rest on a cell (a roll cannot be stopped)."""


@dataclass(frozen=True)
class Action:
    """One way to leave a cell. Offsets are cells relative to the departure."""

    mode: Mode
    d: Offset
    """Landing cell."""
    crossed: tuple[Offset, ...]
    """Cells strictly between whose inside the straight line between centres crosses."""
    touched: tuple[Offset, ...]
    """Cells the line touches in a corner only (diagonal steps)."""


@cache
def actions_for(
    modes: tuple[Mode, ...], connectivity: Connectivity, *, allow_stay: bool = False
) -> tuple[Action, ...]:
    """Every action of the given modes, in a fixed order.

    Args:
        modes: Modes the robot may use.
        connectivity: How the axes share a step, see the module's docstring.
        allow_stay: Also let biped and crawl rest on their cell for a step.
    """
    actions = []
    for mode in modes:
        for d in _steps(STEP_LENGTHS[mode], connectivity):
            actions.append(Action(mode, d, *line_between(d)))
        if allow_stay and mode in STAYING_MODES:
            actions.append(Action(mode, (0, 0), (), ()))
    return tuple(actions)


def _steps(lengths: tuple[int, ...], connectivity: Connectivity) -> list[Offset]:
    """Landing offsets, long steps first, then +x, +y, -x, -y."""
    signed = [s * n for n in lengths for s in (1, -1)]
    if connectivity == "axis":
        steps = [(n, 0) for n in signed] + [(0, n) for n in signed]
    elif connectivity == "diagonal":
        steps = list(product(signed, signed))
    else:
        steps = [d for d in product([0, *signed], [0, *signed]) if d != (0, 0)]
    return sorted(steps, key=lambda d: (-max(abs(d[0]), abs(d[1])), -d[0], -d[1]))


def line_between(d: Offset) -> tuple[tuple[Offset, ...], tuple[Offset, ...]]:
    """Cells crossed and cells touched in a corner by the segment from (0, 0) to d.

    The segment leaves a column of cells at the parameters (2 m + 1) / (2 |dx|) and a row at
    (2 m + 1) / (2 |dy|). Between two such parameters it is inside one cell; where a column
    and a row are left at once, it runs through a corner, and the two cells beside it follow
    one another in the second list.
    """
    dx, dy = d
    columns = {Fraction(2 * m + 1, 2 * abs(dx)) for m in range(abs(dx))}
    rows = {Fraction(2 * m + 1, 2 * abs(dy)) for m in range(abs(dy))}
    cuts = sorted(columns | rows)
    middles = [(a + b) / 2 for a, b in pairwise(cuts)]
    crossed = tuple((round(s * dx), round(s * dy)) for s in middles)
    touched: list[Offset] = []
    sx, sy = (dx > 0) - (dx < 0), (dy > 0) - (dy < 0)
    for s in sorted(columns & rows):
        before = (int(s * abs(dx)) * sx, int(s * abs(dy)) * sy)
        touched += [(before[0] + sx, before[1]), (before[0], before[1] + sy)]
    return crossed, tuple(touched)
