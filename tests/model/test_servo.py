"""Servos from the datasheet."""

import mujoco
import numpy as np
import pytest

from mobius.model.servo import SERVOS, XM430_W350, Servo, rpm, servo_of


def test_stiffness_by_hand():
    """P = 800: 800/128 = 6.25 duty ticks a tick; 4096/2pi = 651.9 ticks/rad; of 885 full duty.

    6.25 * 651.9 / 885 = 4.6038 duty/rad, times 4.1 N m = 18.88 N m/rad.
    """
    assert Servo(XM430_W350).kp == pytest.approx(18.876, abs=0.01)


def test_a_pair_is_two():
    one, two = Servo(XM430_W350), Servo(XM430_W350, 2)
    for name in ("kp", "stall_torque", "damping", "armature", "friction"):
        assert getattr(two, name) == pytest.approx(2 * getattr(one, name))
    assert two.motor.no_load_speed == one.motor.no_load_speed


def test_fifty_rpm():
    assert rpm(50) == pytest.approx(5.236, abs=1e-3)


@pytest.mark.parametrize("name", ["left_hip_motor_a", "right_shoulder_yaw", "left_wrist_yaw"])
def test_torque_speed_line_in_mujoco(name):
    """A free joint with the target far away runs up to the no-load speed, less dry friction."""
    servo = servo_of(name)
    xml = f"""<mujoco><option timestep="0.001" integrator="implicitfast" gravity="0 0 0"/>
      <worldbody><body><joint name="j" damping="{servo.damping}" armature="{servo.armature}"/>
      <geom size="0.02" mass="0.01"/></body></worldbody>
      <actuator><position joint="j" kp="{servo.kp}" ctrlrange="-1e3 1e3"
        forcerange="-{servo.stall_torque} {servo.stall_torque}"/></actuator></mujoco>"""
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    data.ctrl[0] = 900.0
    mujoco.mj_step(model, data, 1500)
    assert data.qvel[0] == pytest.approx(servo.motor.no_load_speed, rel=1e-3)
    assert data.actuator_force[0] == pytest.approx(servo.stall_torque)
    half = 0.5 * servo.motor.no_load_speed
    assert servo.torque_limit(half) == pytest.approx(0.5 * servo.stall_torque)


def test_every_joint_has_a_servo():
    from mobius.model import JOINTS

    assert {j.split("_", 1)[1] for j in JOINTS} == set(SERVOS)
    assert all(np.isfinite(servo_of(j).kp) for j in JOINTS)
