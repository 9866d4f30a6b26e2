"""Each device errs as its datasheet says, and every time the same for the same seed."""

import numpy as np
import pytest

from mobius.sense.noise import CurrentNoise, EncoderNoise, ImuNoise, WrenchNoise

N = 4000
DT = 1 / 300


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def test_imu_noise_is_white_about_its_bias():
    imu = ImuNoise(rng(), gyro_walk=0.0, accel_walk=0.0)
    read = np.array([np.r_[imu.corrupt(np.zeros(3), np.zeros(3), DT)] for _ in range(N)])
    assert read.std(axis=0) == pytest.approx([0.002] * 3 + [0.03] * 3, rel=0.05)
    assert read.mean(axis=0) == pytest.approx(imu.bias, abs=0.03 * 4 / np.sqrt(N))
    centred = read - read.mean(axis=0)
    lag_one = (centred[1:] * centred[:-1]).mean(axis=0) / centred.var(axis=0)
    assert np.abs(lag_one).max() < 4 / np.sqrt(N)


def test_imu_bias_walks_with_the_root_of_time():
    # 5e-5 rad/s/sqrt(s) over 100 s: a spread of 5e-4 rad/s
    ends = []
    for seed in range(60):
        imu = ImuNoise(rng(seed), gyro_bias=0.0, accel_bias=0.0)
        for _ in range(50):
            imu.corrupt(np.zeros(3), np.zeros(3), 2.0)
        ends.append(imu.bias)
    assert np.std(ends, axis=0)[:3].mean() == pytest.approx(5e-4, rel=0.2)
    assert np.std(ends, axis=0)[3:].mean() == pytest.approx(5e-3, rel=0.2)


def test_imu_bias_does_not_walk_while_no_time_passes():
    imu = ImuNoise(rng())
    before = imu.bias.copy()
    imu.corrupt(np.zeros(3), np.zeros(3), 0.0)
    assert (imu.bias == before).all()


def test_encoders_read_whole_ticks():
    encoder = EncoderNoise(rng(), zero=0.0)
    q = np.linspace(-1.5, 1.5, 22)
    read, _ = encoder.corrupt(q, np.zeros(22))
    ticks = read / (2 * np.pi / 4096)
    assert ticks == pytest.approx(np.rint(ticks), abs=1e-9)
    assert np.abs(read - q).max() <= np.pi / 4096 + 1e-12


def test_encoder_rates_read_whole_units_with_small_noise():
    encoder = EncoderNoise(rng())
    read = np.array([encoder.corrupt(np.zeros(22), np.full(22, 0.7))[1] for _ in range(500)])
    units = read / 0.0239808  # 0.229 rpm
    assert units == pytest.approx(np.rint(units), abs=1e-4)
    assert read.mean() == pytest.approx(0.7, abs=1e-3)
    # quantisation 0.02398 / sqrt(12) = 0.0069 and white 0.01: together 0.0122
    assert read.std() == pytest.approx(0.0122, rel=0.1)


def test_joint_zeros_are_off_by_a_constant():
    encoder = EncoderNoise(rng(), zero=0.05)
    first, second = (encoder.corrupt(np.zeros(22), np.zeros(22))[0] for _ in range(2))
    assert (first == second).all()
    assert first == pytest.approx(encoder.offset, abs=np.pi / 4096)


def test_torque_is_read_with_a_gain_error_per_servo():
    current = CurrentNoise(rng(), white=0.0)
    assert current.corrupt(np.full(22, 2.0)) == pytest.approx(2.0 * current.factor)
    assert 0.02 < current.factor.std() < 0.09


def test_wrench_noise_and_drift_have_the_sensor_s_size():
    wrench = WrenchNoise(rng(), force_drift=0.0, torque_drift=0.0)
    read = np.array([wrench.corrupt(np.zeros((2, 6)), DT) for _ in range(N)])
    assert read.std(axis=0)[0] == pytest.approx([0.15] * 3 + [0.005] * 3, rel=0.06)
    ends = []
    for seed in range(60):
        wrench = WrenchNoise(rng(seed))
        for _ in range(60):
            wrench.corrupt(np.zeros((2, 6)), 1.0)
        ends.append(wrench.bias)
    assert np.std(ends, axis=0)[:, :3].mean() == pytest.approx(0.1, rel=0.2)  # after a minute


def test_wrench_saturates_at_its_range():
    wrench = WrenchNoise(rng())
    read = wrench.corrupt(np.full((2, 6), 1e4), DT)
    assert (read == [[500.0] * 3 + [10.0] * 3] * 2).all()
    assert (wrench.corrupt(np.full((2, 6), -1e4), DT) == -read).all()
