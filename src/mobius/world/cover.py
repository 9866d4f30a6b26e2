"""Few boxes for many pixels: occupied pixels covered by disjoint rectangles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

Mask = NDArray[np.bool_]
Boxes = NDArray[np.int64]


def cover(must: Mask, may: Mask | None = None) -> Boxes:
    """Rectangles that hold every ``must`` pixel and no pixel outside ``must | may``.

    Greedy: of all straight runs of admitted pixels, along rows and along columns, take the
    one with the most pixels still to cover, trim it to them, widen it as far as whole
    lines are admitted, repeat. Without ``may`` the cover is exact.

    Args:
        must: (h, w) pixels to cover.
        may: (h, w) pixels that may be covered too, where that saves rectangles.

    Returns:
        (n, 4) half-open ``row0, col0, row1, col1``, disjoint, in the order taken.
    """
    todo = must.copy()
    admitted = must.copy() if may is None else must | may
    rows = np.array([_best_run(a, t) for a, t in zip(admitted, todo, strict=True)])
    cols = np.array([_best_run(a, t) for a, t in zip(admitted.T, todo.T, strict=True)])
    boxes = []
    while True:
        r, c = int(rows[:, 0].argmax()), int(cols[:, 0].argmax())
        if rows[r, 0] == 0:
            break
        if rows[r, 0] >= cols[c, 0]:
            c0, c1 = rows[r, 1:]
            r0, r1 = _widen(admitted, todo, r, c0, c1)
        else:
            r0, r1 = cols[c, 1:]
            c0, c1 = _widen(admitted.T, todo.T, c, r0, r1)
        todo[r0:r1, c0:c1] = False
        admitted[r0:r1, c0:c1] = False
        boxes.append((r0, c0, r1, c1))
        for k in range(r0, r1):
            rows[k] = _best_run(admitted[k], todo[k])
        for k in range(c0, c1):
            cols[k] = _best_run(admitted[:, k], todo[:, k])
    return np.array(boxes, dtype=np.int64).reshape(-1, 4)


def worth_building(
    occupied: Mask, inside: Mask, *, probe: float, near: float, fill: float
) -> tuple[Mask, Mask]:
    """Split a map into pixels a scene must show as wall and those it may fill up.

    A laser map's racks are shells of speckle around pixels nobody has seen; as exact boxes
    they would be a thousand, most of them where nothing can touch them. So let a disc of
    radius ``probe`` roll over the floor from where the robot can be; what it sweeps is
    *reached*. There the scene is exact. Boxes may run through what is hidden from it:
    cavities, and a seam along every obstacle.

    Args:
        occupied: (h, w) obstacles.
        inside: (h, w) pixels on which the robot's centre can be.
        probe: Radius of the disc [px].
        near: Occupied pixels farther than this from what is reached are dropped [px].
        fill: Boxes may run through hidden pixels up to this far from an obstacle [px].

    Returns:
        ``must`` and ``may`` of :func:`cover`; neither holds a reached pixel.
    """
    room = _distance(~occupied)
    parts, _ = ndimage.label(room >= probe)
    wanted = np.unique(parts[inside & (parts > 0)])
    if not wanted.size:
        sizes = np.bincount(parts.ravel())
        sizes[0] = 0
        wanted = np.array([sizes.argmax()])
    rolled = np.isin(parts, wanted) & (parts > 0)
    reached = (_distance(~rolled) <= probe) & ~occupied
    must = occupied & (_distance(~reached) <= near)
    hidden = ~reached & ~occupied
    may = occupied | (hidden & ((room <= fill) | _cavities(hidden)))
    return must, may


def _cavities(hidden: Mask) -> Mask:
    """The connected parts of a mask that do not touch the edge of the map."""
    parts, _ = ndimage.label(hidden)
    rim = np.concatenate([parts[0], parts[-1], parts[:, 0], parts[:, -1]])
    return hidden & ~np.isin(parts, np.unique(rim))


def _distance(mask: Mask) -> NDArray[np.float64]:
    """Distance [px] of every True pixel to the nearest False one; infinite if there is none."""
    if mask.all():
        return np.full(mask.shape, np.inf)
    return np.asarray(ndimage.distance_transform_edt(mask))


def _best_run(admitted: Mask, todo: Mask) -> tuple[int, int, int]:
    """Pixels to cover in the best run of one line, and where they begin and end."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], admitted.view(np.int8), [0]))))
    if not edges.size:
        return 0, 0, 0
    first, last = edges[::2], edges[1::2]
    counted = np.concatenate(([0], np.cumsum(todo)))
    gain = counted[last] - counted[first]
    k = int(gain.argmax())
    if gain[k] == 0:
        return 0, 0, 0
    at = np.flatnonzero(todo[first[k] : last[k]]) + first[k]
    return int(gain[k]), int(at[0]), int(at[-1]) + 1


def _widen(admitted: Mask, todo: Mask, row: int, c0: int, c1: int) -> tuple[int, int]:
    """Rows around ``row`` in which columns c0..c1 are admitted, trimmed to useful ones."""
    bounds = []
    for step, end in ((-1, -1), (1, len(admitted))):
        useful = k = row
        while k + step != end and admitted[k + step, c0:c1].all():
            k += step
            if todo[k, c0:c1].any():
                useful = k
        bounds.append(useful)
    return bounds[0], bounds[1] + 1
