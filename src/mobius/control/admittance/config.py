"""Parameters of the force controller, named as in ros2_controllers' admittance_controller.

Six axes x y z rx ry rz; N and m for the first three, N m and rad for the others. What that
controller has not (force gain, integrals, limits) is added under names of the same kind.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mobius.control.admittance.law import AxisGains
from mobius.errors import InvalidInput, UnknownName
from mobius.types import frozen_array

__all__ = ["AXES", "AdmittanceConfig", "FtSensor", "GravityCompensation", "from_ros"]

Array = NDArray[np.float64]

AXES = ("x", "y", "z", "rx", "ry", "rz")
"""Order of every six numbers."""
FRAMES = ("base_link", "gripper")
"""Frames whose axes the law may use: the trunk's, or those the gripper had at the start."""


@dataclass(frozen=True, eq=False)
class GravityCompensation:
    """What hangs on the sensor and is not the environment: gripper and its half of the sensor."""

    cog_pos: Array = field(default_factory=lambda: np.array([0.0, 0.0, -0.0265]))
    """CoG.pos: centre of mass (3,) from the sensor, in the sensor's axes [m]."""
    cog_force: float = 0.0
    """CoG.force: weight [N]; 0 compensates nothing."""

    def __post_init__(self) -> None:
        frozen_array(self, "cog_pos", self.cog_pos, (3,))
        if not (np.isfinite(self.cog_force) and self.cog_force >= 0):
            raise InvalidInput(
                f"GravityCompensation.cog_force: expected newtons >= 0, got {self.cog_force}"
            )


@dataclass(frozen=True, eq=False)
class FtSensor:
    """The wrist's sensor and how its readings are conditioned."""

    name: str = "wrist_ft"
    frame_id: str = "wrist_ft"
    """frame.id: the frame S the sensor speaks in."""
    sign: int = 1
    """+1 where readings are what environment and weight do to the gripper, -1 where they are
    what the wrist does to it (MuJoCo's sensors)."""
    filter_coefficient: float = 0.3
    """Share of the new reading in the exponential filter, (0, 1]; 1 filters nothing."""
    deadband: Array = field(default_factory=lambda: np.zeros(6))
    """(6,) readings smaller than this are zero, larger ones are less by it [N, N m]."""
    timeout: float = 0.010
    """A reading older than this is stale [s]."""
    tip: Array = field(default_factory=lambda: np.array([0.0, 0.0, -0.086]))
    """(3,) fingertips from the sensor, in its axes [m]; wrenches are moved there."""

    def __post_init__(self) -> None:
        if not 0 < self.filter_coefficient <= 1:
            raise InvalidInput(
                "FtSensor.filter_coefficient: expected a share in (0, 1], got"
                f" {self.filter_coefficient}"
            )
        if self.sign not in (-1, 1):
            raise InvalidInput(f"FtSensor.sign: expected 1 or -1, got {self.sign}")
        if not self.timeout > 0:
            raise InvalidInput(f"FtSensor.timeout: expected seconds > 0, got {self.timeout}")
        frozen_array(self, "deadband", self.deadband, (6,))
        frozen_array(self, "tip", self.tip, (3,))
        if (self.deadband < 0).any():
            raise InvalidInput(
                f"FtSensor.deadband: expected numbers >= 0, got {self.deadband.tolist()}"
            )


def _by_kind(linear: float, angular: float) -> Callable[[], Array]:
    """Makes (6,) of one number for x y z and one for rx ry rz."""
    return lambda: np.array([linear] * 3 + [angular] * 3)


@dataclass(frozen=True, eq=False)
class AdmittanceConfig:
    """One arm's admittance. Checked when made: what is accepted is stable in free space."""

    selected_axes: NDArray[np.bool_] = field(default_factory=lambda: np.ones(6, dtype=bool))
    """(6,) axes that comply; the others follow their position reference at limited speed."""
    mass: Array = field(default_factory=_by_kind(0.7, 0.02))
    """(6,) M [kg, kg m^2], > 0."""
    damping: Array | None = None
    """(6,) D [N s/m, N m s/rad], > 0; from ``damping_ratio`` if not given."""
    damping_ratio: Array | None = None
    """(6,) D = 2 ratio sqrt(M K), as in ROS; wants a stiffness above 0 on every selected axis.
    With neither, D is 250 N s/m and 5 N m s/rad."""
    stiffness: Array = field(default_factory=_by_kind(0.0, 0.0))
    """(6,) K [N/m, N m/rad], >= 0."""
    force_gain: Array = field(default_factory=_by_kind(1.0, 1.0))
    """(6,) K_f [-], >= 0."""
    integral_position: Array = field(default_factory=_by_kind(0.0, 0.0))
    """(6,) K_pi [N/(m s), N m/(rad s)], >= 0."""
    integral_force: Array = field(default_factory=_by_kind(0.0, 0.0))
    """(6,) K_fi [1/s], >= 0."""
    integral_max: Array = field(default_factory=_by_kind(60.0, 5.0))
    """(6,) largest integral z [N, N m]."""
    position_min: Array = field(default_factory=_by_kind(-0.15, -0.6))
    """(6,) of the command, from the pose at the start [m, rad]."""
    position_max: Array = field(default_factory=_by_kind(0.15, 0.6))
    velocity_min: Array = field(default_factory=_by_kind(-0.4, -2.0))
    """(6,) of the command [m/s, rad/s]."""
    velocity_max: Array = field(default_factory=_by_kind(0.4, 2.0))
    wrench_min: Array = field(default_factory=_by_kind(-150.0, -8.0))
    """(6,) the law never hears more than this [N, N m]; beyond it is flagged."""
    wrench_max: Array = field(default_factory=_by_kind(150.0, 8.0))
    ft_sensor: FtSensor = FtSensor()
    gravity_compensation: GravityCompensation = GravityCompensation()
    control_frame_id: str = "base_link"
    """control.frame.id: axes of the law, ``base_link`` or ``gripper`` (as it was at the start)."""
    hold_time: float = 0.02
    """Time constant of coming to rest without a wrench [s]."""
    resume_time: float = 0.2
    """Time over which the law takes over again when the wrench is back [s]."""
    D: Array = field(init=False)
    """(6,) the damping that is used, from ``damping`` or ``damping_ratio``."""

    def __post_init__(self) -> None:
        frozen_array(self, "selected_axes", self.selected_axes, (6,), np.bool_)
        for name in _NUMBERS:
            frozen_array(self, name, getattr(self, name), (6,))
        self._check_signs()
        frozen_array(self, "D", self._damping(), (6,))
        if self.control_frame_id not in FRAMES:
            raise UnknownName("control frame", self.control_frame_id, FRAMES)
        for name in ("position", "velocity", "wrench"):
            low, high = getattr(self, f"{name}_min"), getattr(self, f"{name}_max")
            bad = [AXES[i] for i in np.flatnonzero(~((low < 0) & (high > 0)))]
            if bad:
                raise InvalidInput(
                    f"AdmittanceConfig: expected {name}_min < 0 < {name}_max, got"
                    f" {low.tolist()} and {high.tolist()} ({', '.join(bad)})"
                )
        for i, axis in enumerate(AXES):
            try:
                self.axis(i)
            except InvalidInput as error:
                raise InvalidInput(f"AdmittanceConfig, axis {axis}: {error}") from None

    def _check_signs(self) -> None:
        if (self.mass <= 0).any():
            raise InvalidInput(
                f"AdmittanceConfig.mass: expected numbers > 0, got {self.mass.tolist()}"
            )
        if (self.integral_max <= 0).any():
            raise InvalidInput("AdmittanceConfig.integral_max: expected numbers > 0")
        for name in ("hold_time", "resume_time"):
            if not getattr(self, name) > 0:
                raise InvalidInput(f"AdmittanceConfig.{name}: expected seconds > 0")

    def _damping(self) -> Array:
        if self.damping is not None and self.damping_ratio is not None:
            raise InvalidInput(
                "AdmittanceConfig: expected damping or damping_ratio, got both; leave one out"
            )
        if self.damping_ratio is None:
            if self.damping is None:
                return np.array([250.0] * 3 + [5.0] * 3)
            frozen_array(self, "damping", self.damping, (6,))
            return self.damping
        frozen_array(self, "damping_ratio", self.damping_ratio, (6,))
        free = self.selected_axes & (self.stiffness <= 0)
        if free.any():
            raise InvalidInput(
                "AdmittanceConfig.damping_ratio: with stiffness 0 it means no damping at all"
                f" ({', '.join(AXES[i] for i in np.flatnonzero(free))}); give damping [N s/m]"
            )
        D = 2.0 * self.damping_ratio * np.sqrt(self.mass * self.stiffness)
        return np.where(self.selected_axes, D, np.maximum(D, 1.0))

    def axis(self, index: int) -> AxisGains:
        """The gains of one axis, as the law and the governor know them."""
        return AxisGains(*(float(v) for v in self.gains[index]))

    @property
    def gains(self) -> Array:
        """(6, 6) a row an axis: M, D, K, K_f, K_fi, K_pi."""
        return np.column_stack(
            [
                self.mass,
                self.D,
                self.stiffness,
                self.force_gain,
                self.integral_force,
                self.integral_position,
            ]
        )


_NUMBERS = (
    "mass", "stiffness", "force_gain", "integral_position", "integral_force", "integral_max",
    "position_min", "position_max", "velocity_min", "velocity_max", "wrench_min", "wrench_max",
)  # fmt: skip
_ROS = {
    "admittance.selected_axes": "selected_axes",
    "admittance.mass": "mass",
    "admittance.damping_ratio": "damping_ratio",
    "admittance.damping": "damping",
    "admittance.stiffness": "stiffness",
    "control.frame.id": "control_frame_id",
    "ft_sensor.name": "ft_sensor.name",
    "ft_sensor.frame.id": "ft_sensor.frame_id",
    "ft_sensor.filter_coefficient": "ft_sensor.filter_coefficient",
    "gravity_compensation.CoG.pos": "gravity_compensation.cog_pos",
    "gravity_compensation.CoG.force": "gravity_compensation.cog_force",
}
"""Names of admittance_controller's parameters -> ours."""


def from_ros(parameters: Mapping[str, Any]) -> AdmittanceConfig:
    """A configuration from the dotted parameters of an admittance_controller.

    Args:
        parameters: E.g. ``{"admittance.mass": [...], "ft_sensor.frame.id": "wrist"}``; our own
            parameters go by their names here (``force_gain``, ``ft_sensor.timeout``).

    Raises:
        UnknownName: A parameter that means nothing here.
        InvalidInput: A value that does not fit.
    """
    own = {f.name for f in fields(AdmittanceConfig) if f.init}
    own -= {"ft_sensor", "gravity_compensation"}
    own |= {f"ft_sensor.{f.name}" for f in fields(FtSensor)}
    top: dict[str, Any] = {}
    nested: dict[str, dict[str, Any]] = {"ft_sensor": {}, "gravity_compensation": {}}
    for name, value in parameters.items():
        ours = _ROS.get(name, name)
        if ours not in own and name not in _ROS:
            raise UnknownName("admittance parameter", name, {*_ROS, *own})
        group, _, key = ours.partition(".")
        (nested[group] if key else top)[key or group] = value
    return AdmittanceConfig(
        ft_sensor=FtSensor(**nested["ft_sensor"]),
        gravity_compensation=GravityCompensation(**nested["gravity_compensation"]),
        **top,
    )
