"""The training ground: rows grow harder, borders meet, patches lie where they should."""

import numpy as np

from mobius.train.terrain import COLUMNS, FIRM, TerrainConfig, Tiles
from mobius.world.ground import SPACING

CFG = TerrainConfig()
TILES = Tiles(CFG)


def tile(level: int, kind: str) -> np.ndarray:
    n = round(CFG.tile / SPACING)
    column = COLUMNS.index(kind)
    return TILES.ground.height[level * n : (level + 1) * n, column * n : (column + 1) * n]


def test_row_zero_is_flat_and_rows_grow_to_the_configured_height():
    assert (TILES.ground.height[: round(CFG.tile / SPACING)] == 0).all()
    for kind, top in (("bumps", CFG.bumps), ("steps", CFG.steps)):
        highest = [tile(level, kind).max() for level in range(CFG.levels + 1)]
        assert (np.diff(highest) > 0).all()
        assert 0.9 * top < highest[-1] <= top


def test_slopes_have_the_configured_angle():
    rise = np.abs(np.diff(tile(CFG.levels, "slope"), axis=0)) / SPACING
    assert np.isclose(np.arctan(rise.max()), CFG.slope)


def test_tiles_meet_at_height_zero():
    n = round(CFG.tile / SPACING)
    assert (TILES.ground.height[:, ::n] == 0).all() and (TILES.ground.height[::n] == 0).all()


def test_patches_are_slippery_or_soft_only_in_their_column_and_by_level():
    rng = np.random.default_rng(0)
    xy = rng.uniform(0, CFG.tile * np.array([len(COLUMNS), CFG.levels + 1]), (4000, 2))
    friction, firmness = TILES.surface(xy)
    elsewhere = xy[:, 0] < CFG.tile * COLUMNS.index("patches")
    assert (friction[elsewhere] == 1).all() and (firmness[elsewhere] == FIRM).all()
    hardest = ~elsewhere & (xy[:, 1] > CFG.tile * CFG.levels)
    assert set(np.round(friction[hardest], 9)) == {CFG.slippery, 1.0}
    assert set(np.round(firmness[hardest], 9)) == {FIRM, CFG.soft}
    assert not ((friction < 1) & (firmness > FIRM)).any()


def test_robots_start_well_inside_their_tile():
    rng = np.random.default_rng(0)
    level, column = np.repeat(np.arange(6), 4), np.tile(np.arange(4), 6)
    xy = TILES.start(rng, level, column) / CFG.tile
    assert (np.floor(xy) == np.column_stack([column, level])).all()
    assert (np.abs(xy % 1 - 0.5) <= 0.25).all()
