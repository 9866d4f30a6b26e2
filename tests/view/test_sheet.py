"""A sheet holds its frames in order, and a stage looks like a place with the bare robot's qpos."""

import numpy as np
import pytest
from PIL import Image

from mobius.errors import InvalidInput
from mobius.model import robot as model_robot
from mobius.view.gl import gl_available
from mobius.view.sheet import draw_moments, pasted, write_sheet
from mobius.view.stage import stage_model

RED, BLUE = (np.full((4, 6, 3), c, dtype=np.uint8) for c in ((255, 0, 0), (0, 0, 255)))


@pytest.fixture
def needs_gl():
    reason = gl_available()
    if reason is not None:
        pytest.skip(reason)


@pytest.fixture(scope="module")
def stage():
    return stage_model()


def test_frames_are_pasted_row_by_row():
    sheet = pasted([RED, BLUE, BLUE], columns=2)
    assert sheet.shape == (12, 16, 3)
    assert sheet[0, 0].tolist() == [255, 0, 0] and sheet[0, -1].tolist() == [0, 0, 255]
    assert sheet[-1, 0].tolist() == [0, 0, 255] and sheet[-1, -1].tolist() == [255] * 3


def test_a_sheet_is_a_png_and_nothing_else(tmp_path):
    write_sheet(tmp_path / "s.png", [RED, BLUE], columns=2)
    assert Image.open(tmp_path / "s.png").size == (16, 4)
    with pytest.raises(InvalidInput, match="png"):
        write_sheet(tmp_path / "s.jpg", [RED], columns=1)
    assert [p.name for p in tmp_path.iterdir()] == ["s.png"]


def test_rows_that_are_not_there_and_missing_captions_are_refused(stage):
    qpos = np.tile(stage.qpos0, (3, 1))
    for rows in ([3], [-1], []):
        with pytest.raises(InvalidInput, match="rows from 0 to 2"):
            draw_moments(stage, qpos, rows)
    with pytest.raises(InvalidInput, match="expected 2 captions"):
        draw_moments(stage, qpos, [0, 1], captions=["one"])


def test_the_stage_has_the_bare_robots_configuration(stage):
    bare = model_robot.load_model("full")
    assert stage.nq == bare.nq
    np.testing.assert_array_equal(stage.jnt_qposadr, bare.jnt_qposadr)


def test_the_robot_is_seen_in_daylight(stage, needs_gl):
    qpos = model_robot.configuration(
        stage, model_robot.keyframe_joints("crawl")[0], p=(0, 0, 0.275), quat=(1, 0, 0, 0)
    )
    (picture,) = draw_moments(stage, [qpos], [0], size=(160, 90), oversample=1, shadow=0)
    assert picture.shape == (90, 160, 3) and picture.mean() > 110
    rail = (picture[..., 0] > 150) & (picture[..., 2] < 90)  # orange
    assert rail.sum() > 20
