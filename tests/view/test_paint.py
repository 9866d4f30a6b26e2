"""What is painted on the floor lies where plan and path are."""

import mujoco
import numpy as np
import pytest

from mobius.errors import InvalidInput, UnknownName
from mobius.view.paint import floor_height, plan_boxes, trail_boxes

CORNER = np.array([[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [1.0, 0.5]])


def flat(xy):
    return np.zeros(len(xy))


def bump(xy):
    """A bump 5 cm high around x = 0.5 m."""
    return 0.05 * np.exp(-(((xy[:, 0] - 0.5) / 0.1) ** 2))


def test_steps_straight_on_in_one_mode_share_a_box():
    boxes = plan_boxes(CORNER, flat, modes=["crawl"] * 3)
    assert len(boxes) == 2
    # from x = 0 to 1: centre at 0.5, half length 0.5 and half the width of 0.06
    np.testing.assert_allclose(boxes[0, :2], [0.5, 0.0])
    np.testing.assert_allclose(boxes[0, 3:5], [0.53, 0.03])


def test_a_change_of_mode_changes_the_colour():
    boxes = plan_boxes(CORNER, flat, modes=["crawl", "biped", "biped"])
    assert len(boxes) == 3
    assert (boxes[0, 15:] != boxes[1, 15:]).any()
    assert (boxes[1, 15:] == boxes[2, 15:]).all()


def test_boxes_lie_along_the_step_and_their_axes_are_a_rotation():
    rotation = plan_boxes(CORNER, flat)[1, 6:15].reshape(3, 3)
    np.testing.assert_allclose(rotation[:, 0], [0.0, 1.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(rotation) == pytest.approx(1.0)


def test_modes_must_fit_the_steps_and_exist():
    with pytest.raises(InvalidInput, match="expected 3 modes for 4 plan points, got 2"):
        plan_boxes(CORNER, flat, modes=["crawl", "crawl"])
    with pytest.raises(UnknownName, match="Did you mean 'crawl'"):
        plan_boxes(CORNER, flat, modes=["crawl", "craw", "crawl"])


def test_a_plan_of_one_point_paints_nothing():
    assert plan_boxes(CORNER[:1], flat).shape == (0, 19)


def test_the_trail_grows_with_the_way_gone():
    xy = np.column_stack([np.linspace(0, 1, 101), np.zeros(101)])
    boxes, shown = trail_boxes(xy, flat)
    assert shown[0] == 0 and shown[-1] == len(boxes)
    assert (np.diff(shown) >= 0).all()
    # a box every 0.1 m: ten fit into one metre
    assert len(boxes) == 10


def test_on_rough_floor_the_plan_stays_on_top():
    """The plan once dived under the bumps of a rough patch and looked broken."""
    boxes = plan_boxes(CORNER[:3], bump, modes=["crawl"] * 2)
    assert len(boxes) == 10
    for box in boxes:
        along = np.linspace(-0.05, 0.05, 21)[:, None] * box[6:15].reshape(3, 3)[:, 0]
        line = box[:3] + along
        assert (line[:, 2] > bump(line[:, :2])).all()


def test_a_robot_that_stands_leaves_no_trail():
    boxes, shown = trail_boxes(np.zeros((50, 2)), flat)
    assert boxes.shape == (0, 19)
    assert not shown.any()


def test_the_floor_is_found_under_the_robot_on_a_step_and_under_a_shelf():
    model = mujoco.MjModel.from_xml_string("""
    <mujoco>
      <worldbody>
        <geom type="plane" size="0 0 1"/>
        <geom type="box" size=".5 .5 .05" pos="2 0 .05"/>
        <geom type="box" size=".5 .5 .02" pos="4 0 .9"/>
        <body pos="0 0 .2"><freejoint/><geom size=".1"/></body>
      </worldbody>
    </mujoco>""")
    xy = np.array([[0.0, 0.0], [2.0, 0.0], [4.0, 0.0]])
    np.testing.assert_allclose(floor_height(model, model.qpos0, xy), [0.0, 0.1, 0.0], atol=1e-9)
