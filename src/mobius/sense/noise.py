"""How the robot's own devices differ from perfect ones: IMU, encoders, currents, wrists.

Each device owns its seeded generator, draws what is fixed for a run when it is built, and
turns one perfect reading into one real one with ``corrupt``.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from math import sqrt
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from mobius.types import NUM_JOINTS

Array = NDArray[np.float64]

_EXACT = ("rng", "tick", "speed_unit", "force_range", "torque_range")
"""Fields that are no noise: the generator, resolutions and ranges."""
_Device = TypeVar("_Device", "ImuNoise", "EncoderNoise", "CurrentNoise", "WrenchNoise")


def scaled(device: type[_Device], rng: np.random.Generator, factor: float) -> _Device:
    """A device whose every spread, noise and drift is ``factor`` times the usual one."""
    usual = {f.name: f.default for f in fields(device) if f.name not in _EXACT}
    return device(rng, **{name: factor * value for name, value in usual.items()})  # type: ignore[arg-type, operator]


@dataclass
class ImuNoise:
    """A BMI055-class gyroscope and accelerometer, its zero taken at power-up.

    The datasheet's 0.014 deg/s and 150 ug per root hertz are 0.003 rad/s and 0.018 m/s^2
    over 150 Hz; the white noise below is the project's, close to it.
    """

    rng: np.random.Generator
    gyro: float = 0.002
    """White noise [rad/s]."""
    accel: float = 0.03
    """White noise [m/s^2]."""
    gyro_bias: float = 0.003
    """Spread of what calibration at power-up leaves [rad/s]."""
    accel_bias: float = 0.03
    """Spread of what calibration leaves [m/s^2]."""
    gyro_walk: float = 5e-5
    """Random walk of the bias [rad/s/sqrt(s)]."""
    accel_walk: float = 5e-4
    """Random walk of the bias [m/s^2/sqrt(s)]."""

    def __post_init__(self) -> None:
        self._white = np.repeat([self.gyro, self.accel], 3)
        self._walk = np.repeat([self.gyro_walk, self.accel_walk], 3)
        spread = np.repeat([self.gyro_bias, self.accel_bias], 3)
        self.bias: Array = spread * self.rng.standard_normal(6)
        """(6,) gyroscope [rad/s], accelerometer [m/s^2]."""

    def corrupt(self, gyro_I: Array, accel_I: Array, dt: float) -> tuple[Array, Array]:
        """Rates (3,) [rad/s] and specific force (3,) [m/s^2] as read ``dt`` [s] after the last."""
        draw = self.rng.standard_normal((2, 6))
        self.bias = self.bias + (self._walk * sqrt(dt)) * draw[0]
        error = self.bias + self._white * draw[1]
        return gyro_I + error[:3], accel_I + error[3:]


@dataclass
class EncoderNoise:
    """Dynamixel encoders: a tick is 1/4096 turn, a unit of speed 0.229 rpm (e-manual)."""

    rng: np.random.Generator
    tick: float = 2 * np.pi / 4096
    """Resolution of the angle [rad]."""
    speed_unit: float = 0.229 * 2 * np.pi / 60
    """Resolution of the rate [rad/s]."""
    speed: float = 0.01
    """White noise of the rate [rad/s]."""
    zero: float = 0.0015
    """Spread of the joints' zero: one tick of homing [rad]."""

    def __post_init__(self) -> None:
        self.offset: Array = self.zero * self.rng.standard_normal(NUM_JOINTS)
        """(22,) error of each joint's zero [rad]."""

    def corrupt(self, q: Array, dq: Array) -> tuple[Array, Array]:
        """Angles (22,) [rad] and rates (22,) [rad/s] as read."""
        noisy = dq + self.speed * self.rng.standard_normal(NUM_JOINTS)
        return (
            self.tick * np.rint((q + self.offset) / self.tick),
            self.speed_unit * np.rint(noisy / self.speed_unit),
        )


@dataclass
class CurrentNoise:
    """Torque from motor current: a torque constant that is a little off, and noise."""

    rng: np.random.Generator
    gain: float = 0.05
    """Spread of the torque constant, relative."""
    white: float = 0.05
    """White noise [N m]."""

    def __post_init__(self) -> None:
        self.factor: Array = 1.0 + self.gain * self.rng.standard_normal(NUM_JOINTS)
        """(22,) torque read per torque given."""

    def corrupt(self, torque: Array) -> Array:
        """Torques (22,) [N m] as read."""
        return torque * self.factor + self.white * self.rng.standard_normal(NUM_JOINTS)


@dataclass
class WrenchNoise:
    """The wrists' six-axis sensors, tared at the start."""

    rng: np.random.Generator
    force: float = 0.15
    """White noise [N]."""
    torque: float = 0.005
    """White noise [N m]."""
    force_drift: float = 0.1
    """Spread of the zero after one minute [N]; a random walk."""
    torque_drift: float = 0.003
    """Spread of the zero after one minute [N m]."""
    force_range: float = 500.0
    """Largest reading [N]."""
    torque_range: float = 10.0
    """Largest reading [N m]."""

    def __post_init__(self) -> None:
        self._white = np.repeat([self.force, self.torque], 3)
        self._walk = np.repeat([self.force_drift, self.torque_drift], 3) / sqrt(60.0)
        self._range = np.repeat([self.force_range, self.torque_range], 3)
        self.bias: Array = np.zeros((2, 6))
        """(2, 6) zero of the left and right sensor [N, N m]."""

    def corrupt(self, wrench_S: Array, dt: float) -> Array:
        """Wrenches (2, 6) [N, N m] as read ``dt`` [s] after the last."""
        draw = self.rng.standard_normal((2, 2, 6))
        self.bias = self.bias + (self._walk * sqrt(dt)) * draw[0]
        noisy = wrench_S + self.bias + self._white * draw[1]
        return np.minimum(np.maximum(noisy, -self._range), self._range)
