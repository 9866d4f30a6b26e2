"""Fig. 18: slices of the admissible set, exact and sampled, with a trajectory in it.

``python -m mobius.reproduce.fig_18 [--out FILE.png]``. The paper prints neither gains nor
limits; these are ours.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from mobius.control.governor import AXES, AdmissibleSet, Axis, algorithm_3, axis_set
from mobius.control.governor.nearest import Nearest
from mobius.errors import MobiusError
from mobius.reproduce.common import as_text, write_out
from mobius.reproduce.moas import bare, sampled_contains, states_of, volumes
from mobius.view.png import save_png

__all__ = ["draw"]

Array = NDArray[np.float64]

_EXACT, _SAMPLED, _WRONG, _PATH = "#2a7fd4", "#d9772b", "#c0392b", "#1d2126"
PIXELS = 161


def draw(path: Path, axis: Axis, rows: AdmissibleSet) -> None:
    """Draw three slices through zero: (x, v), (x, x_ref), (v, x_ref); and a trajectory.

    Args:
        path: A ``.png``.
        axis: Limits.
        rows: Its exact set.
    """
    from mobius.reproduce.fig_19 import experiment

    governed = experiment(axis, rows)["exact"]
    sampled, bare_rows = Nearest(algorithm_3(bare(axis), repaired=True)), axis_set(bare(axis))
    figure = Figure(figsize=(13.0, 4.3), layout="constrained")
    names = ("x [m]", "v [m/s]", "x_ref [m]")
    along = (governed.x_s, governed.v, governed.x_ref)
    for at, (a, b) in zip(figure.subplots(1, 3), ((0, 1), (0, 2), (1, 2)), strict=True):
        _slice(at, axis, rows, bare_rows, sampled, (a, b))
        at.plot(along[a], along[b], color=_PATH, lw=0.9, label="trajectory of Fig. 19")
        at.plot(along[a][0], along[b][0], "o", color=_WRONG, ms=5, label="its start")
        at.plot(along[a][-1], along[b][-1], "o", color="#8a8f98", ms=5, label="its end")
        at.set_xlabel(names[a])
        at.set_ylabel(names[b])
    figure.axes[0].legend(fontsize=7, loc="upper right")
    figure.suptitle(
        "Under Algorithm 3's assumptions: light blue exact, orange sampled (repaired), red sampled"
        " but unsafe.\nDark blue: exact with servo lag, contact and outside force. Slices through"
        " zero, trajectory projected",
        fontsize=10,
    )
    save_png(path, figure, dpi=110, what="Fig. 18")


def _slice(
    at: Axes, axis: Axis, rows: AdmissibleSet, bare_rows: AdmissibleSet, sampled: Nearest,
    which: tuple[int, int],
) -> None:  # fmt: skip
    """Which points of a plane each set admits; the third coordinate is zero."""
    reach = np.array([axis.position_max, axis.velocity_max, axis.position_max])
    side = np.linspace(-1.1, 1.1, PIXELS)
    first, second = np.meshgrid(side, side)
    o = np.zeros((first.size, 5))
    o[:, which[0]], o[:, which[1]] = first.ravel(), second.ravel()
    o[:, :3] *= reach
    exact = rows.contains(*states_of(o))
    plain = bare_rows.contains(*states_of(o))
    near = sampled_contains(sampled, o)
    a, b = side * reach[which[0]], side * reach[which[1]]
    shape = first.shape
    for which_set, colour, alpha in (
        (plain, _EXACT, 0.25), (near, _SAMPLED, 0.45), (near & ~plain, _WRONG, 0.7),
        (exact, _EXACT, 0.6),
    ):  # fmt: skip
        if which_set.any():
            at.contourf(a, b, which_set.reshape(shape), [0.5, 1.5], colors=[colour], alpha=alpha)
    for limit in (-1, 1):
        at.axvline(limit * reach[which[0]], color="#8a8f98", ls="--", lw=0.8)
        at.axhline(limit * reach[which[1]], color="#8a8f98", ls="--", lw=0.8)


def main() -> None:
    """Draw, and print the volumes."""
    parser = argparse.ArgumentParser(
        prog="python -m mobius.reproduce.fig_18", description="Fig. 18"
    )
    parser.add_argument("--out", type=Path, default=Path("fig_18.png"), help="the .png to write")
    options = parser.parse_args()
    try:
        axis = AXES[0]
        rows = axis_set(axis)
        shares = volumes(axis, rows, 20_000)
    except MobiusError as error:
        sys.exit(f"fig_18: {error}")
    print(as_text([{"axis": axis.name, "rows": rows.sizes[0], **shares}]))
    write_out("fig_18", lambda: draw(options.out, axis, rows), options.out)


if __name__ == "__main__":
    main()
