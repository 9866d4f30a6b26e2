"""Regions drawn over a map that is not ours to change: ``mobius run --regions FILE.yaml``.

shapes:                   # as below ``mobius:`` in a map.yaml
  - {type: rectangle, center: [12, 6], size: [2, 3], mode: crawl}
  - {type: circle, center: [20, 8], radius: 1.5, mode: biped}
rough:                    # bumps, where the ground shall really be rough
  - {center: [12, 6], size: [1.6, 2.6], amplitude: 0.02}
raised: []                # tables and shelves
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from mobius.errors import MapError
from mobius.world.keys import read_yaml
from mobius.world.notes import Notes, apply_stamps, check_regions, parse_notes
from mobius.world.occupancy import OccupancyMap

KEYS = ("shapes", "rough", "raised")


def read_regions(path: str | Path) -> Notes:
    """What a file of regions says.

    Raises:
        MapError: A mistake in the file: names file, line, key and fix.
    """
    path = Path(path)
    section = read_yaml(path, what="a file of regions", first="shapes:")
    section.only(KEYS)
    notes = parse_notes(section)
    if not (notes.regions or notes.stamps or notes.rough or notes.raised):
        raise MapError(
            f"{path}: holds no region; add e.g."
            " 'shapes: [{type: circle, center: [2, 3], radius: 1, mode: biped}]'"
        )
    return notes


def add_regions(raster: OccupancyMap, notes: Notes, path: str | Path) -> tuple[OccupancyMap, Notes]:
    """A map and its notes with those of a file of regions on top.

    Raises:
        MapError: A mistake in the file; a region misses the map, or two that admit different
            modes overlap.
    """
    more = read_regions(path)
    raster = apply_stamps(raster, more.stamps)
    notes = replace(
        notes,
        regions=notes.regions + more.regions,
        stamps=notes.stamps + more.stamps,
        rough=notes.rough + more.rough,
        raised=notes.raised + more.raised,
    )
    check_regions(raster, notes)
    return raster, notes
