"""MovingAI grid benchmarks: a ``.map`` file, one character per cell.

    . G     free                        every mode
    @ O T   out of bounds or trees      blocked
    S       swamp                       crawl only (soft ground: four contacts)
    W       water                       biped only (wade upright, trunk dry)

The benchmarks leave the meaning of S and W to each user; the two rows above are ours.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mobius.errors import MapError, did_you_mean
from mobius.types import ALL_MODES_BITS, Mode
from mobius.world.keys import shown
from mobius.world.notes import Notes
from mobius.world.occupancy import OccupancyMap

TERRAIN: dict[str, tuple[int, int]] = {
    ".": (0, ALL_MODES_BITS),
    "G": (0, ALL_MODES_BITS),
    "@": (100, ALL_MODES_BITS),
    "O": (100, ALL_MODES_BITS),
    "T": (100, ALL_MODES_BITS),
    "S": (0, Mode.CRAWL.bit),
    "W": (0, Mode.BIPED.bit),
}
"""Character -> (occupancy [%], bit set of modes)."""

_MAX_CELLS = 100_000_000


def read_movingai(path: Path | str, *, cell: float = 0.5) -> tuple[OccupancyMap, Notes]:
    """Read a ``.map``: one pixel per character, ``cell`` metres wide, lower-left corner at 0.

    Raises:
        MapError: Any mistake in the file, in one line that names file, place and fix.
    """
    path = Path(path)
    lines = _lines(path)
    height, width, first = _header(path, lines)
    rows = lines[first : first + height]
    if len(rows) < height:
        raise MapError(
            f"{path}, line {len(lines)}: the file is truncated, expected {height} rows of cells,"
            f" got {len(rows)}; copy it again"
        )
    for extra, line in enumerate(lines[first + height :], first + height + 1):
        if line.strip():
            raise MapError(f"{path}, line {extra}: expected nothing after row {height}; correct it")
    occupancy = np.empty((height, width), np.int8)
    bits = np.empty((height, width), np.uint8)
    for i, row in enumerate(rows):
        place = f"{path}, line {first + i + 1}"
        if len(row) != width:
            raise MapError(f"{place}: expected {width} cells, got {len(row)}; complete the row")
        for j, char in enumerate(row):
            if char not in TERRAIN:
                raise MapError(
                    f"{place}, column {j + 1}: unknown cell {shown(char)}; use one of"
                    f" {' '.join(TERRAIN)}"
                )
        # the file's first row is the top
        occupancy[height - 1 - i] = [TERRAIN[c][0] for c in row]
        bits[height - 1 - i] = [TERRAIN[c][1] for c in row]
    raster = OccupancyMap(str(path), occupancy, cell, np.zeros(3), path=path)
    return raster, Notes(cell=cell, region_bits=bits)


def _lines(path: Path) -> list[str]:
    try:
        return path.read_bytes().decode("ascii").splitlines()
    except FileNotFoundError:
        near = [p.name for p in path.parent.glob("*.map")] if path.parent.is_dir() else []
        raise MapError(
            f"{path}: there is no such file.{did_you_mean(path.name, near)} Check the path"
        ) from None
    except OSError as e:
        raise MapError(f"{path}: cannot be read ({e.strerror}); check the path") from None
    except UnicodeDecodeError as e:
        raise MapError(
            f"{path}, byte {e.start}: expected a text file of . @ T S W; copy it again"
        ) from None


def _header(path: Path, lines: list[str]) -> tuple[int, int, int]:
    """Height, width and the index of the first row of cells."""
    if not lines or lines[0].split() != ["type", "octile"]:
        got = shown(lines[0]) if lines else "an empty file"
        raise MapError(f"{path}, line 1: expected 'type octile', got {got}; name a MovingAI .map")
    size: dict[str, int] = {}
    for i, line in enumerate(lines[1:4], 2):
        words = line.split()
        if words == ["map"]:
            break
        good = len(words) == 2 and words[0] in ("height", "width")
        if not (good and words[1].isdigit() and len(words[1]) < 9 and int(words[1]) > 0):
            raise MapError(
                f"{path}, line {i}: expected 'height N', 'width N' or 'map', got {shown(line)};"
                " correct the line"
            )
        size[words[0]] = int(words[1])
    for key in ("height", "width"):
        if key not in size:
            raise MapError(f"{path}, line 2: the {key} is missing; add '{key} N' above 'map'")
    if len(lines) < 4 or lines[3].split() != ["map"]:
        raise MapError(f"{path}, line 4: expected 'map'; the rows of cells follow it")
    if size["height"] * size["width"] > _MAX_CELLS:
        raise MapError(f"{path}, line 2: expected at most {_MAX_CELLS} cells; check the size")
    return size["height"], size["width"], 4
