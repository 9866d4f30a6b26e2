"""The invariant filter: its error dynamics, its Jacobians, its arithmetic by hand."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from mobius.estimate.config import FilterNoise
from mobius.estimate.iekf import ACCEL, CAMERA, GYRO, PHI, POS, SIZE, VEL, YAW, InvariantFilter
from mobius.geometry import exp_so3, log_so3, quat_to_mat, rpy_to_quat, skew

DT = 1 / 300
LEVEL = rpy_to_quat(0.0, 0.0, 0.0)
REST = np.array([0.0, 0.0, 9.81])


def drawn(seed: int = 0) -> InvariantFilter:
    """A filter in the middle of something."""
    rng = np.random.default_rng(seed)
    belief = InvariantFilter(rng.normal(0, 2, 3), rpy_to_quat(*rng.normal(0, 0.5, 3)))
    belief.v, belief.rest = rng.normal(0, 0.5, 3), rng.normal(0, 0.1, 10)
    return belief


def moved(belief: InvariantFilter, error: np.ndarray) -> InvariantFilter:
    """exp(error) applied to a copy: the true state whose error the filter would call so."""
    other = InvariantFilter(belief.p, LEVEL)
    other.R, other.v, other.p, other.rest = belief.R, belief.v, belief.p, belief.rest
    other._retract(error)
    return other


def error_of(true: InvariantFilter, belief: InvariantFilter) -> np.ndarray:
    """The right-invariant error (19,) to first order in size, exact in the rotation."""
    phi = log_so3(true.R @ belief.R.T)
    turn = exp_so3(phi)
    rows = [phi, true.v - turn @ belief.v, true.p - turn @ belief.p, true.rest - belief.rest]
    return np.concatenate(rows)


def test_one_step_by_hand():
    # 1 m/s^2 forward for 0.01 s from rest: v = 0.01 m/s, p = 0.5 * 1 * 1e-4 m
    belief = InvariantFilter([1.0, 0.0, 0.3], LEVEL)
    belief.predict(np.zeros(3), REST + np.array([1.0, 0.0, 0.0]), 0.01)
    assert belief.v == pytest.approx([0.01, 0.0, 0.0])
    assert belief.p == pytest.approx([1.00005, 0.0, 0.3])


def test_at_rest_nothing_moves():
    belief = InvariantFilter([1.0, 2.0, 0.3], rpy_to_quat(0.2, -0.1, 1.0))
    for _ in range(300):
        belief.predict(np.zeros(3), belief.R.T @ REST, DT)
    assert belief.v == pytest.approx(np.zeros(3), abs=1e-12)
    assert belief.p == pytest.approx([1.0, 2.0, 0.3], abs=1e-12)


def test_a_correction_by_hand():
    # spread of v 0.05 m/s, measured 0.3 m/s with variance 0.05^2: half way
    belief = InvariantFilter([0.0, 0.0, 0.0], LEVEL, FilterNoise(start_velocity=0.05))
    distance = belief.correct_velocity(np.array([0.3, 0.0, 0.0]), 0.05**2)
    assert belief.v == pytest.approx([0.15, 0.0, 0.0])
    assert belief.P[3, 3] == pytest.approx(0.5 * 0.05**2)
    assert distance == pytest.approx(0.3**2 / (2 * 0.05**2))


def test_a_residual_beyond_the_gate_changes_nothing():
    belief = drawn()
    before = belief.P.copy(), belief.v.copy()
    H = np.eye(SIZE)[VEL]
    assert belief.correct(H, np.full(3, 9.0), 0.01 * np.eye(3), gate=25.0) > 25.0
    assert np.array_equal(belief.P, before[0]) and np.array_equal(belief.v, before[1])


def test_the_error_does_not_depend_on_the_motion():
    """The group-affine property: whatever the IMU says, an error of attitude, velocity and
    position evolves as phi = const, rho_v' = g x phi, rho_p' = rho_v."""
    rng = np.random.default_rng(5)
    xi = np.concatenate([rng.normal(0, 0.3, 3), rng.normal(0, 0.5, 6), np.zeros(10)])
    ends = []
    for motion in range(3):
        belief = drawn(motion)
        belief.rest[:6] = 0.0
        true = moved(belief, xi)
        draw = np.random.default_rng(motion)
        for _ in range(60):
            gyro, accel = draw.normal(0, 2.0, 3), draw.normal(0, 20.0, 3)
            belief.predict(gyro, accel, DT)
            true.predict(gyro, accel, DT)
        ends.append(error_of(true, belief))
    assert ends[1] == pytest.approx(ends[0], abs=1e-9)
    assert ends[2] == pytest.approx(ends[0], abs=1e-9)
    assert ends[0][PHI] == pytest.approx(xi[PHI], abs=1e-9)


def test_the_transition_is_the_derivative_of_the_prediction():
    belief, h = drawn(), 1e-6
    gyro, accel = np.array([0.4, -0.3, 0.5]), np.array([1.0, 2.0, 9.0])
    columns = []
    for i in range(SIZE):
        true, base = moved(belief, h * np.eye(SIZE)[i]), moved(belief, np.zeros(SIZE))
        true.predict(gyro, accel, DT)
        base.predict(gyro, accel, DT)
        columns.append(error_of(true, base) / h)
    belief.predict(gyro, accel, DT)
    belief.spread()
    # first order in dt: what is left is of the order of dt^2 times acceleration
    assert np.column_stack(columns) == pytest.approx(belief._F, abs=3e-4)
    assert np.abs(belief._F - np.eye(SIZE)).max() > 0.03


def derivative(belief: InvariantFilter, measure) -> np.ndarray:
    """d(measure(true state))/d(error) at zero, by central differences."""
    h = 1e-6
    columns = []
    for i in range(SIZE):
        e = h * np.eye(SIZE)[i]
        columns.append((measure(moved(belief, e)) - measure(moved(belief, -e))) / (2 * h))
    return np.column_stack(columns)


def captured(belief: InvariantFilter, act) -> tuple[np.ndarray, np.ndarray]:
    """H and residual that a correction used."""
    seen = []
    belief.correct = lambda H, r, N, gate=np.inf: seen.append((H, r)) or 0.0  # type: ignore[method-assign]
    act(belief)
    return seen[0]


def test_velocity_jacobian():
    belief = drawn()
    H, residual = captured(belief, lambda b: b.correct_velocity(np.array([0.1, 0.2, 0.3]), 1.0))
    R, v = belief.R, belief.v
    numeric = derivative(belief, lambda true: R @ (true.R.T @ true.v))
    assert_allclose(H, numeric, atol=1e-8)
    assert residual == pytest.approx(R @ [0.1, 0.2, 0.3] - v)


def test_height_jacobian():
    belief, point = drawn(), np.array([0.2, -0.3, -0.25])
    H, residual = captured(belief, lambda b: b.correct_height(point, 1.0))
    numeric = derivative(belief, lambda true: (true.p + true.R @ point)[2:])
    assert_allclose(H, numeric, atol=1e-8)
    assert residual == pytest.approx(-(belief.p + belief.R @ point)[2:])


def test_camera_jacobian_with_latency():
    belief, w, latency = drawn(), np.array([0.3, -0.2, 0.5]), 0.0075
    yaw = belief.rest[9]
    R_VB = exp_so3([0.0, 0.0, -yaw]) @ belief.R @ exp_so3(-latency * w)  # a perfect camera
    H, residual = captured(
        belief, lambda b: b.correct_camera(R_VB, w, latency, N=np.eye(6), gate=np.inf)
    )
    past = belief.p - latency * belief.v
    assert residual[:3] == pytest.approx(np.zeros(3), abs=1e-9)
    assert residual[3:] == pytest.approx(belief.camera - past)

    def coincide(true: InvariantFilter) -> np.ndarray:
        turn = true.R @ belief.R.T @ exp_so3([0.0, 0.0, yaw - true.rest[9]])
        return np.concatenate([log_so3(turn), true.p - latency * true.v - true.camera])

    numeric = derivative(belief, coincide)
    assert H[3:] == pytest.approx(numeric[3:], abs=1e-8)
    assert H[:3, [*range(3), YAW]] == pytest.approx(numeric[:3, [*range(3), YAW]], abs=1e-8)


def test_the_camera_s_track_turns_with_its_heading():
    belief = InvariantFilter([0.0, 0.0, 0.3], LEVEL)
    belief.rest[9] = np.pi / 2
    belief.P[YAW, YAW] = 0.01**2
    belief.move_camera(np.array([2.0, 0.0, 0.1]))
    assert belief.camera == pytest.approx([0.0, 2.0, 0.4])
    # a heading off by 0.01 rad puts it 0.02 m to the side (-x here), beside the drift of 2 m
    assert belief.P[15, 15] - belief.P[16, 16] == pytest.approx(0.02**2)
    assert belief.P[16, 16] == pytest.approx(2.0025 * 0.01**2, rel=1e-3)


def test_an_anchored_camera_agrees_with_the_trunk():
    belief = drawn()
    for _ in range(50):
        belief.predict(np.array([0.1, 0.2, 0.1]), belief.R.T @ REST, DT)
    belief.spread()
    before = belief.covariance()
    belief.anchor_camera(0.0, position_variance=1e-6, yaw_variance=1e-6)
    H = np.zeros((3, SIZE))
    H[:, PHI], H[:, POS], H[:, CAMERA] = -skew(belief.p), np.eye(3), -np.eye(3)
    assert belief.camera == pytest.approx(belief.p)
    assert_allclose(H @ belief.P @ H.T, 1e-6 * np.eye(3), atol=1e-12)
    assert belief.covariance() == pytest.approx(before, abs=1e-15)  # nothing learnt of itself
    eigenvalues = np.linalg.eigvalsh(belief.P)
    assert eigenvalues.min() > -1e-12


def test_covariance_is_told_in_world_and_trunk_axes():
    # p 10 m ahead of the origin with known yaw and place: start_position is what is told
    noise = FilterNoise(
        start_position=0.003, start_yaw=0.01, start_velocity=0.02, start_gyro_bias=0.004
    )
    belief = InvariantFilter([10.0, 0.0, 0.3], rpy_to_quat(0.0, 0.0, 0.7), noise)
    cov = belief.covariance()
    assert np.sqrt(np.diag(cov)) == pytest.approx(
        [0.02, 0.02, 0.01] + [0.003] * 3 + [0.005] * 3 + [0.02] * 3  # 0.004 and 0.003 reading
    )
    assert cov[:3, 3:6] == pytest.approx(np.zeros((3, 3)), abs=1e-12)


def test_biases_are_found_when_attitude_and_velocity_are_known():
    belief = InvariantFilter([0.0, 0.0, 0.3], LEVEL, FilterNoise(start_tilt=1e-4))
    for k in range(1500):
        belief.predict(np.array([0.004, 0.0, 0.0]), REST + np.array([0.0, 0.0, 0.04]), DT)
        if k % 2 == 0:
            belief.correct_velocity(np.zeros(3), 0.01**2)
    assert belief.rest[GYRO.start - 9] == pytest.approx(0.004, abs=4e-4)
    assert belief.rest[ACCEL.stop - 10] == pytest.approx(0.04, abs=0.01)


def test_the_covariance_stays_one_over_many_corrections():
    belief, rng = drawn(), np.random.default_rng(2)
    for k in range(600):
        belief.predict(rng.normal(0, 1, 3), belief.R.T @ REST + rng.normal(0, 3, 3), DT)
        belief.correct_velocity(belief.v @ belief.R + rng.normal(0, 0.1, 3), 0.3)
        belief.correct_height(rng.normal(0, 0.3, 3), 0.01)
        if k % 16 == 0:
            belief.clean()
    assert np.abs(belief.P - belief.P.T).max() < 1e-12
    assert np.linalg.eigvalsh(belief.P).min() > -1e-12
    assert_allclose(belief.R @ belief.R.T, np.eye(3), atol=1e-9)


def test_the_start_is_the_pose_given():
    q = rpy_to_quat(0.1, 0.2, 0.3)
    belief = InvariantFilter([1.0, 2.0, 3.0], q)
    assert_allclose(belief.R, quat_to_mat(q))
    assert belief.p == pytest.approx([1.0, 2.0, 3.0])
