"""Frames, taring, filter and drop-outs of the wrists' wrenches."""

import mujoco
import numpy as np
import pytest

from mobius.control.admittance import (
    AdmittanceConfig,
    ForceLoop,
    FtSensor,
    GravityCompensation,
    WrenchConditioner,
    mobius_config,
)
from mobius.errors import InvalidInput
from mobius.geometry import exp_so3
from mobius.model.joints import JOINTS
from mobius.model.robot import keyframe, load_spec
from mobius.types import SensorFrame

UP = np.array([[0.0, 0.0, 1.0]])
SAME = np.eye(3)[None]


def conditioner(**sensor) -> WrenchConditioner:
    tool = sensor.pop("tool", GravityCompensation())
    sensor = {"filter_coefficient": 1.0, "tip": np.zeros(3), **sensor}
    return WrenchConditioner(
        [AdmittanceConfig(ft_sensor=FtSensor(**sensor), gravity_compensation=tool)]
    )


def test_a_force_at_the_sensor_is_a_moment_at_the_tip_by_hand():
    """f = (0, 3, 0) N at the sensor, tip 0.1 m below: tau = -(0, 0, -0.1) x f = (-0.3, 0, 0)."""
    c = conditioner(tip=[0.0, 0.0, -0.1])
    out = c.update(np.array([[0.0, 3.0, 0.0, 0.0, 0.0, 0.0]]), UP, SAME)
    np.testing.assert_allclose(out.wrench_C, [[0.0, 3.0, 0.0, -0.3, 0.0, 0.0]])


def test_a_force_at_the_tip_has_no_moment_there_in_any_axes():
    tip, R = np.array([0.01, -0.02, -0.086]), exp_so3([0.3, -0.5, 0.9])
    f = np.array([3.0, -2.0, 5.0])
    reading = np.concatenate([f, np.cross(tip, f)])[None]
    out = conditioner(tip=tip).update(reading, UP, R[None])
    np.testing.assert_allclose(out.wrench_C[0], [*(R @ f), 0, 0, 0], atol=1e-12)


@pytest.mark.parametrize("sign", [1, -1])
def test_the_tools_weight_vanishes_however_the_wrist_is_turned(sign):
    cog, weight = np.array([0.004, -0.002, -0.03]), 4.5
    c = conditioner(sign=sign, tool=GravityCompensation(cog, weight))
    for turn in ([0, 0, 0], [1.0, 0.2, 0], [0, -2.0, 0.4]):
        up = exp_so3(turn)[2]
        f = -weight * up
        reading = sign * np.concatenate([f, np.cross(cog, f)])[None]
        out = c.update(reading, up[None], SAME)
        np.testing.assert_allclose(out.wrench_C, 0.0, atol=1e-12)


def test_a_tared_zero_stays_in_the_sensor_and_a_tared_load_in_the_axes_of_the_law():
    R = exp_so3([0.0, 0.0, np.pi / 2])[None]  # the sensor turned by 90 degrees
    zero = np.array([[1.0, 0, 0, 0, 0, 0.1]])
    c = conditioner()
    c.tare_sensor(np.repeat(zero[None], 5, axis=0), UP)
    for turn in (SAME, R):
        np.testing.assert_allclose(c.update(zero, UP, turn).wrench_C, 0.0, atol=1e-12)
    hanging = np.array([[0.0, 0.0, 49.0, 0, 0, 0]])
    c.tare_load(hanging + zero, UP, SAME)
    turned = np.array([[0.0, 0.0, 49.0, 0, 0, 0]])  # about z the load reads the same
    np.testing.assert_allclose(c.update(turned + zero, UP, R).wrench_C, 0.0, atol=1e-12)


def test_taring_refuses_a_silent_sensor():
    with pytest.raises(InvalidInput, match="NaN"):
        conditioner().tare_sensor(np.full((1, 6), np.nan), UP)


def test_the_filter_by_hand_and_the_first_reading_at_once():
    c = conditioner(filter_coefficient=0.25)
    step = np.array([[8.0, 0, 0, 0, 0, 0]])
    assert c.update(step, UP, SAME).wrench_C[0, 0] == 8.0
    assert c.update(0 * step, UP, SAME).wrench_C[0, 0] == pytest.approx(6.0)
    assert c.update(0 * step, UP, SAME).wrench_C[0, 0] == pytest.approx(4.5)


def test_the_deadband_is_continuous():
    c = conditioner(deadband=[1.0] * 6)
    wrenches = np.zeros((1, 6))
    out = []
    for f in np.linspace(-3, 3, 601):
        wrenches[0, 0] = f
        out.append(c.update(wrenches, UP, SAME).wrench_C[0, 0])
    assert np.abs(np.diff(out)).max() < 0.0101
    assert out[300] == 0.0 and out[-1] == pytest.approx(2.0)


@pytest.mark.parametrize("lost", ["nan", "old"])
def test_a_lost_reading_leaves_the_last_result_and_is_marked(lost):
    c = conditioner()
    good = np.arange(1.0, 7.0)[None]
    c.update(good, UP, SAME)
    bad = np.full((1, 6), np.nan) if lost == "nan" else 100 * good
    out = c.update(bad, UP, SAME, age=0.0 if lost == "nan" else 0.011)
    assert not out.fresh.any()
    np.testing.assert_array_equal(out.wrench_C, c.update(good, UP, SAME).wrench_C)


def test_more_than_the_limits_is_clipped_and_told():
    c = conditioner()
    out = c.update(np.array([[0.0, 0.0, -1000.0, 0, 0, 0]]), UP, SAME)
    assert out.wrench_C[0, 2] == -150.0
    assert out.clipped[0].tolist() == [False, False, True, False, False, False]


def test_one_wild_reading_is_one_reading_at_the_limit():
    """150 N, of which the filter lets 30 % through, gone within a few ticks."""
    c = conditioner(filter_coefficient=0.3)
    quiet, wild = np.zeros((1, 6)), np.zeros((1, 6))
    wild[0, 2] = 1e30
    c.update(quiet, UP, SAME)
    assert c.update(wild, UP, SAME).wrench_C[0, 2] == pytest.approx(45.0)
    for _ in range(20):
        out = c.update(quiet, UP, SAME)
    assert out.wrench_C[0, 2] < 0.1


def test_frames_that_are_no_numbers_lose_the_reading_and_nothing_else():
    c = conditioner()
    good = np.arange(1.0, 7.0)[None]
    c.update(good, UP, SAME)
    for up, R in ((np.nan * UP, SAME), (UP, np.nan * SAME)):
        out = c.update(good, up, R)
        assert not out.fresh.any()
        np.testing.assert_array_equal(out.wrench_C, good)
        assert c.update(good, UP, SAME).fresh.all()


def test_a_wrong_number_of_wrenches_is_told():
    with pytest.raises(InvalidInput, match=r"expected shape \(1, 6\), a row a gripper"):
        conditioner().update(np.zeros((2, 6)), UP, SAME)


def test_the_simulated_robots_wrists_read_what_is_done_to_the_grippers():
    """In MuJoCo: trunk fixed in the air, nothing touched: zero; then 5 N up, then 3 N back, at
    each fingertip, read as such in the trunk's axes."""
    spec = load_spec("full")
    spec.delete(spec.joint("base"))
    for key in list(spec.keys):
        spec.delete(key)
    model = spec.compile()
    model.opt.timestep = 1 / 600
    data = mujoco.MjData(model)
    qpos, ctrl = keyframe("crawl")
    data.qpos[:], data.ctrl[:] = qpos[7:], ctrl
    joints = [int(model.joint(j).qposadr[0]) for j in JOINTS]
    loop = ForceLoop(mobius_config(), mobius_config())
    loop.start(ctrl)
    tips = [model.site(f"{s}_arm_tip").id for s in ("left", "right")]
    bodies = [model.body(f"{s}_arm_gripper_base").id for s in ("left", "right")]
    adr = [int(model.sensor(f"{s}_wrist_force").adr[0]) for s in ("left", "right")]
    for force in ([0.0, 0.0, 0.0], [0.0, 0.0, 5.0], [-3.0, 0.0, 0.0]):
        for _ in range(900):
            for site, body in zip(tips, bodies, strict=True):
                lever = data.site_xpos[site] - data.xipos[body]
                data.xfrc_applied[body] = [*force, *np.cross(lever, force)]
            mujoco.mj_step(model, data)
        q = data.qpos[joints]
        wrench = np.array([data.sensordata[a : a + 6] for a in adr])
        up_S, R_CS = loop.frames(frame_of(q, wrench), [1.0, 0, 0, 0])
        loop.wrench.reset()
        out = loop.wrench.update(wrench, up_S, R_CS).wrench_C
        np.testing.assert_allclose(out[:, :3], [force, force], atol=0.15)
        np.testing.assert_allclose(out[:, 3:], 0.0, atol=0.02)


def frame_of(q: np.ndarray, wrench: np.ndarray) -> SensorFrame:
    still = np.zeros(22)
    return SensorFrame(0.0, q, still, still, wrench, np.zeros(3), np.array([0, 0, 9.81]))
