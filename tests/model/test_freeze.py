"""Welding: fewer degrees of freedom, the same robot where nothing moves."""

import mujoco
import numpy as np
import pytest

from mobius.control.bodies import BODIES
from mobius.errors import UnknownName
from mobius.model import robot
from mobius.model.freeze import freeze
from mobius.model.joints import JOINTS


@pytest.mark.parametrize(("body", "nv"), [("crawl", 28), ("biped", 18)])
def test_a_welded_robot_has_the_same_bodies_at_the_same_places(body, nv):
    b = BODIES[body]
    q, _ = robot.keyframe_joints(b.keyframe)
    rng = np.random.default_rng(0)
    q = q.copy()
    q[b.index] += rng.uniform(-0.05, 0.05, len(b.index))  # what is not welded still moves
    full = robot.load_spec("feet")
    welded = robot.load_spec("feet")
    freeze(welded, [j for j in JOINTS[:20] if j not in b.joints], q)
    models = [full.compile(), welded.compile()]
    assert models[1].nv == nv and models[1].nu == len(b.joints)
    assert models[1].body_mass.sum() == pytest.approx(models[0].body_mass.sum())
    data = []
    for model in models:
        d = mujoco.MjData(model)
        d.qpos[:] = robot.configuration(model, q, p=(0, 0, 0.3))
        mujoco.mj_kinematics(model, d)
        mujoco.mj_comPos(model, d)
        data.append(d)
    for i in range(models[0].nbody):
        name = models[0].body(i).name
        np.testing.assert_allclose(data[0].body(name).xpos, data[1].body(name).xpos, atol=1e-9)
    np.testing.assert_allclose(data[0].subtree_com[0], data[1].subtree_com[0], atol=1e-9)


def test_addresses_say_which_joints_are_left():
    spec = robot.load_spec("feet")
    freeze(spec, ["left_ankle_pitch"], robot.keyframe_joints("crawl")[0])
    at = robot.addresses(spec.compile())
    assert "left_ankle_pitch" not in [JOINTS[i] for i in at.present]
    assert len(at.present) == 19 and at.limbs.tolist() == [0, 1, 2, 3]


def test_unknown_joints_are_named():
    with pytest.raises(UnknownName, match="left_knee"):
        freeze(robot.load_spec("feet"), ["left_knee"], np.zeros(22))
