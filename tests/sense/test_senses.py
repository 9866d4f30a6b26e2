"""One bundle of devices a run: reproducible, and a real reading for every perfect one."""

from dataclasses import replace

import numpy as np
import pytest

from mobius.errors import InvalidInput
from mobius.geometry import rpy_to_quat
from mobius.sense import Senses
from mobius.types import Pose, SensorFrame


def frame(k: int, *, vio: bool = True) -> SensorFrame:
    pose = Pose(p=np.array([0.001 * k, 0.0, 0.3]), q=rpy_to_quat(0.0, 0.0, 0.0))
    return SensorFrame(
        stamp=k / 300,
        q=np.linspace(-1, 1, 22),
        dq=np.zeros(22),
        torque=np.ones(22),
        wrench_S=np.zeros((2, 6)),
        gyro_I=np.zeros(3),
        accel_I=np.array([0.0, 0.0, 9.81]),
        vio=pose if vio and k % 3 != 1 else None,
    )


FIELDS = ("q", "dq", "torque", "wrench_S", "gyro_I", "accel_I")


def test_equal_seeds_say_the_same_to_the_last_bit():
    a, b = Senses(4), Senses(4)
    for k in range(300):
        x, y = a.corrupt(frame(k)), b.corrupt(frame(k))
        assert all((getattr(x, f) == getattr(y, f)).all() for f in FIELDS)
        assert (x.vio is None) == (y.vio is None)
        if x.vio is not None and y.vio is not None:
            assert (x.vio.p == y.vio.p).all() and (x.vio.q == y.vio.q).all()


def test_other_seeds_say_something_else():
    x, y = Senses(4).corrupt(frame(0)), Senses(5).corrupt(frame(0))
    for f in ("torque", "wrench_S", "gyro_I", "accel_I"):
        assert (getattr(x, f) != getattr(y, f)).all()


def test_every_reading_is_near_the_truth_but_not_the_truth():
    true, said = frame(0), Senses(0).corrupt(frame(0))
    bounds = dict(q=0.01, dq=0.1, torque=0.5, wrench_S=1.0, gyro_I=0.05, accel_I=0.5)
    for f, bound in bounds.items():
        error = np.abs(getattr(said, f) - getattr(true, f))
        assert 0.0 < error.max() < bound


def test_a_camera_that_did_not_tick_says_nothing():
    senses = Senses(0)
    assert senses.corrupt(frame(0, vio=False)).vio is None
    assert senses.corrupt(frame(1, vio=False)).vio is None


def test_only_the_camera_depends_on_randomised():
    nominal, drawn = Senses(0, randomised=False), Senses(0)
    x, y = nominal.corrupt(frame(0)), drawn.corrupt(frame(0))
    assert all((getattr(x, f) == getattr(y, f)).all() for f in FIELDS)
    assert nominal.vio.parameters.scale == 0.0 and drawn.vio.parameters.scale != 0.0


def test_frames_that_run_backwards_are_refused():
    senses = Senses(0)
    senses.corrupt(frame(5))
    with pytest.raises(InvalidInput, match=r"got 0\.0033 s; make new Senses"):
        senses.corrupt(frame(1))


def test_noise_is_scaled_and_can_be_turned_off():
    exact, usual, loud = (Senses(3, randomised=False, noise=k) for k in (0.0, 1.0, 4.0))
    assert loud.imu.gyro == 4.0 * usual.imu.gyro and loud.encoder.zero == 4.0 * usual.encoder.zero
    assert loud.encoder.tick == usual.encoder.tick and loud.wrench.force_range == 500.0
    assert loud.vio.parameters.drift == 4.0 * usual.vio.parameters.drift
    assert loud.vio.parameters.latency == usual.vio.parameters.latency
    said = exact.corrupt(frame(0))
    np.testing.assert_array_equal(said.gyro_I, frame(0).gyro_I)
    np.testing.assert_array_equal(said.torque, frame(0).torque)


def test_a_negative_noise_is_refused():
    with pytest.raises(InvalidInput, match=">= 0"):
        Senses(0, noise=-1.0)


def turned(k: int, *, rate: float = 0.0, roll: float = 0.0) -> SensorFrame:
    pose = Pose(p=np.zeros(3), q=rpy_to_quat(roll, 0.0, 0.0))
    return replace(frame(k), gyro_I=np.array([0.0, rate, 0.0]), vio=pose)


def test_a_camera_that_turns_fast_or_looks_at_the_floor_loses_its_track_for_a_while():
    for lost in (dict(rate=3.0), dict(roll=np.pi)):
        senses = Senses(1, noise=0.0, can_lose=True)
        senses.vio.parameters = replace(senses.vio.parameters, dropout_rate=0.0)
        said = [senses.corrupt(turned(k, **(lost if 30 <= k < 60 else {}))).vio for k in range(180)]
        heard = np.array([v is not None for v in said])
        assert heard[:30].all() and not heard[30 : 60 + 74].any() and heard[60 + 76 :].all()


def test_without_the_option_no_turn_blinds_the_camera():
    senses = Senses(1)
    senses.vio.parameters = replace(senses.vio.parameters, dropout_rate=0.0)
    assert all(senses.corrupt(turned(k, rate=3.0, roll=np.pi)).vio is not None for k in range(60))
