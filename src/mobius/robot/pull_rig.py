"""A pulling machine: one hand grasps a bar and is pulled until the grasp gives (Table IX)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import mujoco
import numpy as np
from numpy.typing import NDArray

from mobius.errors import InvalidInput, UnknownName
from mobius.model.gripper import finger_tips, pinch_angle
from mobius.model.limit_surface import LimitSurface
from mobius.robot.grasp import PinchGrasp

Array = NDArray[np.float64]
Axis = Literal["x", "z"]

DIRECTION = {"x": (1.0, 0.0, 0.0), "z": (0.0, 0.0, -1.0)}
"""Pull axis of Table IX in the world: x along the bar, z down, across the groove."""
SETTLE_TICKS = 60
"""Fingers and machine come to rest so long before the sensor is tared: 0.1 s."""
SLIDE = 0.003
"""A pull along the groove ends when the spines have slid so far [m]."""
TRAVEL = 0.05
"""A pull ends after so much travel of the crosshead [m] at the latest."""


@dataclass(frozen=True)
class Pull:
    """One pull to failure."""

    peak: float
    """Greatest force that the wrist's sensor read along the pull, tared [N]."""
    drawn: float
    """The limit that this grasp had drawn for the pull's axis [N]."""
    rate: float
    """Rise of the sensor's force from half the peak to the peak [N/s]."""
    slip: float
    """Way the spines had slid when the pull ended [m]."""
    end: str
    """State of the grasp then: ``broken``, or ``slipping``."""


class PullRig:
    """The machine with a hand's model (:func:`mobius.model.hand.load_hand`) beside a bar."""

    def __init__(self, model: mujoco.MjModel, *, hand: str = "left", bar: str = "bar") -> None:
        """Find hand, bar and slides.

        Args:
            model: The hand on its slides and a bar along world x through the world's z axis.
            hand: Which hand the model holds.
            bar: Name of the bar's geom.
        """
        self.model, self.data = model, mujoco.MjData(model)
        self.grasp = PinchGrasp(model, self.data, hand=hand, bar=bar)
        self._slides = [model.joint(f"pull_{k}").qposadr[0] for k in "xyz"]
        self._servos = np.array([model.actuator(f"pull_{k}").id for k in "xyz"])
        self._gripper = model.actuator(f"{hand}_gripper").id
        self._fingers = [model.joint(f"{hand}_{k}").qposadr[0] for k in ("gripper", "finger_b")]
        self._force = int(model.sensor(f"{hand}_wrist_force").adr[0])
        self._site = model.site(f"{hand}_wrist_ft").id
        self._bar = self.grasp.bar_geom

    def pull(
        self,
        surface: LimitSurface,
        axis: Axis = "z",
        *,
        speed: float = 0.005,
        tilt: float = 0.0,
        offset: tuple[float, float] = (0.0, 0.0),
    ) -> Pull:
        """Tare, close on the bar, pull at constant crosshead speed until the grasp gives.

        Args:
            surface: What this grasp can hold.
            axis: ``x`` along the groove or ``z`` across it.
            speed: Of the crosshead [m/s], > 0.
            tilt: Angle [rad] by which the pull misses its axis, towards the other one.
            offset: Where the hand closes beside the bar's middle, along y and z [m].

        Raises:
            UnknownName: There is no such axis.
            InvalidInput: The speed is not positive, or the bar is out of reach.
        """
        if axis not in DIRECTION:
            raise UnknownName("pull axis", axis, DIRECTION)
        if not speed > 0:
            raise InvalidInput(f"PullRig.pull: expected a speed > 0 m/s, got {speed}")
        home = self.place(offset)
        other = DIRECTION["z" if axis == "x" else "x"]
        along = np.cos(tilt) * np.array(DIRECTION[axis]) + np.sin(tilt) * np.array(other)
        dt = self.model.opt.timestep
        for _ in range(SETTLE_TICKS):
            self._tick()
        tare = self._reading(along)
        if self.grasp.close(surface) != "held":
            raise InvalidInput(
                f"PullRig: the bar is {1e3 * self.grasp.offset()[0]:.0f} mm from the fingers;"
                " expected an offset of less than 12 mm"
            )
        readings = []
        for k in range(int(TRAVEL / (speed * dt))):
            self.data.ctrl[self._servos] = home + along * (speed * dt * (k + 1))
            self._tick()
            readings.append(self._reading(along) - tare)
            if not self.grasp.holds or self.grasp.slip > (SLIDE if axis == "x" else TRAVEL):
                break
        force = np.array(readings)
        top = int(np.argmax(force))
        half = int(np.argmax(force >= 0.5 * force[top]))
        return Pull(
            peak=float(force[top]),
            drawn=surface.F_along if axis == "x" else surface.F_across,
            rate=float((force[top] - force[half]) / (max(top - half, 1) * dt)),
            slip=self.grasp.slip,
            end=self.grasp.state,
        )

    def place(self, offset: tuple[float, float]) -> Array:
        """Put the fingers round the bar, not yet held; returns the crosshead's place (3,) [m]."""
        mujoco.mj_resetData(self.model, self.data)
        mujoco.mj_kinematics(self.model, self.data)
        pinch = pinch_angle(self.grasp.width)
        home = self.data.geom_xpos[self._bar] + [0.0, *offset]
        home[2] += float(finger_tips(pinch)[0, 2])  # fingers up: tips above the wrist
        self.data.qpos[self._slides], self.data.qpos[self._fingers] = home, pinch
        self.data.ctrl[self._servos], self.data.ctrl[self._gripper] = home, 0.0
        self.grasp.reset()
        return np.array(home)

    def _tick(self) -> None:
        self.grasp.step()
        mujoco.mj_step(self.model, self.data)

    def _reading(self, along: Array) -> float:
        """Force of the crosshead on the hand along a world direction, at the wrist's sensor [N].

        The sensor's sign is MuJoCo's; see :attr:`PinchGrasp.wrench_S`.
        """
        R = self.data.site_xmat[self._site].reshape(3, 3)
        f_S = self.data.sensordata[self._force : self._force + 3]
        return float(along @ (R @ f_S))
