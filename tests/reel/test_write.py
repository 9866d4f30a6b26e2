"""A show leaves video, sheet and events."""

import json

import numpy as np
import pytest
from PIL import Image

from mobius.reel import Act, play, write_show
from mobius.reel.shows import Show
from mobius.types import Mode
from mobius.view.gl import gl_available


@pytest.fixture
def needs_gl():
    reason = gl_available()
    if reason is not None:
        pytest.skip(reason)


def test_a_show_becomes_a_video_a_sheet_and_a_json(tmp_path, needs_gl):
    show = Show("short", "standing", "crawl", (Act(Mode.CRAWL, 0.1),))
    files = write_show(tmp_path, show, play(show), seed=0, size=(160, 96))
    assert [f.name for f in files] == ["short.mp4", "short.png", "short.json"]
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted(f.name for f in files)
    assert json.loads(files[2].read_text())["complete"]
    sheet = np.asarray(Image.open(files[1]))
    assert sheet.shape[0] == 48 and (sheet.std(axis=(0, 1)) > 10).all()
