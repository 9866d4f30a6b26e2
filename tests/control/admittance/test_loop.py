"""Both arms, from wrenches to joint targets."""

import numpy as np
import pytest

from mobius.control.admittance import ForceLoop, mobius_config
from mobius.control.admittance.arms import arms_ik, arms_pose, arms_rotation
from mobius.errors import InvalidInput
from mobius.model.arm import gripper_pose
from mobius.model.dimensions import limb_geometry
from mobius.model.robot import keyframe_joints
from mobius.types import SensorFrame

Q, TARGETS = keyframe_joints("crawl")
LEVEL = np.array([1.0, 0.0, 0.0, 0.0])


def frame(wrench: np.ndarray | float = 0.0) -> SensorFrame:
    still = np.zeros(22)
    wrench = np.broadcast_to(wrench, (2, 6))
    return SensorFrame(0.0, TARGETS, still, still, wrench, np.zeros(3), np.zeros(3))


def unloaded() -> ForceLoop:
    config = mobius_config()
    loop = ForceLoop(config, config)
    loop.start(TARGETS)
    return loop


def free(loop: ForceLoop) -> np.ndarray:
    """(2, 6) readings with nothing touched: the weight of the tool alone."""
    up_S, _ = loop.frames(frame(), LEVEL)
    f = 4.5126 * up_S  # the wrist holds it: sign -1
    return np.concatenate([f, np.cross([0.0, 0.0, -0.0094022], f)], axis=1)


def test_both_arms_by_mirror_are_each_arm_by_itself():
    rng = np.random.default_rng(0)
    for _ in range(20):
        q = np.array([-0.1, -0.1, 2.0, 0.1, 0.0, 0.2]) + rng.uniform(-0.4, 0.4, (2, 6))
        p, R = arms_pose(q)
        for k, limb in enumerate(("left_arm", "right_arm")):
            p_one, R_one = gripper_pose(limb_geometry(limb), q[k])
            np.testing.assert_allclose(p[k], p_one, atol=1e-12)
            np.testing.assert_allclose(R[k], R_one, atol=1e-12)
        np.testing.assert_allclose(arms_rotation(q), R, atol=1e-12)
        np.testing.assert_allclose(arms_ik(p, R), q, atol=1e-9)


def test_it_takes_over_without_a_jump_and_stays_where_nothing_pushes():
    loop = unloaded()
    reading = free(loop)
    for _ in range(100):
        out = loop.step(frame(reading), LEVEL)
    np.testing.assert_allclose(out.command.q, TARGETS, atol=1e-6)
    assert not out.unreachable.any()


def test_pushed_up_the_fingertips_go_up_and_both_arms_alike():
    loop = unloaded()
    push = np.array([0.0, 0.0, 6.0])  # by the environment, in B
    R_CS = loop.frames(frame(), LEVEL)[1]
    f_S = np.einsum("kji,j->ki", R_CS, push)
    tip = np.array([0.0, 0.0, -0.086])
    reading = free(loop) - np.concatenate([f_S, np.cross(tip, f_S)], axis=1)
    for _ in range(150):
        out = loop.step(frame(reading), LEVEL)
    p, R = arms_pose(out.command.q[:12].reshape(2, 6))
    moved = p - loop.p0_B
    np.testing.assert_allclose(out.wrenches.wrench_C[:, :3], [push, push], atol=1e-3)
    np.testing.assert_allclose(moved[:, :2], 0.0, atol=1e-4)
    assert moved[0, 2] == pytest.approx(moved[1, 2]) and moved[0, 2] > 0.01
    np.testing.assert_allclose(R, loop.R0_BG, atol=1e-4)
    np.testing.assert_array_equal(out.command.q[12:], TARGETS[12:])


def test_a_tared_load_counts_as_none():
    loop = unloaded()
    reading = free(loop) + 3.0
    loop.tare(frame(reading), LEVEL)
    for _ in range(100):
        out = loop.step(frame(reading), LEVEL)
    np.testing.assert_allclose(out.command.q, TARGETS, atol=1e-9)


def test_what_cannot_be_reached_keeps_the_last_targets_and_is_told():
    config = mobius_config(position_max=[2.0] * 6, position_min=[-2.0] * 6)
    loop = ForceLoop(config, config)
    loop.start(TARGETS)
    loop.wrench_reference[0, 2] = -30.0  # the left arm alone: go up until the wrench is there
    told, last = [], TARGETS
    reading = free(loop)
    for _ in range(1500):
        out = loop.step(frame(reading), LEVEL)
        told.append(out.unreachable.tolist())
        assert np.isfinite(out.command.q).all()
        assert np.abs(out.command.q - last).max() < 0.08
        last = out.command.q
    assert told[-1] == [True, False]
    x = arms_pose(last[:12].reshape(2, 6))[0][0] - loop.p0_B[0]
    assert x[2] == pytest.approx(loop.law.state[0, 2, 0], abs=2e-3)


def test_out_of_reach_the_integral_does_not_wind_up():
    config = mobius_config(
        position_max=[2.0] * 6, position_min=[-2.0] * 6, integral_force=[0.5] * 3 + [0.0] * 3
    )
    loop = ForceLoop(config, config)
    loop.start(TARGETS)
    loop.wrench_reference[0, 2] = -30.0
    reading = free(loop)
    z = []
    for _ in range(1200):
        out = loop.step(frame(reading), LEVEL)
        z.append(loop.law.state[0, 2, 2] if out.unreachable[0] else 0.0)
    stuck = np.flatnonzero(z)
    assert len(stuck) > 300  # 15 N/s would be 15 N and more; now and then a tick is in reach
    assert z[stuck[-1]] == pytest.approx(z[stuck[0]], abs=1.0)


def test_a_silent_sensor_holds_its_arm_only():
    loop = unloaded()
    reading = free(loop)
    reading[:, 2] -= 5.0
    silent = reading.copy()
    silent[0] = np.nan
    for _ in range(60):
        out = loop.step(frame(reading), LEVEL)
    for _ in range(30):
        out = loop.step(frame(reading), LEVEL, wrench_S=silent)
    assert out.motion.holding.tolist() == [True, False]
    assert abs(out.motion.v[0, 2]) < 1e-3 < abs(out.motion.v[1, 2])


def test_it_wants_to_be_started():
    config = mobius_config()
    with pytest.raises(InvalidInput, match=r"call start\(targets\) first"):
        ForceLoop(config, config).step(frame(), LEVEL)
    with pytest.raises(InvalidInput, match=r"\(22,\)"):
        ForceLoop(config, config).start(np.zeros(12))
