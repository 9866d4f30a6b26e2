"""All devices of one run: perfect frames in, realistic frames out."""

from __future__ import annotations

import numpy as np

from mobius.errors import InvalidInput
from mobius.geometry import rotate
from mobius.sense.noise import CurrentNoise, EncoderNoise, ImuNoise, WrenchNoise, scaled
from mobius.sense.vio import VioModel, VioParameters
from mobius.types import SensorFrame

LOST_RATE = 2.0
"""A camera that turns faster than this loses its track [rad/s]."""
LOST_UP = -0.25
"""So does one that looks at the floor: its axis points below the horizon by this share."""
LOST_S = 0.25
"""It finds it again this long after [s]."""
_BACK = np.array([0.0, 0.0, 1.0])
"""Axis of the camera in the trunk frame (mjcf README)."""
FRAME_PERIOD = 1 / 300
"""Time that the first frame is taken to stand for [s]."""


class Senses:
    """One robot's devices. Two with one seed, fed alike, say the same to the last bit.

    ``randomised`` draws the camera's latency, drift and drop-outs per run; without it the
    camera is the nominal one. The noise is there in both cases, ``noise`` times as large;
    resolution, latency and drop-outs stay.
    """

    def __init__(
        self, seed: int, randomised: bool = True, *, noise: float = 1.0, can_lose: bool = False
    ) -> None:
        """One robot's devices.

        Args:
            seed: Of all draws.
            randomised: Draw the camera.
            noise: Factor on all noise.
            can_lose: The camera loses its track while the trunk turns fast
                (:data:`LOST_RATE`) or the camera, which looks out of the back, faces the floor
                (:data:`LOST_UP`), and for :data:`LOST_S` after. Robots that only walk keep it.
        """
        if not noise >= 0.0:
            raise InvalidInput(f"Senses: expected a noise factor >= 0, got {noise}")
        imu, encoder, current, wrench, camera = np.random.default_rng(seed).spawn(5)
        self.imu = scaled(ImuNoise, imu, noise)
        self.encoder = scaled(EncoderNoise, encoder, noise)
        self.current = scaled(CurrentNoise, current, noise)
        self.wrench = scaled(WrenchNoise, wrench, noise)
        parameters = VioParameters.draw(camera) if randomised else VioParameters()
        self.vio = VioModel(parameters.scaled(noise), camera)
        self._can_lose, self._lost_until = can_lose, -np.inf
        self._stamp: float | None = None

    def corrupt(self, frame: SensorFrame) -> SensorFrame:
        """The frame as real devices would give it. Frames come in the order of their stamps."""
        dt = FRAME_PERIOD if self._stamp is None else frame.stamp - self._stamp
        if dt < 0.0:
            raise InvalidInput(
                f"Senses.corrupt: expected a stamp after {self._stamp:.4f} s, got"
                f" {frame.stamp:.4f} s; make new Senses(seed) for a new run"
            )
        self._stamp = frame.stamp
        q, dq = self.encoder.corrupt(frame.q, frame.dq)
        gyro, accel = self.imu.corrupt(frame.gyro_I, frame.accel_I, dt)
        if self._can_lose:
            self.vio.blind = self._is_lost(frame)
        return SensorFrame(
            stamp=frame.stamp,
            q=q,
            dq=dq,
            torque=self.current.corrupt(frame.torque),
            wrench_S=self.wrench.corrupt(frame.wrench_S, dt),
            gyro_I=gyro,
            accel_I=accel,
            vio=None if frame.vio is None else self.vio.corrupt(frame.vio, frame.stamp),
            wrench_age=frame.wrench_age,
        )

    def _is_lost(self, frame: SensorFrame) -> bool:
        """Whether the camera sees nothing it could track."""
        fast = float(np.linalg.norm(frame.gyro_I)) > LOST_RATE
        up = 1.0 if frame.vio is None else float(rotate(frame.vio.q, _BACK)[2])
        if fast or up < LOST_UP:
            self._lost_until = frame.stamp + LOST_S
        return frame.stamp <= self._lost_until
