"""The camera is late, drifts with the way travelled, drops out, and comes back elsewhere."""

from dataclasses import replace

import numpy as np
import pytest

from mobius.geometry import quat_conj, quat_mul, quat_to_rpy, rpy_to_quat
from mobius.sense import VioModel, VioParameters
from mobius.types import Pose

DT = 1 / 200
PERFECT = VioParameters(
    latency=0.0,
    drift=0.0,
    yaw_drift=0.0,
    position=0.0,
    orientation=0.0,
    dropout_rate=0.0,
    jump=0.0,
    yaw_jump=0.0,
)


def pose_at(x: float, y: float = 0.0, yaw: float = 0.0) -> Pose:
    return Pose(p=np.array([x, y, 0.3]), q=rpy_to_quat(0.0, 0.0, yaw))


def random_camera(seed: int) -> VioModel:
    rng = np.random.default_rng(seed)
    return VioModel(VioParameters.draw(rng), rng)


def watch(camera: VioModel, poses: list[Pose], dt: float = DT) -> list[Pose | None]:
    return [camera.corrupt(pose, k * dt) for k, pose in enumerate(poses)]


def test_a_perfect_camera_says_the_truth():
    poses = [pose_at(0.01 * k, 0.02 * k, 0.03 * k) for k in range(50)]
    for said, true in zip(
        watch(VioModel(PERFECT, np.random.default_rng(0)), poses), poses, strict=True
    ):
        assert said is not None
        assert said.p == pytest.approx(true.p, abs=1e-12)
        assert np.abs(said.q @ true.q) == pytest.approx(1.0, abs=1e-12)


def test_poses_are_as_old_as_the_latency():
    # 0.5 m/s for 7.5 ms: 3.75 mm behind, at 1 rad/s 7.5 mrad
    camera = VioModel(replace(PERFECT, latency=0.0075), np.random.default_rng(0))
    poses = [pose_at(0.5 * k * DT, yaw=k * DT) for k in range(100)]
    last = watch(camera, poses)[-1]
    assert last is not None
    assert poses[-1].p[0] - last.p[0] == pytest.approx(0.00375, abs=1e-9)
    behind = quat_to_rpy(quat_mul(quat_conj(last.q), poses[-1].q))[2]
    assert behind == pytest.approx(0.0075, abs=1e-5)


def test_the_first_poses_are_never_older_than_the_start():
    camera = VioModel(replace(PERFECT, latency=0.0075), np.random.default_rng(0))
    first, second = watch(camera, [pose_at(1.0), pose_at(2.0)])
    assert first is not None and second is not None
    assert first.p[0] == 1.0 and second.p[0] == 1.0


def test_at_rest_nothing_drifts():
    camera = VioModel(replace(PERFECT, drift=0.01, yaw_drift=0.01), np.random.default_rng(0))
    said = watch(camera, [pose_at(1.0)] * 400)[-1]
    assert said is not None
    assert said.p == pytest.approx([1.0, 0.0, 0.3], abs=1e-12)


def test_position_drift_grows_with_the_root_of_the_way():
    # 0.01 m after 1 m, so 0.02 m per axis after 4 m
    ends = []
    for seed in range(150):
        camera = VioModel(replace(PERFECT, drift=0.01), np.random.default_rng(seed))
        ends.append(watch(camera, [pose_at(0.1 * k) for k in range(41)])[-1].p - [4.0, 0.0, 0.3])
    assert np.std(ends, axis=0) == pytest.approx([0.02] * 3, rel=0.2)


def test_a_heading_error_bends_the_track():
    # 0.1 rad/s for 1 s, then 2 m straight: 2 sin(0.1) = 0.1997 m to the side
    camera = VioModel(replace(PERFECT, yaw_rate=0.1), np.random.default_rng(0))
    for k in range(201):
        camera.corrupt(pose_at(0.0), k * DT)
    camera.parameters = PERFECT
    for k in range(201, 402):
        said = camera.corrupt(pose_at(0.01 * (k - 201)), k * DT)
    assert said is not None
    assert said.p[1] == pytest.approx(0.1997, abs=1e-3)
    assert quat_to_rpy(said.q)[2] == pytest.approx(0.1, abs=1e-3)


def test_a_scale_error_stretches_the_track():
    camera = VioModel(replace(PERFECT, scale=0.01), np.random.default_rng(0))
    said = watch(camera, [pose_at(0.1 * k) for k in range(21)])[-1]
    assert said is not None
    assert said.p[0] == pytest.approx(2.02, abs=1e-9)


def test_attitude_noise_is_half_a_degree_and_slow():
    camera = VioModel(replace(PERFECT, orientation=np.radians(0.5)), np.random.default_rng(3))
    said = watch(camera, [pose_at(0.0)] * 40000)
    rpy = np.degrees(quat_to_rpy(np.array([s.q for s in said])))
    assert rpy.std(axis=0) == pytest.approx([0.5] * 3, rel=0.2)
    # correlation after 0.1 s of a 0.5 s process: exp(-0.2) = 0.82
    after = [np.corrcoef(rpy[:-20, i], rpy[20:, i])[0, 1] for i in range(3)]
    assert after == pytest.approx([0.82] * 3, abs=0.05)


def test_drop_outs_come_once_in_ten_seconds_and_last_as_long_as_they_may():
    camera = VioModel(replace(PERFECT, dropout_rate=0.1), np.random.default_rng(1))
    silent = np.array([s is None for s in watch(camera, [pose_at(0.0)] * 40000, dt=0.02)])
    edges = np.flatnonzero(np.diff(np.r_[0, silent.astype(int), 0]))
    lengths = (edges[1::2] - edges[::2]) * 0.02
    assert 50 <= len(lengths) <= 110  # 800 s: about 80 less those that fall into one another
    assert lengths.min() > 0.05 and lengths.max() <= 0.52


def test_the_camera_comes_back_elsewhere_and_stays_there():
    camera = VioModel(replace(PERFECT, jump=0.05), np.random.default_rng(0))
    camera.corrupt(pose_at(0.0), 0.0)
    camera.blind = True
    assert camera.corrupt(pose_at(0.0), 0.1) is None
    camera.blind = False
    back, later = camera.corrupt(pose_at(0.0), 0.2), camera.corrupt(pose_at(0.0), 0.3)
    assert back is not None and later is not None
    assert 0.005 < np.linalg.norm(back.p - [0.0, 0.0, 0.3]) < 0.25
    assert (later.p == back.p).all()


def test_the_way_travelled_in_the_dark_is_not_lost():
    camera = VioModel(PERFECT, np.random.default_rng(0))
    camera.corrupt(pose_at(0.0), 0.0)
    camera.blind = True
    camera.corrupt(pose_at(1.0), 0.1)
    camera.blind = False
    said = camera.corrupt(pose_at(2.0), 0.2)
    assert said is not None and said.p[0] == pytest.approx(2.0)


def test_equal_seeds_make_equal_cameras():
    poses = [pose_at(0.01 * k) for k in range(500)]
    a, b = (watch(random_camera(7), poses) for _ in range(2))
    assert all(
        (x is None and y is None) or ((x.p == y.p).all() and (x.q == y.q).all())
        for x, y in zip(a, b, strict=True)
    )


def test_random_cameras_differ_and_stay_in_their_ranges():
    drawn = [VioParameters.draw(np.random.default_rng(s)) for s in range(50)]
    latency = np.array([p.latency for p in drawn])
    assert latency.min() >= 0.005 and latency.max() <= 0.010 and np.ptp(latency) > 0.003
    assert len({p.scale for p in drawn}) == 50
