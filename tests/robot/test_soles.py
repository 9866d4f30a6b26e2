"""Soles give way like rubber: a foot that is unloaded leaves the ground once."""

import mujoco
import numpy as np
import pytest

from mobius.assemble import flat_model
from mobius.model.dimensions import SOLE_FRICTION, SOLE_SOLIMP
from mobius.model.robot import load_model
from mobius.robot.sim import SimRobot
from mobius.types import LIMBS


def lifted(model: mujoco.MjModel) -> np.ndarray:
    """(1800, 4) force on the limbs' ends [N] while the robot is lifted off within 3 s."""
    robot = SimRobot(model)
    weight, forces = 9.81 * model.body_mass.sum(), []
    pull = np.zeros((model.nbody, 6))
    for k in range(2400):
        pull[model.body("base_link").id, 2] = 1.3 * weight * max(k - 600, 0) / 1800
        robot.pull(pull)
        robot.wait()
        forces.append(robot.sole_contact()[0])
    return np.array(forces[600:])


def touch_offs(force: np.ndarray) -> np.ndarray:
    return (np.diff((force > 1.0).astype(int), axis=0) < 0).sum(axis=0)


def test_a_robot_that_is_lifted_slowly_leaves_the_ground_once_with_every_limb():
    force = lifted(flat_model())
    np.testing.assert_array_equal(touch_offs(force), np.ones(len(LIMBS)))
    assert np.abs(np.diff(force, axis=0)).max() < 1.0


def test_on_the_engines_own_contacts_it_would_flicker():
    model = flat_model()
    model.geom_solimp[model.geom_priority == 1] = (0.9, 0.95, 0.001, 0.5, 2.0)
    assert touch_offs(lifted(model)).max() > 5


@pytest.mark.parametrize("geometry", ["full", "feet"])
def test_soles_rub_alike_in_training_but_give_way_in_the_whole_robot_alone(geometry):
    model = load_model(geometry)
    soles = model.geom_priority == 1
    assert soles.sum() >= 4
    solimp = SOLE_SOLIMP if geometry == "full" else (0.9, 0.95, 0.001, 0.5, 2.0)
    np.testing.assert_allclose(model.geom_solimp[soles], [solimp] * soles.sum())
    np.testing.assert_allclose(model.geom_friction[soles], [SOLE_FRICTION] * soles.sum())
