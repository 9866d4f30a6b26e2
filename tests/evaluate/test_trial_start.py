"""Starts of trials: drawn by seed, on the floor, without links in one another."""

import numpy as np
import pytest

from mobius.evaluate.trial_start import FLOOR_TILT, draw_start
from mobius.model.poses import lowest_point, overlap
from mobius.model.robot import addresses, keyframe_joints


@pytest.mark.parametrize(("pose", "height"), [("prone", 1e-3), ("stand", 1e-3), ("fall", 0.4)])
def test_a_start_is_over_its_tilted_floor_and_of_its_seed(pose, height):
    drawn = draw_start(pose, "crawl", 4)
    assert lowest_point(drawn.model, drawn.start.qpos) == pytest.approx(height, abs=1e-4)
    again, other = draw_start(pose, "crawl", 4), draw_start(pose, "crawl", 5)
    np.testing.assert_array_equal(drawn.start.qpos, again.start.qpos)
    assert not np.allclose(drawn.start.qpos, other.start.qpos)
    assert 0 < np.arccos(drawn.normal[2]) < FLOOR_TILT
    assert drawn.start.variation.everywhere and drawn.start.variation == again.start.variation


def test_joint_noise_is_small_and_a_fall_is_anything():
    at = addresses(draw_start("crawl", "crawl", 0).model)
    near = draw_start("crawl", "crawl", 0).start.qpos[at.qpos] - keyframe_joints("crawl")[0]
    assert 0.02 < np.std(near[:20]) < 0.08
    fall = draw_start("fall", "crawl", 1)
    assert overlap(fall.model, fall.start.qpos) < 2e-3
    assert np.std(fall.start.qpos[at.qpos] - keyframe_joints("crawl")[0]) > 0.3
