"""Four motions over time, one each, for the picture of how a body tracks (Fig. 17)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mobius.evaluate.commands import Segment, segment_of
from mobius.evaluate.episode import Setup, drive
from mobius.evaluate.jobs import run_jobs

Array = NDArray[np.float64]

MOTIONS = {"sideways": "left", "forward": "forward", "backward": "backward", "yaw": "turn_left"}
"""Name of each motion and of its command."""
HOLD_S = 2.0
"""Stand, move twice this long, stand [s]."""


@dataclass(frozen=True, eq=False)
class Series:
    """One motion of one robot at 60 Hz."""

    name: str
    t: Array
    """(n,) [s]."""
    target: Array
    """(n, 3) vx, vy [m/s], wz [rad/s]."""
    actual: Array
    """(n, 3) the truth."""
    smooth: Array
    """(n, 3) its means over a stride."""


def motions(setup: Setup, *, speed: float = 1.0, workers: int = 1) -> list[Series]:
    """Each motion once, from standing to standing, ``speed`` times as fast as the range."""
    return run_jobs(_move, [(setup, name, speed) for name in MOTIONS], workers=workers)


def _move(job: tuple[Setup, str, float]) -> Series:
    setup, name, speed = job
    stand = Segment("stand", (0.0, 0.0, 0.0))
    rng = np.random.default_rng(setup.seed)
    move = segment_of(MOTIONS[name], setup.body, rng, speed=speed)
    episode = drive(setup, [stand, move, move, stand], hold_s=HOLD_S)
    rows = episode.rows
    return Series(name, rows["t"], rows["cmd_twist_H"], rows["true_twist_H"], episode.smooth)
