"""The picture of a plan: a whole PNG of the size that was told."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from mobius.errors import InvalidInput
from mobius.plan import build_problem, reconstructed_map, solve
from mobius.types import GridMap
from mobius.view.palette import MODE_COLOURS, rgb
from mobius.view.plan_picture import draw_plan, picture_size


def pixels_of(path, colour) -> int:
    image = np.asarray(Image.open(path).convert("RGB")).astype(int)
    return int((np.abs(image - np.array([255 * v for v in rgb(colour)])).max(axis=-1) < 3).sum())


def test_a_small_plan_is_a_png_of_the_told_size_in_the_colours_of_its_modes(tmp_path):
    grid = reconstructed_map(10)
    crawl = build_problem(grid, horizon=12, modes=("crawl",))
    draw_plan(tmp_path / "p.png", crawl, solve(crawl))
    with Image.open(tmp_path / "p.png") as image:
        assert image.format == "PNG" and image.size == picture_size(grid)
    assert pixels_of(tmp_path / "p.png", MODE_COLOURS["crawl"]) > 500
    assert pixels_of(tmp_path / "p.png", MODE_COLOURS["roll"]) == 0
    assert [p.name for p in tmp_path.iterdir()] == ["p.png"]


def test_long_maps_turned_maps_and_large_maps_are_drawn_too(tmp_path):
    for shape, yaw in (((30, 3), 0.0), ((2, 9), 0.7), ((150, 90), 0.0)):
        blocked = np.zeros(shape, dtype=bool)
        grid = GridMap("g", 0.5, [1.0, 2.0, yaw], blocked, np.full(shape, 7))
        ends = grid.center_of([[0, 0], [shape[0] - 1, shape[1] - 1]])
        problem = build_problem(grid, start=ends[0], goal=ends[1], horizon=8)
        draw_plan(tmp_path / "g.png", problem, solve(problem))
        with Image.open(tmp_path / "g.png") as image:
            assert image.size == picture_size(grid)


def test_a_map_without_a_plan_is_drawn_as_such(tmp_path):
    problem = build_problem(reconstructed_map(2), horizon=3, modes=("roll",))
    draw_plan(tmp_path / "n.png", problem, solve(problem, raise_infeasible=False))
    assert (tmp_path / "n.png").stat().st_size > 0


def test_another_suffix_is_refused_and_nothing_written(tmp_path):
    problem = build_problem(reconstructed_map(4), horizon=3)
    with pytest.raises(InvalidInput, match=r"\.png"):
        draw_plan(tmp_path / "p.jpg", problem, solve(problem))
    assert list(tmp_path.iterdir()) == []


def test_a_place_that_cannot_be_written_is_told_in_one_line(tmp_path):
    (tmp_path / "file").write_text("")
    problem = build_problem(reconstructed_map(4), horizon=3)
    with pytest.raises(InvalidInput, match="cannot be written"):
        draw_plan(tmp_path / "file" / "p.png", problem, solve(problem))
