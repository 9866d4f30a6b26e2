"""The bar's place and what it adds to a scene."""

import mujoco
import numpy as np
import pytest

from mobius.errors import InvalidInput
from mobius.model.robot import load_spec
from mobius.world.bar import Bar, add_bar, build_bar_scene


def pose(bar: Bar) -> tuple[np.ndarray, np.ndarray]:
    """Middle and axis of a bar in a compiled scene."""
    spec = mujoco.MjSpec()
    add_bar(spec, bar)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    geom = model.geom("bar").id
    return data.geom_xpos[geom].copy(), data.geom_xmat[geom].reshape(3, 3)[:, 0].copy()


def test_a_bar_runs_from_right_to_left_at_its_height():
    middle, axis = pose(Bar(height=1.1, xy=(0.2, -0.1)))
    np.testing.assert_allclose(middle, [0.2, -0.1, 1.1])
    np.testing.assert_allclose(axis, [0, 1, 0], atol=1e-9)


def test_yaw_turns_it_and_tilt_lifts_its_left_end():
    _, axis = pose(Bar(yaw=0.3, tilt=0.1))
    ahead = np.cos(0.1) * np.array([-np.sin(0.3), np.cos(0.3)])
    np.testing.assert_allclose(axis, [*ahead, np.sin(0.1)], atol=1e-9)


def test_posts_stand_on_the_floor_at_its_ends():
    spec = mujoco.MjSpec()
    add_bar(spec, Bar(height=1.0, length=0.8, width=0.03))
    model = spec.compile()
    for i, side in enumerate((-1, 1)):
        post = model.geom(f"bar_post_{i}")
        np.testing.assert_allclose(post.pos[:2], [0, side * 0.415], atol=1e-9)
        assert post.pos[2] - post.size[2] == pytest.approx(0)
        assert post.pos[2] + post.size[2] == pytest.approx(1.015)


def test_the_scene_adds_no_freedom_and_keeps_the_robots_step():
    robot = load_spec()
    model = build_bar_scene(robot).compile()
    assert model.nq == robot.compile().nq and model.opt.timestep == pytest.approx(1 / 600)
    assert robot.geom("floor") is None


def test_nonsense_is_refused():
    with pytest.raises(InvalidInput, match="positive height"):
        Bar(height=-1.0)
    with pytest.raises(InvalidInput, match="groove narrower"):
        Bar(width=0.005)
    with pytest.raises(InvalidInput, match="the robot alone"):
        build_bar_scene(build_bar_scene(load_spec()))
