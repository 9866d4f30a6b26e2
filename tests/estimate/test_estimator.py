"""The whole estimator on motions whose kinematics are exact."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from mobius.errors import InvalidInput
from mobius.estimate import Estimator, EstimatorConfig
from mobius.geometry import quat_mul, rotate, rpy_to_quat
from mobius.types import Pose, SensorFrame, StateEstimate

PROMPT = EstimatorConfig(camera_latency=0.0)
WALK = (0.3, 0.1, 0.4)


def believe(
    frames: list[SensorFrame],
    start: Pose,
    config: EstimatorConfig = PROMPT,
    *,
    before: Callable[[Estimator], None] = lambda estimator: None,
) -> list[StateEstimate]:
    estimator = Estimator(config)
    estimator.reset(start, frames[0].stamp)
    before(estimator)
    return [estimator.update(frame) for frame in frames]


@pytest.fixture(scope="module")
def walked(motion) -> list[StateEstimate]:
    """The belief of a walk on perfect readings."""
    run = motion(twist=WALK)
    return believe(run.frames, run.start())


def with_camera(
    frames: list[SensorFrame], change: Callable[[float, Pose], Pose | None]
) -> list[SensorFrame]:
    """The frames with what the camera says changed by (stamp, pose) -> pose."""
    return [f if f.vio is None else replace(f, vio=change(f.stamp, f.vio)) for f in frames]


# -- without noise ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "camera"),
    [
        ({}, False),
        ({"twist": WALK}, True),
        ({"twist": WALK}, False),
        ({"twist": (-0.3, 0.0, 0.0)}, False),
        ({"tilt": 0.15}, True),
        ({"tilt": 0.15}, False),
    ],
)
def test_perfect_readings_of_feet_that_do_not_slip_give_the_truth(
    motion, errors, without_camera, options, camera
):
    run = motion(**options)
    frames = run.frames if camera else without_camera(run.frames)
    error = errors(believe(frames, run.start()), run)
    assert np.abs(error["p"]).max() < 0.003
    assert np.abs(error["v"]).max() < 0.004
    assert np.abs(error["turn"]).max() < 0.002


def test_contacts_are_found(motion, walked):
    run = motion(twist=WALK)
    found = np.array([b.contact for b in walked]) > 0.5
    assert (found == run.standing).mean(axis=0).min() > 0.9


def test_a_late_camera_does_not_pull_the_belief_back(motion, errors):
    run = motion(twist=WALK, latency=0.0075)
    known = errors(believe(run.frames, run.start(), EstimatorConfig(camera_latency=0.0075)), run)
    ignored = errors(believe(run.frames, run.start()), run)
    known, ignored = (np.linalg.norm(e["p"][-300:], axis=1).mean() for e in (known, ignored))
    # 0.32 m/s for 7.5 ms is 2.4 mm, which the camera and the legs share
    assert known < 0.001 < ignored < 0.0024


def test_legs_alone_undo_a_wrong_start_except_where_they_cannot(motion, errors, without_camera):
    """Tilt, velocity and biases are observable to legs and IMU; yaw and place are not."""
    run = motion(seconds=8.0)
    wrong = Pose(p=run.p[0], q=quat_mul(rpy_to_quat(0.03, -0.04, 0.1), run.q[0]))
    frames = [
        replace(
            f,
            gyro_I=np.add(f.gyro_I, [0.004, -0.003, 0.0]),
            accel_I=np.add(f.accel_I, [0.0, 0.0, 0.05]),
        )
        for f in without_camera(run.frames)
    ]

    def push(estimator: Estimator) -> None:
        estimator.filter.v = np.array([0.15, -0.1, 0.0])

    error = errors(believe(frames, wrong, before=push), run)
    assert np.abs(error["turn"][-300:, :2]).max() < 0.006  # from 0.05
    assert np.abs(error["v"][-300:]).max() < 0.01  # from 0.18
    assert error["turn"][-1, 2] == pytest.approx(0.1, abs=0.01)


def test_without_a_camera_place_and_heading_grow_uncertain_and_the_rest_does_not(
    motion, without_camera, walked
):
    run, seen = motion(twist=WALK), walked
    blind = believe(without_camera(run.frames), run.start())

    def spread(beliefs: list[StateEstimate], second: int) -> np.ndarray:
        return np.sqrt(np.diag(beliefs[300 * second - 1].cov))

    # rotation, p, w, v
    assert spread(blind, 3)[2] > spread(blind, 2)[2] > spread(blind, 1)[2]
    assert (spread(blind, 3)[3:5] > 1.3 * spread(blind, 1)[3:5]).all()
    assert (spread(blind, 3)[9:] <= 1.05 * spread(blind, 1)[9:]).all()
    assert (spread(blind, 3)[:2] <= 1.05 * spread(blind, 1)[:2]).all()
    assert (spread(blind, 3)[3:5] > 1.3 * spread(seen, 3)[3:5]).all()


def test_turning_and_moving_the_world_turns_and_moves_the_belief(motion, without_camera):
    here = motion(twist=WALK)
    there = motion(twist=WALK, start=(30.0, -20.0, 2.0))
    a = believe(without_camera(here.frames), here.start())[-1]
    b = believe(without_camera(there.frames), there.start())[-1]
    q = rpy_to_quat(0.0, 0.0, 2.0)
    assert_allclose(b.p_OB, np.add(rotate(q, a.p_OB), [30.0, -20.0, 0.0]), atol=1e-6)
    assert_allclose(b.v_B, a.v_B, atol=1e-6)
    assert_allclose(b.contact, a.contact, atol=1e-6)
    assert abs(b.q_OB @ quat_mul(q, a.q_OB)) == pytest.approx(1.0, abs=1e-9)
    assert_allclose(np.diag(b.cov)[9:], np.diag(a.cov)[9:], rtol=1e-4)


# -- the camera misbehaves -------------------------------------------------------------------


def test_where_the_camera_s_own_frame_lies_does_not_matter(motion, walked):
    run = motion(twist=WALK)
    q = rpy_to_quat(0.0, 0.0, 1.0)

    def elsewhere(stamp: float, pose: Pose) -> Pose:
        return Pose(p=np.add(rotate(q, pose.p), [5.0, -3.0, 1.0]), q=quat_mul(q, pose.q))

    a, b = walked[-1], believe(with_camera(run.frames, elsewhere), run.start())[-1]
    assert_allclose(b.p_OB, a.p_OB, atol=1e-6)
    assert abs(b.q_OB @ a.q_OB) == pytest.approx(1.0, abs=1e-9)


def test_legs_carry_the_belief_through_a_drop_out(motion, errors):
    run = motion(twist=WALK)
    frames = with_camera(run.frames, lambda t, pose: None if 1.2 < t < 3.0 else pose)
    error = errors(believe(frames, run.start()), run)
    assert np.abs(error["p"]).max() < 0.005
    assert np.abs(error["v"]).max() < 0.005


def test_a_camera_that_comes_back_elsewhere_does_not_move_the_belief(motion, errors):
    run = motion(twist=WALK)

    def jumped(t: float, pose: Pose) -> Pose | None:
        if 2.0 < t < 2.3:
            return None
        return pose if t < 2.3 else Pose(p=np.add(pose.p, [0.3, -0.2, 0.1]), q=pose.q)

    error = errors(believe(with_camera(run.frames, jumped), run.start()), run)
    assert np.abs(error["p"]).max() < 0.01
    assert np.abs(error["v"]).max() < 0.02


def test_a_jump_without_a_gap_is_refused(motion, errors):
    run = motion(twist=WALK)

    def jumped(t: float, pose: Pose) -> Pose:
        return pose if t < 2.5 else Pose(p=np.add(pose.p, [0.10, 0.05, 0.0]), q=pose.q)

    error = errors(believe(with_camera(run.frames, jumped), run.start()), run)
    assert np.linalg.norm(error["p"], axis=1).max() < 0.025
    assert np.linalg.norm(error["v"][-300:], axis=1).max() < 0.02


def test_a_camera_that_comes_back_turned_is_understood(motion, errors):
    run = motion(twist=WALK)
    q = rpy_to_quat(0.0, 0.0, 0.7)

    def turned(t: float, pose: Pose) -> Pose | None:
        if 2.0 < t < 2.2:
            return None
        return pose if t < 2.2 else Pose(p=rotate(q, pose.p), q=quat_mul(q, pose.q))

    error = errors(believe(with_camera(run.frames, turned), run.start()), run)
    assert np.abs(error["turn"]).max() < 0.02
    assert np.linalg.norm(error["p"], axis=1).max() < 0.03


def test_single_wild_poses_are_refused(motion, errors):
    run = motion(twist=WALK)
    wild = np.random.default_rng(0)

    def often(t: float, pose: Pose) -> Pose:
        return Pose(p=np.add(pose.p, [1.0, 0.0, 0.0]), q=pose.q) if wild.random() < 0.03 else pose

    error = errors(believe(with_camera(run.frames, often), run.start()), run)
    assert np.linalg.norm(error["v"], axis=1).max() < 0.05
    assert np.linalg.norm(error["p"], axis=1).max() < 0.05


# -- the legs misbehave ----------------------------------------------------------------------


def test_a_foot_that_slips_fast_is_not_believed(motion, errors, without_camera):
    run = motion()

    def slipping(frame: SensorFrame) -> SensorFrame:
        if not 2.0 < frame.stamp < 2.5:
            return frame
        dq = frame.dq.copy()
        dq[12] += 6.0  # the left hip yaw at 6 rad/s: its foot at 0.9 m/s
        return replace(frame, dq=dq)

    frames = [slipping(f) for f in without_camera(run.frames)]
    estimator = Estimator(PROMPT)
    estimator.reset(run.start(), 0.0)
    beliefs = [estimator.update(f) for f in frames[:700]]
    assert estimator.slip[2] > 0.8  # and it says which
    assert max(estimator.slip[0], estimator.slip[1], estimator.slip[3]) < 0.02
    beliefs += [estimator.update(f) for f in frames[700:]]
    assert np.linalg.norm(errors(beliefs, run)["v"], axis=1).max() < 0.01


def test_a_velocity_that_all_legs_contradict_is_given_up(motion, errors, without_camera):
    run = motion()

    def wrong(estimator: Estimator) -> None:
        estimator.filter.v = np.array([1.5, 0.0, 0.0])
        estimator.filter.P[3:6, 3:6] = 1e-4 * np.eye(3)

    error = errors(believe(without_camera(run.frames), run.start(), before=wrong), run)
    assert np.linalg.norm(error["v"][600:], axis=1).max() < 0.1


def test_a_velocity_that_the_camera_contradicts_is_given_up(motion, errors):
    run = motion(twist=(0.2, 0.0, 0.0))
    mute = [replace(f, torque=np.zeros(22), wrench_S=np.zeros((2, 6))) for f in run.frames]

    def wrong(estimator: Estimator) -> None:
        estimator.filter.v = np.array([1.0, 0.0, 0.0])
        estimator.filter.P[3:6, 3:6] = 1e-4 * np.eye(3)

    error = errors(believe(mute, run.start(), before=wrong), run)
    assert np.linalg.norm(error["v"][300:], axis=1).max() < 0.1


def test_standing_still_tells_the_gyro_s_bias(motion, without_camera):
    run = motion(sway=0.0, seconds=3.0)
    frames = [
        replace(f, gyro_I=np.add(f.gyro_I, [0.0, 0.0, 0.005])) for f in without_camera(run.frames)
    ]
    last = believe(frames, run.start())[-1]
    assert last.w_B[2] == pytest.approx(0.0, abs=3e-4)
    assert 2 * abs(last.q_OB[3]) < 0.002  # 0.005 rad/s for 3 s would be 0.015


def test_a_raised_floor_is_only_pulled_at_softly(motion, errors, without_camera):
    run = motion()
    high = replace(PROMPT, ground=None)
    above = Pose(p=np.add(run.p[0], [0.0, 0.0, 0.04]), q=run.q[0])
    assert_allclose(
        errors(believe(without_camera(run.frames), above, high), run)["p"][-1, 2], 0.04, atol=0.005
    )
    pulled = errors(believe(without_camera(run.frames), above), run)["p"][:, 2]
    assert pulled[0] > 0.035 and 0.005 < pulled[-1] < 0.025


# -- the contract ----------------------------------------------------------------------------


def test_every_covariance_is_one(motion):
    run = motion(twist=WALK)
    frames = with_camera(run.frames, lambda t, pose: None if 1.2 < t < 3.0 else pose)
    for belief in believe(frames, run.start())[::31]:
        assert np.abs(belief.cov - belief.cov.T).max() < 1e-10
        assert np.linalg.eigvalsh(belief.cov).min() > 0.0


def test_equal_frames_make_equal_beliefs(motion):
    run = motion(twist=WALK)
    a, b = (believe(run.frames[:200], run.start())[-1] for _ in range(2))
    for name in ("p_OB", "q_OB", "v_B", "w_B", "contact", "cov"):
        assert np.array_equal(getattr(a, name), getattr(b, name))


def test_reset_forgets_everything(motion):
    run = motion(twist=WALK)
    estimator = Estimator(PROMPT)
    ends = []
    for _ in range(2):
        estimator.reset(run.start(), 0.0)
        ends.append([estimator.update(f) for f in run.frames[:300]][-1])
    assert np.array_equal(ends[0].cov, ends[1].cov)
    assert np.array_equal(ends[0].p_OB, ends[1].p_OB)


def test_an_estimator_without_a_start_says_what_to_call(motion):
    with pytest.raises(InvalidInput, match=r"call reset\(pose, stamp\) first"):
        Estimator().update(motion().frames[0])


@pytest.mark.parametrize("skip", [-5, 60])
def test_frames_out_of_step_are_refused(motion, skip):
    frames = motion().frames
    estimator = Estimator()
    estimator.reset(motion().start(), 0.0)
    for frame in frames[:10]:
        estimator.update(frame)
    with pytest.raises(InvalidInput, match=r"within 0.1 s after 0.0300 s, got .* call reset"):
        estimator.update(frames[9 + skip])
