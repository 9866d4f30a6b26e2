"""The estimator on MuJoCo's robot: swaying on still feet, and a scripted trot that slips."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest

from mobius.estimate import Estimator
from mobius.geometry import quat_to_rpy, wrap_angle
from mobius.model import LIMB_JOINTS, limb_geometry
from mobius.model.leg import ankle_ik, ankle_position
from mobius.model.robot import keyframe_joints, load_model
from mobius.robot.sim import SimRobot
from mobius.sense import Senses
from mobius.types import LIMBS, JointCommand, Pose, SensorFrame, StateEstimate

HOLD = keyframe_joints("crawl")[1]
GEOMETRY = [limb_geometry(name) for name in LIMBS]
NOMINAL = [ankle_position(g, HOLD[LIMB_JOINTS[g.name]]) for g in GEOMETRY]


@dataclass(frozen=True, eq=False)
class Recording:
    frames: list[SensorFrame]
    truth: list[StateEstimate]

    @property
    def way(self) -> float:
        p = np.array([t.p_OB for t in self.truth[::60]])
        return float(np.linalg.norm(np.diff(p, axis=0), axis=1).sum())


def with_wrists_at(points: list[np.ndarray]) -> np.ndarray:
    """Servo targets that bring wrists and ankles to points in B; wrist and ankle joints hold."""
    q = HOLD.copy()
    for g, p in zip(GEOMETRY, points, strict=True):
        s = LIMB_JOINTS[g.name].start
        q[s : s + 3] = ankle_ik(g, p)
    return q


def sway(t: float) -> np.ndarray:
    wave, ease = 2 * np.pi * 0.7 * t, min(t, 1.0)
    d = ease * np.array([0.025 * np.sin(wave), 0.025 * np.cos(wave), 0.01 * np.sin(2 * wave)])
    return with_wrists_at([p - d for p in NOMINAL])


def trot(t: float) -> np.ndarray:
    """Diagonal trot at 2 Hz, 0.3 m/s asked for and 0.2 rad/s."""
    go, points = float(np.clip(t - 0.8, 0.0, 1.0)), []
    for p, offset in zip(NOMINAL, (0.0, 0.5, 0.5, 0.0), strict=True):
        phase = (2.0 * t + offset) % 1.0
        v = go * np.array([0.3 - 0.2 * p[1], 0.2 * p[0], 0.0])
        u = max(phase - 0.55, 0.0) / 0.45
        at = 0.5 - phase / 0.55 if phase < 0.55 else u - np.sin(2 * np.pi * u) / (2 * np.pi) - 0.5
        lift = 0.025 * (1 - np.cos(2 * np.pi * u)) if t > 0.5 else 0.0
        points.append(p + at * v * 0.55 / 2.0 + [0.0, 0.0, lift])
    return with_wrists_at(points)


def record(script: Callable[[float], np.ndarray], seconds: float) -> Recording:
    robot = SimRobot(load_model("full"))
    frames, truth = [], []
    for tick in range(round(600 * seconds)):
        if tick % 2 == 0:
            frames.append(robot.read())
            truth.append(robot.truth())
        if tick % 10 == 0:
            robot.write(JointCommand(q=script(tick / 600), stamp=tick / 600))
        robot.wait()
    return Recording(frames, truth)


@pytest.fixture(scope="module")
def swaying() -> Recording:
    return record(sway, 2.5)


@pytest.fixture(scope="module")
def trotting() -> Recording:
    return record(trot, 5.0)


@cache
def believe(
    recording: Recording, *, seed: int | None = 0, camera: bool = True
) -> list[StateEstimate]:
    estimator, first = Estimator(), recording.truth[0]
    estimator.reset(Pose(p=first.p_OB, q=first.q_OB), recording.frames[0].stamp)
    frames = recording.frames
    if seed is not None:
        senses = Senses(seed)
        frames = [senses.corrupt(f) for f in frames]
    return [estimator.update(f if camera else replace(f, vio=None)) for f in frames]


def velocity_error(recording: Recording, beliefs: list[StateEstimate]) -> np.ndarray:
    error = [b.v_B - t.v_B for b, t in zip(beliefs, recording.truth, strict=True)]
    return np.array(error)[300:]


def rms(values: np.ndarray) -> np.ndarray:
    return np.sqrt(np.mean(values**2, axis=0))


def test_the_trot_is_worth_estimating(trotting):
    speed = np.array([t.v_B for t in trotting.truth])[600:]
    assert trotting.way > 0.8
    assert speed.std(axis=0).max() > 0.04


@pytest.mark.parametrize("seed", [0, 1])
def test_velocity_is_within_four_centimetres_a_second(trotting, seed):
    assert rms(velocity_error(trotting, believe(trotting, seed=seed))).max() < 0.04


def test_velocity_on_still_feet_is_within_a_centimetre_a_second(swaying):
    assert rms(velocity_error(swaying, believe(swaying, camera=False))).max() < 0.01


def test_velocity_without_a_camera_suffers_from_slip_alone(trotting):
    assert rms(velocity_error(trotting, believe(trotting, camera=False))).max() < 0.05


def test_velocity_is_not_late(trotting):
    """Of all shifts in time the belief fits the truth best at none, to a frame of 1/300 s."""
    believed = np.array([b.v_B for b in believe(trotting)])
    true = np.array([t.v_B for t in trotting.truth])
    window = slice(600, 1400)
    for axis in (0, 1):
        misfit = {
            lag: np.mean((believed[window, axis] - np.roll(true[:, axis], lag)[window]) ** 2)
            for lag in range(-6, 7)
        }
        assert abs(min(misfit, key=misfit.__getitem__)) <= 1


@pytest.mark.parametrize("seed", [0, 1])
def test_place_is_within_a_few_hundredths_of_the_way(trotting, seed):
    off = believe(trotting, seed=seed)[-1].p_OB - trotting.truth[-1].p_OB
    assert np.linalg.norm(off[:2]) < 0.03 * trotting.way + 0.03
    assert abs(off[2]) < 0.02


@pytest.mark.parametrize("camera", [True, False])
def test_tilt_is_within_half_a_degree(trotting, camera):
    beliefs = believe(trotting, camera=camera)
    believed = quat_to_rpy(np.array([b.q_OB for b in beliefs]))
    true = quat_to_rpy(np.array([t.q_OB for t in trotting.truth]))
    error = np.degrees(wrap_angle(believed - true))[300:]
    assert rms(error)[:2].max() < 0.5
    assert abs(error[-1, 2]) < 2.0


def test_contacts_agree_with_the_ground(trotting):
    found = np.array([b.contact for b in believe(trotting)])[300:] > 0.5
    true = np.array([t.contact for t in trotting.truth])[300:] > 0.5
    assert (found == true)[:, :2].mean() > 0.9  # wrist sensors
    assert (found == true)[:, 2:].mean() > 0.75  # servo torques; feet that bounce and drag


def test_standing_limbs_carry_the_robot(swaying):
    estimator, first = Estimator(), swaying.truth[0]
    estimator.reset(Pose(p=first.p_OB, q=first.q_OB), 0.0)
    carried = []
    for frame in swaying.frames:
        estimator.update(frame)
        carried.append(sum(estimator.contact_force))
    # 10.3 kg
    assert np.mean(carried[300:]) == pytest.approx(10.3 * 9.81, rel=0.05)


def test_believed_errors_are_as_large_as_the_covariance_says(trotting):
    beliefs = believe(trotting)
    error = velocity_error(trotting, beliefs)
    spread = np.sqrt([np.diag(b.cov)[9:] for b in beliefs])[300:]
    within = np.abs(error) < 3 * spread
    assert within.mean() > 0.85
