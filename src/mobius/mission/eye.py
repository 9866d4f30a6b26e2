"""The head camera of a live robot, as pictures for the bridge."""

from __future__ import annotations

from typing import Any

import numpy as np

from mobius.bridge.camera import Picture
from mobius.bridge.messages import CLOCK_HZ, TOPICS
from mobius.model.cameras import CAMERAS
from mobius.robot import TICK
from mobius.view.eye import Eye

EVERY = CLOCK_HZ // TOPICS["/camera/color/image_raw"].rate
"""Ticks between two pictures."""


class HeadCamera:
    """Gives a picture whenever one is due and ready; ``with`` ends it.

    Args:
        model: Scene with the robot.
        size: Width and height [px].
    """

    def __init__(self, model: Any, *, size: tuple[int, int] = (320, 240)) -> None:
        self._eye = Eye(model, camera="head", size=size)
        self._focal = CAMERAS["head"].focal(size[1])

    def __call__(self, robot: Any, stamp: float) -> Picture | None:
        """The picture asked for last time, if this is a moment for pictures; asks for the next."""
        if round(stamp / TICK) % EVERY:
            return None
        seen = self._eye.take()
        self._eye.look(np.array(robot.data.qpos), stamp)
        return None if seen is None else Picture(seen[0], seen[1], self._focal)

    def __enter__(self) -> HeadCamera:
        return self

    def __exit__(self, *_: object) -> None:
        self._eye.close()
