"""Nav2 maps: a ``map.yaml`` and its image, in and out, read as Nav2's map server reads them.

With brightness c in 0..1 and p = 1 - c (p = c when ``negate``):

    trinary   p > occupied_thresh: 100;  p < free_thresh: 0;  else -1
    scale     as trinary, but in between rint(100 (p - free) / (occupied - free)),
              and -1 where the pixel is not opaque
    raw       round(255 c) where that is 0..100, else -1; ``negate`` and thresholds unused

Both comparisons are strict. The brightness of a colour is the mean of its channels; in
trinary mode the alpha channel is one of them. The image's first row is the top of the map.
Note what follows for the grey 205 that map savers write for unknown (p = 0.196): it is
unknown under the ROS 1 ``free_thresh`` 0.196, and *free* under Nav2's default 0.25.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import numpy as np
import yaml
from numpy.typing import NDArray

from mobius.errors import InvalidInput
from mobius.files import write_text_atomic
from mobius.world.image import GreyImage, read_image, write_pgm
from mobius.world.keys import Section, read_yaml
from mobius.world.notes import Notes, apply_stamps, check_regions, parse_notes
from mobius.world.occupancy import UNKNOWN, OccupancyMap

MapMode = Literal["trinary", "scale", "raw"]
MODES: tuple[MapMode, ...] = ("trinary", "scale", "raw")
KEYS = (
    *("image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh"),
    *("mode", "mobius"),
)
_FREE, _OCCUPIED, _UNSEEN = 254, 0, 205
_WRITTEN_THRESHOLDS = {"occupied_thresh": 0.65, "free_thresh": 0.196}


def read_nav2(path: Path | str) -> tuple[OccupancyMap, Notes]:
    """Read a map and what its ``mobius:`` key says, stamps already drawn on the raster.

    Raises:
        MapError: Any mistake in either file, in one line that names file, place and fix.
    """
    path = Path(path)
    doc = read_yaml(path)
    doc.no_typos(KEYS)
    image = doc.text("image", example="map.pgm")
    resolution = doc.number("resolution", example="0.05", above=0.0, low=1e-3, high=10.0)
    origin = doc.numbers("origin", 3, example="[0.0, 0.0, 0.0]")
    negate = doc.flag("negate", example="0")
    mode = doc.choice("mode", MODES) if "mode" in doc else "trinary"
    thresholds = _thresholds(doc)
    notes = parse_notes(doc.section("mobius")) if "mobius" in doc else Notes()
    grey = read_image(path.parent / image)
    occupancy = interpret(grey, mode=mode, negate=negate, **thresholds)
    raster = OccupancyMap(
        str(path), occupancy, resolution, np.array(origin, dtype=float), path=path
    )
    raster = apply_stamps(raster, notes.stamps)
    check_regions(raster, notes)
    return raster, notes


def interpret(
    grey: GreyImage, *, mode: str, negate: bool, occupied_thresh: float, free_thresh: float
) -> NDArray[np.int8]:
    """Occupancy (h, w), row 0 at the *bottom*, of an image; the table above."""
    shade = grey.shade
    if mode == "raw":
        percent = np.floor(255.0 * shade + 0.5)
        out = np.where(percent <= 100, percent, UNKNOWN)
        return out[::-1].astype(np.int8)
    if mode == "trinary" and grey.alpha is not None:
        shade = (3.0 * shade + grey.alpha) / 4.0
    p = shade if negate else 1.0 - shade
    out = np.full(p.shape, float(UNKNOWN))
    if mode == "scale":
        out = np.rint((p - free_thresh) / (occupied_thresh - free_thresh) * 100.0)
    out = np.where(p < free_thresh, 0.0, out)
    out = np.where(p > occupied_thresh, 100.0, out)
    if mode == "scale" and grey.alpha is not None:
        out = np.where(grey.alpha < 1.0, UNKNOWN, out)
    return out[::-1].astype(np.int8)


def write_nav2(
    path: Path | str, raster: OccupancyMap, *, mobius: dict[str, Any] | None = None
) -> None:
    """Write ``path`` (a .yaml) and the .pgm beside it; reading them back gives the raster.

    Args:
        path: Where the yaml goes; the image gets the same stem.
        raster: Free, occupied and unknown pixels are written in trinary mode; a map with
            other percentages in raw mode.
        mobius: What to write below our own key, as plain Python values.

    Raises:
        InvalidInput: The path does not end in ``.yaml``.
    """
    path = Path(path)
    if path.suffix != ".yaml":
        raise InvalidInput(f"write_nav2: expected a path that ends in .yaml, got '{path}'")
    occupancy = raster.occupancy[::-1]
    if np.isin(occupancy, (UNKNOWN, 0, 100)).all():
        mode = "trinary"
        grey = np.select([occupancy == 0, occupancy == 100], [_FREE, _OCCUPIED], _UNSEEN)
    else:
        mode = "raw"
        grey = np.where(occupancy == UNKNOWN, 255, occupancy)
    image = path.with_suffix(".pgm")
    doc: dict[str, Any] = {
        "image": image.name,
        "mode": mode,
        "resolution": float(raster.resolution),
        "origin": [float(v) for v in raster.origin_M],
        "negate": 0,
        **_WRITTEN_THRESHOLDS,
    }
    if mobius is not None:
        doc["mobius"] = mobius
    text = yaml.safe_dump(doc, sort_keys=False, default_flow_style=None, width=100)
    write_pgm(image, grey.astype(np.uint8))
    write_text_atomic(path, text)


def _thresholds(doc: Section) -> dict[str, float]:
    occupied = doc.number("occupied_thresh", example="0.65", low=0.0, high=1.0)
    free = doc.number("free_thresh", example="0.25", low=0.0, high=1.0)
    if free >= occupied:
        raise doc.error(
            "free_thresh",
            f"expected less than occupied_thresh ({occupied:g}), got {free:g}; the usual pair is"
            " 'occupied_thresh: 0.65' and 'free_thresh: 0.25'",
        )
    return {"occupied_thresh": occupied, "free_thresh": free}
