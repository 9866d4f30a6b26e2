"""Limb ends on the ground: force, and slip at the contact point."""

import mujoco
import numpy as np
import pytest

from mobius.model.robot import load_model
from mobius.robot.ends import limb_of_geoms, sliding_speed
from mobius.robot.sim import SimRobot
from mobius.types import LIMBS


@pytest.fixture
def standing():
    robot = SimRobot(load_model("full"))
    for _ in range(300):
        robot.wait()
    return robot


def test_a_rolling_sphere_does_not_slide():
    # radius 0.1 m, 0.5 m/s along x: it turns about +y with 5 rad/s
    rolling = [0.0, 5.0, 0.0, 0.5, 0.0, 0.0]
    down, up = [0.0, 0.0, -0.1], [0.0, 0.0, 1.0]
    assert sliding_speed(rolling, [0.0, 0.0, 0.0], down, up) == pytest.approx(0.0)
    sliding = [0.0, 0.0, 0.0, 0.5, 0.0, 0.0]
    assert sliding_speed(sliding, [0.0, 0.0, 0.0], down, up) == pytest.approx(0.5)


def test_what_moves_along_the_normal_does_not_slide():
    slope = [-np.sin(0.2), 0.0, np.cos(0.2)]
    velocity = 0.3 * np.array(slope)
    assert sliding_speed([0, 0, 0, *velocity], [0, 0, 0], [0, 0, 0], slope) < 1e-6


def test_a_foot_that_pivots_slides_where_it_touches():
    assert sliding_speed([0, 0, 2.0, 0, 0, 0], [0, 0, 0], [0.05, 0, 0], [0, 0, 1]) == (
        pytest.approx(0.1)
    )


def test_a_limb_ends_in_its_gripper_or_foot(standing):
    model = standing.model
    limb_of = limb_of_geoms(model)
    for i in range(model.ngeom):
        name = model.geom(i).name
        if "_sole" in name:
            assert LIMBS[limb_of[i]] == "_".join(name.split("_")[:2])
        if name.startswith(("base_link", "floor")) or "crank" in name:
            assert limb_of[i] == -1


def test_a_standing_robot_presses_with_its_weight_and_does_not_slide(standing):
    force, slide = standing.sole_contact()
    assert force.sum() == pytest.approx(10.3 * 9.81, rel=0.02)
    assert (force > 1.0).all() and slide.max() < 2e-3


def test_a_robot_that_is_dragged_slides_on_all_ends_as_fast_as_it_is_dragged(standing):
    standing.data.qvel[:] = 0.0
    standing.data.qvel[0] = 0.2
    mujoco.mj_forward(standing.model, standing.data)
    _, slide = standing.sole_contact()
    np.testing.assert_allclose(slide, 0.2, atol=1e-6)


def test_in_the_air_nothing_presses_or_slides(standing):
    standing.data.qpos[2] += 1.0
    mujoco.mj_forward(standing.model, standing.data)
    assert not any(values.any() for values in standing.sole_contact())
