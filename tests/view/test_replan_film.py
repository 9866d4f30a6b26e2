"""The film of replanning: as many frames as moments, what moves in it, whole or absent."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from mobius.errors import InvalidInput
from mobius.plan import Problem, build_problem, reconstructed_map
from mobius.reproduce.replanning import drive, walkers
from mobius.view.palette import rgb
from mobius.view.replan_film import Moment, film_frames, write_film

RED = "#cf4444"


@pytest.fixture(scope="module")
def driven() -> tuple[Problem, list[Moment]]:
    problem = build_problem(reconstructed_map(8), horizon=6, allow_stay=True)
    closed = walkers(np.random.default_rng(2), problem.grid.blocked, 12, 2)
    return problem, drive(problem, closed, 4, deadline_s=None)


def count(frame, colour: str) -> int:
    near = np.abs(frame.astype(int) - np.array([255 * v for v in rgb(colour)])).max(axis=-1) < 6
    return int(near.sum())


def test_frames_are_even_alike_in_size_and_show_what_moves(driven):
    problem, moments = driven
    frames = list(film_frames(problem, moments))
    assert len(frames) == 4
    assert {f.shape for f in frames} == {frames[0].shape}
    assert frames[0].shape[0] % 2 == 0 and frames[0].shape[1] % 2 == 0
    assert all(count(f, RED) > 200 for f in frames)
    assert not np.array_equal(frames[0], frames[1])


def test_a_frame_does_not_depend_on_those_before_it(driven):
    """Nothing of an earlier moment is left on the canvas."""
    problem, moments = driven
    alike = [moments[0], moments[3], moments[0]]
    first, _, again = (f[40:] for f in film_frames(problem, alike))  # without the title's line
    assert np.array_equal(first, again)


def test_a_gif_has_a_frame_a_moment_and_is_small(driven, tmp_path):
    problem, moments = driven
    write_film(tmp_path / "f.gif", problem, moments)
    with Image.open(tmp_path / "f.gif") as film:
        assert film.n_frames == 4
    assert (tmp_path / "f.gif").stat().st_size < 100_000
    assert [p.name for p in tmp_path.iterdir()] == ["f.gif"]


def test_an_mp4_is_written_too(driven, tmp_path):
    problem, moments = driven
    write_film(tmp_path / "f.mp4", problem, moments)
    assert b"ftyp" in (tmp_path / "f.mp4").read_bytes()[:16]


def test_what_cannot_be_a_film_is_refused_and_nothing_written(driven, tmp_path):
    problem, moments = driven
    for name, shown, fps in (("f.avi", moments, 5.0), ("f.gif", [], 5.0), ("f.gif", moments, 0.0)):
        with pytest.raises(InvalidInput):
            write_film(tmp_path / name, problem, shown, fps=fps)
    (tmp_path / "file").write_text("")
    with pytest.raises(InvalidInput, match="cannot be written"):
        write_film(tmp_path / "file" / "f.gif", problem, moments[:1])
    assert [p.name for p in tmp_path.iterdir()] == ["file"]
