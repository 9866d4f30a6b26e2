"""What our own key ``mobius:`` in a map.yaml says; Nav2 skips it.

mobius:
  cell: 0.5                 # edge of a planner cell [m]
  start: [1.0, 1.0]         # [m], frame map
  goal: [7.0, 3.0]
  shapes:                   # Nav2 vector objects, with our key `mode` or Nav2's `value`
    - {type: circle, center: [3.0, 2.0], radius: 1.0, mode: crawl}
    - {type: polygon, points: [0, 0, 1, 0, 1, 1], mode: [crawl, biped]}
    - {type: rectangle, center: [5, 5], size: [1, 2], yaw: 0.3, value: 100}
  regions: regions.png      # second image of the same size: grey value -> mode
  legend: {1: crawl, 2: biped}
  rough:                    # bumps
    - {center: [5, 2], size: [1.5, 1.0], amplitude: 0.02, wavelength: 0.3, seed: 3}
  raised:                   # tables, shelves, blocks
    - {center: [7, 0.5], size: [1.2, 0.4], height: [0.40, 0.44], leg: 0.04}
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mobius.errors import MapError
from mobius.types import ALL_MODES_BITS, Mode
from mobius.world.image import read_image
from mobius.world.keys import Section
from mobius.world.occupancy import OccupancyMap
from mobius.world.shapes import (
    Circle,
    Geometry,
    Point,
    Polygon,
    RaisedObject,
    Rectangle,
    Region,
    RoughPatch,
    Stamp,
)

KEYS = ("cell", "start", "goal", "shapes", "regions", "legend", "rough", "raised")
MODE_NAMES = (Mode.CRAWL.value, Mode.BIPED.value, Mode.ROLL.value)
_SHAPE_KEYS = (
    *("type", "frame_id", "uuid", "name", "center", "radius", "points", "size", "yaw"),
    *("closed", "fill", "value", "mode"),
)
_NEEDED = {"circle": ("center", "radius"), "polygon": ("points",), "rectangle": ("center", "size")}


@dataclass(frozen=True, eq=False)
class Notes:
    """What a map says beyond its pixels."""

    cell: float | None = None
    """Edge of a planner cell [m], if the map names one."""
    start: Point | None = None
    """[m], frame M."""
    goal: Point | None = None
    """[m], frame M."""
    regions: tuple[Region, ...] = ()
    stamps: tuple[Stamp, ...] = ()
    region_bits: NDArray[np.uint8] | None = None
    """(h, w) modes admitted by the region image per pixel, row 0 at the bottom; None without."""
    rough: tuple[RoughPatch, ...] = ()
    raised: tuple[RaisedObject, ...] = ()


def parse_notes(section: Section) -> Notes:
    """Read the mapping below ``mobius:``.

    Raises:
        MapError: A key is unknown, missing or out of range; names file, line and key.
    """
    section.only(KEYS)
    cell = section.number("cell", example="0.5", above=0.0) if "cell" in section else None
    points = {key: _point(section, key) if key in section else None for key in ("start", "goal")}
    regions: list[Region] = []
    stamps: list[Stamp] = []
    for item in section.sections("shapes"):
        shape = _shape(item)
        if isinstance(shape, Region):
            regions.append(shape)
        else:
            stamps.append(shape)
    return Notes(
        cell=cell,
        start=points["start"],
        goal=points["goal"],
        regions=tuple(regions),
        stamps=tuple(stamps),
        region_bits=_region_image(section),
        rough=tuple(_rough(item) for item in section.sections("rough")),
        raised=tuple(_raised(item) for item in section.sections("raised")),
    )


def apply_stamps(raster: OccupancyMap, stamps: tuple[Stamp, ...]) -> OccupancyMap:
    """The map with every stamp's value written on the pixels whose centre it holds."""
    if not stamps:
        return raster
    occupancy, centers = raster.occupancy.copy(), raster.pixel_centers()
    for stamp in stamps:
        inside = stamp.geometry.contains(centers)
        if not inside.any():
            raise _misses(raster, stamp.place)
        occupancy[inside] = stamp.value
    return OccupancyMap(
        raster.name, occupancy, raster.resolution, raster.origin_M, path=raster.path
    )


def check_regions(raster: OccupancyMap, notes: Notes) -> None:
    """Raise when a region misses the map, or two that admit different modes overlap."""
    if notes.region_bits is not None and notes.region_bits.shape != raster.shape:
        h, w = notes.region_bits.shape
        raise MapError(
            f"{raster.name}, key 'mobius.regions': expected an image of {raster.shape[1]} x"
            f" {raster.shape[0]} pixels like the map's, got {w} x {h}; draw it on a copy of the map"
        )
    if not notes.regions:
        return
    centers = raster.pixel_centers()
    bits = np.full(raster.shape, ALL_MODES_BITS, np.uint8)
    owner = np.full(raster.shape, -1)
    if notes.region_bits is not None:
        bits = notes.region_bits.copy()
    for k, region in enumerate(notes.regions):
        inside = region.geometry.contains(centers)
        if not inside.any():
            raise _misses(raster, region.place)
        clash = inside & (bits != ALL_MODES_BITS) & (bits != region.bits)
        if clash.any():
            row, col = np.argwhere(clash)[0]
            other = owner[row, col]
            what = notes.regions[other].place.split(", ", 1)[-1] if other >= 0 else "the image"
            x, y = centers[row, col]
            raise MapError(
                f"{region.place}: admits {_names(region.bits)} but overlaps {what}, which admits"
                f" {_names(int(bits[row, col]))}, at ({x:.2f}, {y:.2f}) m; move or shrink one"
            )
        bits[inside], owner[inside] = region.bits, k


def _names(bits: int) -> str:
    return "+".join(name for name in MODE_NAMES if bits & Mode(name).bit)


def _misses(raster: OccupancyMap, place: str) -> MapError:
    w, h = raster.size
    x, y = raster.origin_M[:2]
    return MapError(
        f"{place}: covers no pixel of the map, whose lower-left corner is ({x:.2f}, {y:.2f}) m and"
        f" whose size is {w:.2f} x {h:.2f} m; give metres in frame map"
    )


def _point(section: Section, key: str) -> Point:
    x, y = section.numbers(key, 2, example="[1.0, 2.0]")
    return x, y


def _size(section: Section) -> Point:
    x, y = section.numbers("size", 2, example="[1.0, 0.5]")
    if min(x, y) <= 0:
        raise section.error("size", f"expected two lengths > 0 [m], got [{x:g}, {y:g}]")
    return x, y


def _rectangle(section: Section) -> Rectangle:
    yaw = section.number("yaw", example="0.0") if "yaw" in section else 0.0
    return Rectangle(_point(section, "center"), _size(section), yaw)


def _geometry(section: Section, kind: str) -> Geometry:
    if kind == "circle":
        radius = section.number("radius", example="1.0", above=0.0)
        return Circle(_point(section, "center"), radius)
    if kind == "rectangle":
        return _rectangle(section)
    flat = section.numbers("points", None, example="[0, 0, 1, 0, 1, 1]")
    polygon = Polygon(tuple(zip(flat[::2], flat[1::2], strict=True)))
    if len(polygon.points) < 3 or abs(polygon.area) < 1e-9:
        raise section.error(
            "points", "expected at least 3 corners around some area, such as [0, 0, 1, 0, 1, 1]"
        )
    return polygon


def _shape(section: Section) -> Region | Stamp:
    section.only(_SHAPE_KEYS)
    kind = section.choice("type", tuple(_NEEDED))
    for key in ("center", "radius", "points", "size", "yaw"):
        if key in section and key not in (*_NEEDED[kind], *(("yaw",) * (kind == "rectangle"))):
            raise section.error(
                key, f"a {kind} has none; it is given by {' and '.join(_NEEDED[kind])}"
            )
    if "frame_id" in section:
        section.choice("frame_id", ("map",))
    for key in ("closed", "fill"):
        if key in section and not section.flag(key, example="true"):
            raise section.error(key, "outlines are not supported; write 'true' or leave it out")
    geometry = _geometry(section, kind)
    place = f"{section.file}, line {section.line}, key '{section.path.rstrip('.')}'"
    if ("mode" in section) == ("value" in section):
        raise section.error(
            "mode" if "mode" in section else "type",
            "expected either 'mode: crawl' (a region) or 'value: 100' (an obstacle), not"
            f" {'both' if 'mode' in section else 'neither'}",
        )
    if "value" in section:
        value = section.integer("value", example="100", low=-1, high=100)
        return Stamp(geometry, value, place)
    return Region(geometry, tuple(Mode(m) for m in section.words("mode", MODE_NAMES)), place)


def _rough(section: Section) -> RoughPatch:
    section.only(("center", "size", "yaw", "amplitude", "wavelength", "seed"))
    kwargs: dict[str, float] = {}
    if "amplitude" in section:
        kwargs["amplitude"] = section.number("amplitude", example="0.03", above=0.0, high=0.2)
    if "wavelength" in section:
        kwargs["wavelength"] = section.number("wavelength", example="0.3", low=0.05, high=5.0)
    seed = section.integer("seed", example="0", low=0, high=2**31 - 1) if "seed" in section else 0
    return RoughPatch(_rectangle(section), seed=seed, **kwargs)


def _raised(section: Section) -> RaisedObject:
    section.only(("center", "size", "yaw", "height", "leg"))
    bottom, top = section.numbers("height", 2, example="[0.40, 0.44]")
    if not 0 <= bottom < top:
        raise section.error(
            "height",
            f"expected [underside, top] in metres with 0 <= underside < top, got"
            f" [{bottom:g}, {top:g}]",
        )
    area = _rectangle(section)
    leg = 0.04
    if "leg" in section:
        leg = section.number("leg", example="0.04", low=0.0, high=min(area.size) / 2)
    return RaisedObject(area, bottom, top, leg)


def _region_image(section: Section) -> NDArray[np.uint8] | None:
    if "regions" not in section:
        if "legend" in section:
            raise section.error("legend", "has no image; add 'regions: regions.png' beside it")
        return None
    path = Path(section.file).parent / section.text("regions", example="regions.png")
    legend = section.section("legend") if "legend" in section else None
    if legend is None:
        raise section.error("regions", "has no legend; add 'legend: {1: crawl, 2: biped}'")
    levels = read_image(path).levels
    if levels is None:
        raise MapError(f"{path}: expected a grey or palette image, got colours; save it as 8-bit")
    table = {0: ALL_MODES_BITS}
    for key in legend:
        if not (key.isascii() and key.isdigit() and 0 < int(key[:6]) < 65536):
            raise legend.error(key, "expected a grey value from 1 on, e.g. '1: crawl'")
        table[int(key)] = sum(Mode(m).bit for m in legend.words(key, MODE_NAMES))
    bits = np.zeros(levels.shape, np.uint8)
    for level, value in table.items():
        bits[levels == level] = value
    if (bits == 0).any():
        row, col = np.argwhere(bits == 0)[0]
        raise MapError(
            f"{path}, pixel column {col}, row {row} from the top: grey {levels[row, col]} is not in"
            f" the legend ({', '.join(map(str, sorted(table)))}); add it or repaint the pixel"
        )
    return bits[::-1].copy()
