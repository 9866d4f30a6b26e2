"""The joints without a motor follow the cranks, in angle and rate."""

import mujoco
import numpy as np
import pytest

from mobius.model import JOINTS, limb_geometry
from mobius.model.passive import PASSIVE, passive_angles, passive_joints, passive_rates
from mobius.model.robot import configuration, load_model
from mobius.types import LIMBS


@pytest.fixture(scope="module")
def model():
    return load_model("full", floor=False)


def random_joints(count: int, seed: int = 0):
    """(count, 22) angles within the ranges, the five-bars on their branch."""
    from mobius.model.robot import joint_limits

    low, high = joint_limits()
    rng, found = np.random.default_rng(seed), []
    while len(found) < count:
        q = rng.uniform(low, high)
        a = np.array([j.endswith("motor_a") for j in JOINTS])
        b = np.array([j.endswith("motor_b") for j in JOINTS])
        if (q[b] - q[a] >= 0.7).all():
            found.append(q)
    return np.array(found)


def test_the_loops_of_the_compiled_model_are_closed_at_these_angles(model):
    data = mujoco.MjData(model)
    for q in random_joints(50):
        data.qpos[:] = configuration(model, q)
        for name, angle in zip(PASSIVE, passive_joints(q), strict=True):
            data.qpos[model.joint(name).qposadr[0]] = angle
        mujoco.mj_kinematics(model, data)
        for limb in LIMBS:
            gap = data.site(f"{limb}_loop_coupler").xpos - data.site(f"{limb}_loop_distal").xpos
            assert np.linalg.norm(gap) < 2e-6


def test_every_joint_of_the_model_is_driven_passive_or_a_finger_that_mirrors(model):
    names = {model.joint(i).name for i in range(model.njnt)}
    assert names == {*JOINTS, *PASSIVE, "base", "left_finger_b", "right_finger_b"}


def test_the_order_is_limb_by_limb_coupler_first():
    q = random_joints(1)[0]
    coupler, distal = passive_angles(q)
    assert PASSIVE[:4] == ("left_arm_coupler", "left_arm_distal", "right_arm_coupler",
                           "right_arm_distal")  # fmt: skip
    np.testing.assert_array_equal(passive_joints(q), np.column_stack([coupler, distal]).ravel())


def test_a_hand_computed_loop():
    """q11 = 0, q21 = 90 deg on an arm: B = (113, 0), E = (28.5, 113) mm down, out.

    |BE| = sqrt(84.5^2 + 113^2) = 141.10 mm. In the triangle B, C, E with |BC| = 142.035 and
    |EC| = 136.35 the angle at B is acos((142.035^2 + 141.10^2 - 136.35^2) / (2 * 142.035 *
    141.10)) = acos(0.53614) = 57.580 deg. The direction from B to E is atan2(113, -84.5) =
    126.79 deg, C lies to the right of it: 126.79 - 57.58 = 69.21 deg from "down".
    """
    q = np.zeros(22)
    q[JOINTS.index("left_shoulder_motor_b")] = np.pi / 2
    q[[JOINTS.index(j) for j in JOINTS if j.endswith("motor_b")]] = np.pi / 2
    assert np.degrees(passive_joints(q)[0]) == pytest.approx(69.21, abs=0.01)
    assert limb_geometry("left_arm").fivebar.L1 == 0.113


def test_rates_are_the_slopes_of_the_angles():
    rng, h = np.random.default_rng(1), 1e-6
    q, dq = random_joints(20, seed=1), rng.normal(size=(20, 22))
    slope = (passive_joints(q + h * dq) - passive_joints(q - h * dq)) / (2 * h)
    np.testing.assert_allclose(passive_rates(q, dq), slope, atol=1e-6)


def test_no_linear_mimic_comes_near():
    """The best a mimic joint could do is off by more than 0.2 rad: 4 cm at a forearm's end."""
    q = random_joints(300, seed=2)
    for k, limb in enumerate(LIMBS):
        first = 6 * k if k < 2 else 12 + 4 * (k - 2)
        cranks = np.column_stack([q[:, first + 1], q[:, first + 2], np.ones(len(q))])
        for at in (2 * k, 2 * k + 1):
            angle = passive_joints(q)[:, at]
            fit, *_ = np.linalg.lstsq(cranks, angle, rcond=None)
            assert np.abs(cranks @ fit - angle).max() > 0.2, f"{limb}: {PASSIVE[at]}"


def test_every_loop_of_the_ranges_closes_and_one_that_cannot_is_nan():
    assert np.isfinite(passive_joints(random_joints(5000, seed=3))).all()
    apart = np.zeros(22)  # a leg's cranks point away from each other: 293 mm, the links reach 278
    apart[JOINTS.index("left_hip_motor_a")] = np.pi
    assert np.isnan(passive_joints(apart)[4:6]).all()
    assert passive_joints(np.zeros((3, 5, 22))).shape == (3, 5, 8)
