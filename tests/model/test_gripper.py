"""The model's fingers and Eq. (19)."""

import mujoco
import numpy as np
import pytest

from mobius.errors import InvalidInput
from mobius.model.gripper import finger_tips, gap, grasp_map, pinch_angle, pinch_force
from mobius.model.hand import load_hand
from mobius.model.servo import SERVOS


@pytest.mark.parametrize("side", ["left", "right"])
def test_finger_tips_are_those_of_the_mjcf(side):
    model = load_hand(side).compile()
    data = mujoco.MjData(model)
    hand = model.body(f"{side}_arm_gripper_base").id
    for q in (0.0, 0.4, 0.9):
        data.joint(f"{side}_gripper").qpos[0] = data.joint(f"{side}_finger_b").qpos[0] = q
        mujoco.mj_kinematics(model, data)
        R = data.xmat[hand].reshape(3, 3)
        for k, finger in enumerate("ab"):
            geom = model.geom(f"{side}_arm_finger_{finger}_sole1").id  # a capsule, knee to tip
            half = model.geom_size[geom, 1] * data.geom_xmat[geom].reshape(3, 3)[:, 2]
            ends = data.geom_xpos[geom] + np.array([half, -half])
            local = (ends - data.xpos[hand]) @ R
            gaps = np.linalg.norm(local - finger_tips(q)[k], axis=1)
            assert gaps.min() < 1e-6


def test_a_bar_is_touched_at_its_pinch_angle():
    for width in (0.02, 0.03, 0.05):
        assert gap(pinch_angle(width)) == pytest.approx(width, abs=1e-9)
    with pytest.raises(InvalidInput, match=r"expected a bar of 0 to \d+ mm, got 200 mm"):
        pinch_angle(0.2)


def test_pinching_does_the_servos_work():
    """Moment times d q = two forces times the way of each tip."""
    q = pinch_angle(0.03)
    way = (finger_tips(q + 1e-6) - finger_tips(q - 1e-6))[0, 1] / 2e-6
    assert 2 * pinch_force(q) * way == pytest.approx(SERVOS["gripper"].stall_torque)


def test_grasp_map_by_hand():
    """A pinch of 20 N at y = +-15 mm, 100 mm ahead (-z), each finger carrying 25 N along +z and the
    first 4 N along x: f = (4, 0, 50); tau = sum p x f = (0, -0.1*4, 0) + (0, 0, -0.015*4).
    """
    p = [[0, 0.015, -0.1], [0, -0.015, -0.1]]
    tips = np.array([4, -20, 25, 0, 0, 0, 0, 20, 25, 0, 0, 0], dtype=float)
    np.testing.assert_allclose(grasp_map(p) @ tips, [4, 0, 50, 0, -0.4, -0.06], atol=1e-12)


def test_grasp_map_keeps_power():
    """Wrist wrench times wrist twist = tip wrenches times the tips' twists: G^T is kinematics."""
    rng = np.random.default_rng(0)
    p, W, twist = rng.normal(size=(2, 3)), rng.normal(size=12), rng.normal(size=6)
    v, w = twist[:3], twist[3:]
    tips = np.concatenate([np.r_[v + np.cross(w, q), w] for q in p])
    assert (grasp_map(p) @ W) @ twist == pytest.approx(W @ tips)


def test_grasp_map_refuses_other_shapes():
    with pytest.raises(InvalidInput, match=r"\(n, 3\)"):
        grasp_map(np.zeros((2, 4)))
