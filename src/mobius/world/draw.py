"""Draws the maps that ship with the package: ``python -m mobius.world.draw``.

A map is the free floor of its rooms, a wall of one thickness around all of it, and
furniture on it; everything else is unknown, as a robot's own map would have it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy import ndimage

from mobius.world.nav2 import write_nav2
from mobius.world.occupancy import UNKNOWN, OccupancyMap

Box = tuple[float, float, float, float]
"""x0, y0, x1, y1 [m] from the lower-left corner of the canvas."""
Drawing = tuple[OccupancyMap, dict[str, Any]]

RESOLUTION = 0.05
"""[m] per pixel."""
WALL = 0.15
"""Thickness of walls [m]."""


def demo() -> Drawing:
    """Two rooms of about 3 m, a corridor 1.6 m wide, a rough patch and a raised shelf."""
    raster = rooms(
        "demo",
        size=(8.4, 4.4),
        floor=[(0.4, 0.4, 3.4, 4.0), (3.4, 1.4, 4.8, 3.0), (4.8, 0.4, 8.0, 4.0)],
        furniture=[(0.4, 3.3, 1.0, 4.0), (2.9, 3.5, 3.4, 4.0), (2.5, 0.4, 3.4, 0.7)],
    )
    notes = {
        "cell": 0.5,
        "start": [1.3, 1.2],
        "goal": [7.3, 3.2],
        "shapes": [
            {"type": "circle", "center": [5.8, 2.2], "radius": 0.7, "mode": "crawl"},
            {"type": "circle", "center": [7.3, 1.6], "radius": 0.4, "mode": "biped"},
        ],
        "rough": [{"center": [5.8, 2.2], "size": [1.2, 1.4], "amplitude": 0.02, "seed": 7}],
        "raised": [{"center": [7.2, 0.65], "size": [1.3, 0.4], "height": [0.4, 0.44]}],
    }
    return raster, notes


def arena() -> Drawing:
    """One room of 4 x 3 m with a pillar in the middle; the origin is the pillar's centre."""
    raster = rooms(
        "arena",
        size=(4.6, 3.6),
        floor=[(0.3, 0.3, 4.3, 3.3)],
        furniture=[(2.1, 1.6, 2.5, 2.0)],
        origin=(-2.3, -1.8),
    )
    return raster, {"cell": 0.5, "start": [-1.25, -0.75], "goal": [1.25, 0.75]}


def multimodal() -> Drawing:
    """10 x 10 m that take every body: a rough passage, one past a shelf, one to roll through.

    Two walls make three aisles, joined by a rough passage that only crawling takes and one
    past a raised shelf that only walking takes; before the goal lies a strip to roll over.
    """
    raster = rooms(
        "multimodal",
        size=(10.6, 10.6),
        floor=[(0.3, 0.3, 10.3, 10.3)],
        furniture=[
            (3.4, 0.3, 3.6, 6.9),
            (3.4, 9.3, 3.6, 10.3),
            (6.9, 3.7, 7.1, 10.3),
            (6.9, 0.3, 7.1, 1.3),
            (1.4, 4.3, 2.0, 4.9),
            (4.6, 6.0, 5.4, 6.5),
            (9.3, 4.6, 10.3, 5.0),
        ],
        origin=(-0.3, -0.3),
    )
    notes = {
        "cell": 0.5,
        "start": [1.25, 1.25],
        "goal": [8.75, 9.25],
        "shapes": [
            _oblong((3.2, 7.8), (1.8, 2.6), "crawl"),
            _oblong((6.7, 2.2), (1.8, 2.6), "biped"),
            _oblong((8.4, 6.5), (3.2, 0.9), "roll"),
        ],
        "rough": [{"center": [3.2, 7.8], "size": [1.6, 2.4], "amplitude": 0.02, "seed": 11}],
        "raised": [{"center": [5.2, 0.35], "size": [1.4, 0.5], "height": [0.5, 0.54]}],
    }
    return raster, notes


def _oblong(center: tuple[float, float], size: tuple[float, float], mode: str) -> dict[str, Any]:
    """A rectangular region that forces one mode."""
    return {"type": "rectangle", "center": list(center), "size": list(size), "mode": mode}


DRAWINGS: dict[str, Callable[[], Drawing]] = {
    "arena": arena,
    "demo": demo,
    "multimodal": multimodal,
}
"""Every shipped map by name."""


def rooms(
    name: str,
    *,
    size: tuple[float, float],
    floor: Sequence[Box],
    furniture: Sequence[Box] = (),
    origin: tuple[float, float] = (0.0, 0.0),
) -> OccupancyMap:
    """Free floor, a wall around it, furniture on it, unknown elsewhere.

    Args:
        name: Of the map.
        size: Canvas, x and y [m].
        floor: Free rectangles; they join where they touch.
        furniture: Occupied rectangles.
        origin: Of the canvas' lower-left corner, frame M [m].
    """
    shape = (round(size[1] / RESOLUTION), round(size[0] / RESOLUTION))
    free = np.zeros(shape, dtype=bool)
    for box in floor:
        free[_pixels(box)] = True
    occupancy = np.full(shape, UNKNOWN, np.int8)
    reach = 2 * round(WALL / RESOLUTION) + 1
    occupancy[ndimage.maximum_filter(free, reach, mode="constant")] = 100
    occupancy[free] = 0
    for box in furniture:
        occupancy[_pixels(box)] = 100
    return OccupancyMap(name, occupancy, RESOLUTION, np.array([*origin, 0.0]))


def write_all(folder: Path) -> None:
    """Write every shipped map into a folder."""
    for name, drawing in DRAWINGS.items():
        raster, notes = drawing()
        write_nav2(folder / f"{name}.yaml", raster, mobius=notes)


def _pixels(box: Box) -> tuple[slice, slice]:
    x0, y0, x1, y1 = (round(v / RESOLUTION) for v in box)
    return slice(y0, y1), slice(x0, x1)


if __name__ == "__main__":
    write_all(Path(__file__).parent / "maps")
