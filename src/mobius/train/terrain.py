"""The training ground: one height map of tiles, harder from row to row, patches underfoot.

All robots share one map (a height field cannot differ between robots of a batch) and start on
tiles of their own level. Row 0 is flat. The last column is level ground with slippery and
soft patches.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mobius.world.ground import SPACING, Ground, bumps, slope, steps

Array = NDArray[np.float64]
Ids = NDArray[np.int64]


@dataclass(frozen=True)
class TerrainConfig:
    """Heights and angles of the hardest row; every row below has its share."""

    bumps: float = 0.06
    """Height map, lowest to highest [m]."""
    steps: float = 0.04
    """Plates, lowest to highest [m]."""
    slope: float = 0.24
    """[rad]."""
    levels: int = 5
    """Rows above the flat one."""
    tile: float = 6.0
    """Edge of a tile [m]."""
    slippery: float = 0.4
    """Share of a sole's friction that is left on the hardest slippery patches."""
    soft: float = 0.06
    """Contact time constant on the hardest soft patches [s]; firm ground has 0.02."""
    patch: float = 1.0
    """Edge of a patch [m]."""
    seed: int = 7


COLUMNS = ("bumps", "steps", "slope", "patches")
FIRM = 0.02
"""MuJoCo's default contact time constant [s]."""


class Tiles:
    """The map, where robots start on it, and what is underfoot."""

    def __init__(self, cfg: TerrainConfig) -> None:
        self.cfg = cfg
        self._n = round(cfg.tile / SPACING)
        rng = np.random.default_rng(cfg.seed)
        rows = []
        for level in range(cfg.levels + 1):
            share = level / max(cfg.levels, 1)
            rows.append(np.hstack([self._tile(rng, kind, share) for kind in COLUMNS]))
        height = np.vstack(rows)
        height = np.pad(height, ((0, 1), (0, 1)), mode="edge")
        self.ground = Ground(height, (0.0, 0.0))

    def _tile(self, rng: np.random.Generator, kind: str, share: float) -> Array:
        n, cfg = self._n, self.cfg
        if kind == "patches" or share == 0:
            return np.zeros((n, n))
        if kind == "slope":
            return slope((n, n), share * cfg.slope)
        height = {"bumps": bumps, "steps": steps}[kind](rng, (n, n), share * getattr(cfg, kind))
        edge = np.minimum(np.arange(n), np.arange(n)[::-1]) * SPACING / 0.5
        ramp = np.clip(edge, 0, 1)
        return np.asarray(height * np.minimum(ramp[:, None], ramp[None]))

    def start(self, rng: np.random.Generator, level: Ids, column: Ids) -> Array:
        """Start points (m, 2) [m], within the middle half of tiles (m,)."""
        offset = rng.uniform(0.25, 0.75, (len(level), 2))
        return np.asarray((np.column_stack([column, level]) + offset) * self.cfg.tile)

    def surface(self, xy: Array) -> tuple[Array, Array]:
        """Friction factor (...) and contact time constant (...) [s] at points (..., 2) [m].

        In the last column a third of the patches is slippery, a third soft, by level.
        """
        cfg = self.cfg
        level = np.clip(np.floor(xy[..., 1] / cfg.tile), 0, cfg.levels)
        inside = np.floor(xy[..., 0] / cfg.tile) == COLUMNS.index("patches")
        which = (np.floor(xy[..., 0] / cfg.patch) + 2 * np.floor(xy[..., 1] / cfg.patch)) % 3
        share = np.where(inside, level / max(cfg.levels, 1), 0.0)
        friction = np.where(which == 0, 1.0 - share * (1.0 - cfg.slippery), 1.0)
        firmness = np.where(which == 1, FIRM + share * (cfg.soft - FIRM), FIRM)
        return friction, firmness
