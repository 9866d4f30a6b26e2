"""The robot's cameras: where they sit, where they look, how wide."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mobius.geometry import mat_to_quat

Array = NDArray[np.float64]

HEAD_PITCH = float(np.radians(40.0))
"""The head camera looks this far below +x of the trunk [rad] [A]."""


@dataclass(frozen=True)
class Camera:
    """One camera, fixed to the trunk."""

    pos: tuple[float, float, float]
    """In ``base_link`` [m]."""
    right: tuple[float, float, float]
    """Unit vector to the right of its picture, in ``base_link``."""
    up: tuple[float, float, float]
    """Unit vector to the top of its picture."""
    fovy: float
    """Vertical field of view [deg]."""

    @property
    def optical(self) -> Array:
        """(4,) wxyz of its optical frame in ``base_link``: x right, y down, z forward (REP-103)."""
        right, down = np.array(self.right), -np.array(self.up)
        return mat_to_quat(np.column_stack([right, down, np.cross(right, down)]))

    def focal(self, height: int) -> float:
        """Focal length [px] of a picture ``height`` [px] high, square pixels, no distortion."""
        return float(0.5 * height / np.tan(0.5 * np.radians(self.fovy)))


CAMERAS: dict[str, Camera] = {
    "head": Camera(
        (0.176, 0.0, 0.047),
        (0.0, -1.0, 0.0),
        (float(np.sin(HEAD_PITCH)), 0.0, float(np.cos(HEAD_PITCH))),
        58.0,
    ),
    "vio": Camera((-0.02, 0.0, 0.08), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0), 120.0),
}
"""By their names in the MJCF: ``head`` (RGB-D) and ``vio`` (fisheye pair on the back, as one)."""
