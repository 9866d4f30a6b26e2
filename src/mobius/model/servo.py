"""Dynamixel position servos, from the datasheet to MuJoCo actuator parameters.

A position-controlled Dynamixel turns the position error into a PWM duty, and a DC motor
under constant voltage has a straight torque-speed line. Both are exact in MuJoCo as

    tau = clip(kp (q_target - q), +-tau_stall) - (tau_stall / w_noload) dq

so the torque limit is ``forcerange`` and the back-EMF is joint ``damping``. Nothing is tuned.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

TICKS_PER_RAD = 4096 / (2 * np.pi)
"""Encoder resolution, ROBOTIS e-manual."""
PWM_LIMIT = 885.0
"""Register 36: full duty."""
P_GAIN_DEFAULT = 800.0
"""Register 84 as delivered; the controller multiplies by P/128."""


@dataclass(frozen=True)
class Motor:
    """One motor at its supply voltage."""

    name: str
    stall_torque: float
    """[N m] at 12 V, e-manual."""
    no_load_speed: float
    """[rad/s] at 12 V, e-manual."""
    armature: float
    """Rotor inertia seen at the output [kg m^2]."""
    friction: float
    """Dry friction at the output [N m]."""


def rpm(value: float) -> float:
    """Revolutions per minute as rad/s."""
    return value * 2 * np.pi / 60


XM430_W350 = Motor("XM430-W350", 4.1, rpm(46), armature=0.045, friction=0.03)
"""E-manual; armature and friction as identified for the same motor in menagerie's OP3."""

XM540_LEG = Motor("XM540 leg drive", 10.6, rpm(50), armature=0.14, friction=0.08)
"""Leg drive: stall torque of the XM540-W270 (e-manual), speed limit of Table I (50 rpm).

The paper prints neither type nor voltage, and no single XM540 at 12 V has both numbers.
Armature as in public models of the XM540-W270; friction scaled from the XM430 with torque.
"""


@dataclass(frozen=True)
class Servo:
    """``count`` motors on one shaft, in position control."""

    motor: Motor
    count: int = 1
    p_gain: float = P_GAIN_DEFAULT

    @property
    def kp(self) -> float:
        """Stiffness [N m/rad]: P/128 duty ticks per encoder tick, full duty = stall torque."""
        duty_per_rad = self.p_gain / 128 * TICKS_PER_RAD / PWM_LIMIT
        return self.count * duty_per_rad * self.motor.stall_torque

    @property
    def stall_torque(self) -> float:
        """[N m]."""
        return self.count * self.motor.stall_torque

    @property
    def damping(self) -> float:
        """Slope of the torque-speed line [N m s/rad]."""
        return self.stall_torque / self.motor.no_load_speed

    @property
    def armature(self) -> float:
        """[kg m^2]."""
        return self.count * self.motor.armature

    @property
    def friction(self) -> float:
        """[N m]."""
        return self.count * self.motor.friction

    def torque_limit(self, speed: float) -> float:
        """Largest torque [N m] in the direction of ``speed`` [rad/s]."""
        return self.stall_torque - self.damping * abs(speed)


GRIPPER_MOTOR = Motor("GOAT linear actuator", 2.2, 2.5, armature=0.002, friction=0.02)
"""[A] L12-class actuator: 40 N at a 55 mm finger, 0.9 rad in about 0.4 s."""

SERVOS: dict[str, Servo] = {
    "shoulder_yaw": Servo(XM430_W350, 2),
    "shoulder_motor_a": Servo(XM430_W350, 2),
    "shoulder_motor_b": Servo(XM430_W350, 2),
    "wrist_pitch": Servo(XM430_W350),
    "wrist_roll": Servo(XM430_W350),
    "wrist_yaw": Servo(XM430_W350),
    "hip_yaw": Servo(XM430_W350, 2),
    "hip_motor_a": Servo(XM540_LEG),
    "hip_motor_b": Servo(XM540_LEG),
    "ankle_pitch": Servo(XM540_LEG),
    "gripper": Servo(GRIPPER_MOTOR, p_gain=1600.0),
}
"""Servo of every joint by its name without the side."""


def servo_of(joint: str) -> Servo:
    """The servo of a joint of JOINTS, e.g. ``left_hip_yaw``."""
    return SERVOS[joint.split("_", 1)[1]]
