"""A shove adds its velocity to the whole robot over its duration, and nothing afterwards."""

import mujoco
import numpy as np
import pytest

from mobius.errors import InvalidInput
from mobius.model.robot import load_model
from mobius.robot.sim import SimRobot


def floating() -> SimRobot:
    """A robot that falls freely, far above the floor."""
    robot = SimRobot(load_model("full"))
    robot.data.qpos[2] += 10.0
    mujoco.mj_forward(robot.model, robot.data)
    return robot


def velocity(robot: SimRobot) -> np.ndarray:
    """(2,) of the centre of mass [m/s]."""
    mujoco.mj_subtreeVel(robot.model, robot.data)
    return np.array(robot.data.subtree_linvel[0, :2])


@pytest.mark.parametrize("as_force", [False, True])
def test_a_free_robot_gains_exactly_the_velocity(as_force):
    robot = floating()
    robot.push((0.3, -0.2), 0.1, as_force=as_force)
    speeds = []
    for _ in range(90):
        robot.wait()
        speeds.append(velocity(robot))
    mujoco.mj_forward(robot.model, robot.data)
    np.testing.assert_allclose(velocity(robot), [0.3, -0.2], atol=1e-3)
    np.testing.assert_allclose(speeds[65], speeds[-1], atol=1e-3)
    np.testing.assert_allclose(speeds[30], [0.15, -0.1], atol=0.01)
    assert not robot.data.xfrc_applied.any()


@pytest.mark.parametrize(("as_force", "felt"), [(False, 0.0), (True, 3.0)])
def test_only_a_force_is_felt_by_the_accelerometer(as_force, felt):
    robot = floating()
    for _ in range(12):
        robot.wait()
    before = robot.read().accel_I[0]
    robot.push((0.3, 0.0), 0.1, as_force=as_force)
    for _ in range(12):
        robot.wait()
    assert robot.read().accel_I[0] - before == pytest.approx(felt, abs=0.3)


def test_a_shove_without_duration_is_refused():
    with pytest.raises(InvalidInput, match="1/600 s"):
        floating().push((0.1, 0.0), 0.0)
