"""Grey images of maps: PGM (P5, P2) by hand, so that errors can name the pixel; PNG by pillow."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from mobius.errors import MapError, did_you_mean
from mobius.files import write_bytes_atomic

Array = NDArray[np.float64]

_MAX_PIXELS = 100_000_000
_SPACE = b" \t\n\r\v\f"


@dataclass(frozen=True, eq=False)
class GreyImage:
    """An image as stored: row 0 is the *top*."""

    shade: Array
    """(h, w) brightness, mean of the colour channels, 0 black .. 1 white."""
    alpha: Array | None
    """(h, w) opacity, 0 transparent .. 1 opaque, or None without an alpha channel."""
    levels: NDArray[np.int64] | None
    """(h, w) stored numbers (grey value or palette index), or None for a colour image."""


def read_image(path: Path) -> GreyImage:
    """Read a PGM, PNG or BMP file.

    Raises:
        MapError: The file is missing, of another kind, truncated or damaged.
    """
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        near = [p.name for p in path.parent.iterdir()] if path.parent.is_dir() else []
        raise MapError(
            f"{path}: the image is missing.{did_you_mean(path.name, near)}"
            " Put it there, or correct 'image:' in the yaml"
        ) from None
    except (OSError, ValueError) as e:
        raise MapError(f"{path}: the image cannot be read ({e}); check the path") from None
    if data[:2] in (b"P5", b"P2"):
        return _read_pgm(path, data)
    if data[:8] == b"\x89PNG\r\n\x1a\n" or data[:2] == b"BM":
        return _read_with_pillow(path)
    raise MapError(
        f"{path}, byte 0: expected a PGM (P5 or P2), PNG or BMP image, got"
        f" {repr(data[:4])[1:] if data else 'an empty file'}; export the map as pgm or png"
    )


def write_pgm(path: Path, grey: NDArray[np.uint8]) -> None:
    """Write a binary PGM of grey values (h, w), row 0 on top; whole or not at all."""
    h, w = grey.shape
    write_bytes_atomic(path, b"P5\n%d %d\n255\n" % (w, h) + np.ascontiguousarray(grey).tobytes())


def _read_pgm(path: Path, data: bytes) -> GreyImage:
    tokens = _tokens(data, 2)
    header = []
    end = 2
    for what in ("width", "height", "maximum value"):
        token, end = next(tokens, (b"", len(data)))
        if not token.isdigit() or len(token) > 9:
            raise MapError(
                f"{path}, byte {end - len(token)}: expected the image's {what}, got"
                f" {repr(token[:8])[1:]}; the header must read e.g. 'P5 604 307 255'"
            )
        header.append(int(token))
    width, height, top = header
    if not (0 < width * height <= _MAX_PIXELS and 0 < top < 65536):
        raise MapError(
            f"{path}: expected 1 to {_MAX_PIXELS} pixels and a maximum value of 1 to 65535 in the"
            f" header, got {width} x {height} and {top}; export the map again"
        )
    if data[:2] == b"P5":
        levels = _binary_levels(path, data[end + 1 :], (height, width), 2 if top > 255 else 1)
    else:
        levels = _text_levels(path, [t for t, _ in tokens], (height, width))
    if levels.max() > top:
        row, col = np.argwhere(levels > top)[0]
        raise MapError(
            f"{path}, pixel column {col}, row {row} from the top: value {levels[row, col]} is above"
            f" the header's maximum {top}; export the map again"
        )
    return GreyImage(shade=levels / top, alpha=None, levels=levels)


def _tokens(data: bytes, start: int) -> Iterator[tuple[bytes, int]]:
    """Words of a PGM from a byte on, without '#' comments, and the byte after each."""
    i = start
    while i < len(data):
        if data[i] == ord("#"):
            line_end = data.find(b"\n", i)
            i = len(data) if line_end < 0 else line_end + 1
        elif data[i] in _SPACE:
            i += 1
        else:
            j = i
            while j < len(data) and data[j] not in _SPACE and data[j : j + 1] != b"#":
                j += 1
            yield data[i:j], j
            i = j


def _binary_levels(
    path: Path, body: bytes, shape: tuple[int, int], width: int
) -> NDArray[np.int64]:
    want = shape[0] * shape[1] * width
    if len(body) < want:
        raise _truncated(path, len(body) // width, shape)
    if body[want:].strip(_SPACE):
        raise MapError(
            f"{path}, byte {len(body) - want} from the end: expected the image to end here, got"
            f" more data than {shape[1]} x {shape[0]} pixels; export the map again"
        )
    kind = np.dtype(">u2") if width == 2 else np.dtype("u1")
    return np.frombuffer(body[:want], kind).reshape(shape).astype(np.int64)


def _text_levels(path: Path, words: list[bytes], shape: tuple[int, int]) -> NDArray[np.int64]:
    want = shape[0] * shape[1]
    for i, word in enumerate(words[: want + 1]):
        if i == want or not word.isdigit() or len(word) > 9:
            row, col = divmod(i, shape[1])
            place = f"pixel column {col}, row {row} from the top" if i < want else "after the image"
            raise MapError(
                f"{path}, {place}: expected {'a grey value' if i < want else 'nothing more'}, got"
                f" {repr(word[:8])[1:]}; export the map again"
            )
    if len(words) < want:
        raise _truncated(path, len(words), shape)
    return np.array([int(word) for word in words], dtype=np.int64).reshape(shape)


def _truncated(path: Path, got: int, shape: tuple[int, int]) -> MapError:
    row, col = divmod(got, shape[1])
    return MapError(
        f"{path}, pixel column {col}, row {row} from the top: the file is truncated, expected"
        f" {shape[1]} x {shape[0]} = {shape[0] * shape[1]} pixels, got {got}; copy it again"
    )


def _read_with_pillow(path: Path) -> GreyImage:
    try:
        with Image.open(path, formats=("PNG", "BMP")) as image:
            image.verify()  # checksums; pillow wants the file opened anew afterwards
        with Image.open(path, formats=("PNG", "BMP")) as image:
            image.load()
            return _from_pillow(image)
    except MapError:
        raise
    except Exception as e:  # pillow names no closed set of errors for damaged files
        why = str(e).splitlines()[0] if str(e) else type(e).__name__
        raise MapError(
            f"{path}: the image is truncated or damaged ({why}); copy or export it again"
        ) from e


def _from_pillow(image: Image.Image) -> GreyImage:
    if image.mode.startswith("I"):
        deep = np.asarray(image).astype(np.int64)
        return GreyImage(shade=deep / 65535.0, alpha=None, levels=deep)
    levels = np.asarray(image).astype(np.int64) if image.mode in ("1", "L", "P") else None
    has_alpha = image.mode in ("LA", "PA", "RGBA", "RGBa") or "transparency" in image.info
    rgba = np.asarray(image.convert("RGBA")).astype(np.int64)
    shade = rgba[..., :3].sum(axis=-1) / 3.0 / 255.0
    return GreyImage(shade, rgba[..., 3] / 255.0 if has_alpha else None, levels)
