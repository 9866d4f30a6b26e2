"""Smooth random bumps for a rough patch."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from mobius.world.shapes import RoughPatch

Array = NDArray[np.float64]

SPACING = 0.04
"""Distance between samples of a height field [m], at most."""


def bumps(patch: RoughPatch) -> Array:
    """Heights (ny, nx) [m] over the patch, row 0 at its low y; 0 on the whole edge.

    White noise, smoothed to the patch's wavelength and stretched to 0..1, sinks to the
    floor along the edge over one wavelength (at most half the patch). The highest bump is
    ``amplitude`` high. The same seed gives the same bumps.
    """
    size_x, size_y = patch.area.size
    nx, ny = (max(3, int(np.ceil(s / SPACING)) + 1) for s in (size_x, size_y))
    noise = np.random.default_rng(patch.seed).standard_normal((ny, nx))
    # a Gaussian of sigma = wavelength / 4 leaves bumps about one wavelength apart
    spacing = np.array([size_y / (ny - 1), size_x / (nx - 1)])
    smooth = ndimage.gaussian_filter(noise, patch.wavelength / 4 / spacing, mode="reflect")
    smooth = (smooth - smooth.min()) / max(float(np.ptp(smooth)), 1e-12)
    y, x = (_ramp(n, s, patch.wavelength) for n, s in ((ny, size_y), (nx, size_x)))
    height = (0.15 + 0.85 * smooth) * np.outer(y, x)
    return np.asarray(patch.amplitude * height / height.max())


def _ramp(n: int, size: float, width: float) -> Array:
    """Smooth step (n,) from 0 at both ends of a line of ``size`` [m] to 1 within ``width``."""
    at = np.linspace(0.0, size, n)
    t = np.clip(np.minimum(at, size - at) / min(width, size / 2), 0.0, 1.0)
    return np.asarray(t * t * (3 - 2 * t))
