"""Where the robot has been: squares of the floor, in the order in which it came to them."""

from __future__ import annotations

import numpy as np

from mobius.view.live.nouns import Scene, Snapshot

CELL = 0.5
"""Edge of a square [m]."""


class Visited:
    """Squares of :data:`CELL` of the map frame, as multiples of it."""

    def __init__(self) -> None:
        self.squares: dict[tuple[int, int], None] = {}
        self._scene = 0
        self._t = 0.0

    def see(self, scene: Scene | None, snapshot: Snapshot | None) -> None:
        """Take in where the true robot is; another scene or a jump back in time starts anew."""
        if scene is None or snapshot is None or snapshot.scene != scene.number:
            return
        if scene.number != self._scene or snapshot.t < self._t:
            self._scene, self.squares = scene.number, {}
        self._t = snapshot.t
        i, j = (int(v) for v in np.floor(snapshot.true_pose[:2] / CELL))
        self.squares[(i, j)] = None
