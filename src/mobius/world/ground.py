"""Uneven ground as a height map: bumps, steps, slopes; heights anywhere; into a MuJoCo scene."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage

from mobius.errors import InvalidInput

Array = NDArray[np.float64]

SPACING = 0.05
"""Distance between samples of a height map [m]."""
KINDS = ("bumps", "steps", "slope")
"""What :func:`build_ground` can make."""
_BASE = 0.05


@dataclass(frozen=True, eq=False)
class Ground:
    """A height map over a rectangle; flat at 0 outside it."""

    height: Array
    """(ny, nx) [m] >= 0; row 0 at the low y."""
    origin: tuple[float, float]
    """Where height[0, 0] lies in the world: x, y [m]."""
    spacing: float = SPACING
    """[m]."""

    def __post_init__(self) -> None:
        if self.height.ndim != 2 or min(self.height.shape) < 2:
            raise InvalidInput(
                f"Ground: expected a height map of at least 2 x 2, got {self.height.shape}"
            )
        if not np.isfinite(self.height).all() or self.height.min() < 0:
            raise InvalidInput("Ground: heights must be finite and >= 0; lift the map first")

    @property
    def size(self) -> tuple[float, float]:
        """Extent in x and y [m]."""
        ny, nx = self.height.shape
        return (nx - 1) * self.spacing, (ny - 1) * self.spacing

    def at(self, xy: ArrayLike) -> Array:
        """Heights (...) [m] at points (..., 2) [m], between samples bilinearly."""
        xy = np.asarray(xy, dtype=float)
        ny, nx = self.height.shape
        u = (xy[..., 0] - self.origin[0]) / self.spacing
        v = (xy[..., 1] - self.origin[1]) / self.spacing
        inside = (u >= 0) & (v >= 0) & (u <= nx - 1) & (v <= ny - 1)
        u, v = np.clip(u, 0, nx - 1), np.clip(v, 0, ny - 1)
        i = np.minimum(v.astype(np.int64), ny - 2)
        j = np.minimum(u.astype(np.int64), nx - 2)
        a, b = v - i, u - j
        h = self.height
        low = h[i, j] * (1 - b) + h[i, j + 1] * b
        high = h[i + 1, j] * (1 - b) + h[i + 1, j + 1] * b
        return np.asarray(np.where(inside, low * (1 - a) + high * a, 0.0))


def bumps(rng: np.random.Generator, shape: tuple[int, int], amplitude: float) -> Array:
    """Smooth random bumps (ny, nx) from 0 to ``amplitude`` [m], about 0.3 m apart."""
    noise = rng.standard_normal(shape)
    smooth = ndimage.gaussian_filter(noise, 0.3 / 4 / SPACING, mode="wrap")
    smooth = (smooth - smooth.min()) / max(float(np.ptp(smooth)), 1e-12)
    return np.asarray(amplitude * smooth)


def steps(
    rng: np.random.Generator, shape: tuple[int, int], amplitude: float, *, tread: float = 0.35
) -> Array:
    """Random square plates (ny, nx) of ``tread`` [m], each 0 to ``amplitude`` [m] high."""
    k = max(1, round(tread / SPACING))
    plates = rng.uniform(0, amplitude, (shape[0] // k + 1, shape[1] // k + 1))
    return np.asarray(np.kron(plates, np.ones((k, k)))[: shape[0], : shape[1]])


def slope(shape: tuple[int, int], angle: float, *, top: float = 1.0) -> Array:
    """A pyramid (ny, nx): faces rise by ``angle`` [rad] to a flat top ``top`` [m] wide."""
    ny, nx = shape
    y, x = np.meshgrid(np.arange(ny) * SPACING, np.arange(nx) * SPACING, indexing="ij")
    edge = np.minimum(np.minimum(x, (nx - 1) * SPACING - x), np.minimum(y, (ny - 1) * SPACING - y))
    reach = (min(shape) - 1) * SPACING / 2 - top / 2
    return np.asarray(np.tan(angle) * np.clip(edge, 0, max(reach, 0.0)))


def build_ground(kind: str, size: float, seed: int, *, amplitude: float = 0.0) -> Ground:
    """A square of uneven ground around the origin.

    Args:
        kind: ``bumps`` or ``steps`` (``amplitude`` is the height [m]) or ``slope`` (``amplitude``
            is the angle [rad]).
        size: Edge [m].
        seed: Of bumps and steps.
        amplitude: See ``kind``; 0 is flat.

    Raises:
        InvalidInput: An unknown kind, a size below 1 m or a negative amplitude.
    """
    if kind not in KINDS:
        raise InvalidInput(f"build_ground: unknown kind {kind!r}; choose one of {', '.join(KINDS)}")
    if size < 1.0 or amplitude < 0:
        raise InvalidInput(
            f"build_ground: expected size >= 1 m, amplitude >= 0; got {size}, {amplitude}"
        )
    n = round(size / SPACING) + 1
    rng = np.random.default_rng([seed, 31])
    if kind == "slope":
        height = slope((n, n), amplitude)
    else:
        height = (bumps if kind == "bumps" else steps)(rng, (n, n), amplitude)
    return Ground(height, (-size / 2, -size / 2))


def add_ground(
    spec: mujoco.MjSpec, ground: Ground, *, contype: int = 1, conaffinity: int = 1
) -> None:
    """Add the map to a robot's spec as a height field called ``floor``, in place.

    The field is not a plane: nothing holds a robot that walks off its edge.
    """
    top = max(float(ground.height.max()), 1e-3)
    ny, nx = ground.height.shape
    spec.add_hfield(
        name="floor",
        nrow=ny,
        ncol=nx,
        size=[ground.size[0] / 2, ground.size[1] / 2, top, _BASE],
        userdata=(ground.height / top).ravel(),
    )
    spec.worldbody.add_geom(
        name="floor",
        type=mujoco.mjtGeom.mjGEOM_HFIELD,
        hfieldname="floor",
        pos=[ground.origin[0] + ground.size[0] / 2, ground.origin[1] + ground.size[1] / 2, 0.0],
        contype=contype,
        conaffinity=conaffinity,
        rgba=[0.62, 0.55, 0.45, 1.0],
    )
