"""Sources that are not trusted are not heard, and those that come back put things right."""

from dataclasses import replace

import numpy as np
import pytest

from mobius.estimate import Estimator
from mobius.estimate.config import EstimatorConfig
from mobius.types import Pose

PROMPT = EstimatorConfig(camera_latency=0.0)


def wild_camera(frame):
    """A camera that flies away."""
    if frame.vio is None:
        return frame
    far = Pose(p=np.add(frame.vio.p, [3.0 * frame.stamp, 0, 0]), q=frame.vio.q)
    return replace(frame, vio=far)


def run_through(frames, start, trusts):
    """Beliefs; ``trusts`` maps the index of a frame to what is told before it."""
    estimator = Estimator(PROMPT)
    estimator.reset(start, frames[0].stamp)
    beliefs = []
    for k, frame in enumerate(frames):
        if k in trusts:
            estimator.trust(**trusts[k])
        beliefs.append(estimator.update(frame))
    return estimator, beliefs


def test_a_camera_that_is_not_trusted_is_not_heard(motion, without_camera):
    run = motion(twist=(0.3, 0.1, 0.4))
    told = {0: dict(vio=False)}
    _, wild = run_through([wild_camera(f) for f in run.frames], run.start(), told)
    _, none = run_through(without_camera(run.frames), run.start(), {})
    np.testing.assert_array_equal([b.p_OB for b in wild], [b.p_OB for b in none])


def test_limbs_that_are_not_trusted_say_nothing_of_speed(motion, without_camera):
    """Their rates are made up: with trust the belief would follow them."""
    run = motion(twist=(0.3, 0.0, 0.0))
    frames = without_camera([replace(f, dq=f.dq + 0.5) for f in run.frames[:300]])
    estimator, beliefs = run_through(frames, run.start(), {0: dict(legs=False, ground=False)})
    _, misled = run_through(frames, run.start(), {})
    off = [np.linalg.norm(b[-1].v_B - run.v_B[299]) for b in (beliefs, misled)]
    assert off[0] < 0.02 < off[1]
    assert np.isnan(estimator.slip).all()


def test_the_floor_is_not_heard_and_heard_again(motion, without_camera):
    run = motion()
    high = Pose(p=run.p[0] + [0, 0, 0.1], q=run.q[0])
    frames = without_camera(run.frames)
    _, deaf = run_through(frames, high, {0: dict(ground=False)})
    assert deaf[-1].p_OB[2] - run.p[-1, 2] == pytest.approx(0.1, abs=0.01)
    half = len(frames) // 2
    _, again = run_through(frames, high, {0: dict(ground=False), half: {}})
    assert again[half - 1].p_OB[2] - run.p[half - 1, 2] > 0.09
    assert abs(again[-1].p_OB[2] - run.p[-1, 2]) < 0.03


def test_a_robot_that_lies_still_has_no_velocity_however_wrong_it_started(motion, without_camera):
    run = motion()
    estimator = Estimator(PROMPT)
    estimator.reset(run.start(), run.frames[0].stamp)
    estimator.trust(vio=False, legs=False, ground=False)
    estimator.filter.v = np.array([0.3, -0.2, 0.1])
    estimator.filter.doubt_velocity(0.1)
    still = [replace(f, dq=np.zeros(22)) for f in without_camera(run.frames)[:150]]
    for frame in still:
        belief = estimator.update(frame)
    assert np.abs(belief.v_B).max() < 0.02


def test_what_comes_back_makes_velocity_and_height_unsure(motion):
    run = motion()
    estimator, _ = run_through(run.frames[:60], run.start(), {0: dict(legs=False, ground=False)})
    before = np.diag(estimator.filter.P).copy()
    estimator.trust()
    grown = np.diag(estimator.filter.P) - before
    assert (grown[3:6] > 0.08).all() and grown[8] > 0.002
    assert grown[:3] == pytest.approx(0.0)


def test_reset_trusts_everything_again(motion):
    run = motion()
    frames = run.frames[:90]
    estimator, plain = run_through(frames, run.start(), {})
    estimator.trust(vio=False, legs=False, ground=False)
    estimator.reset(run.start(), frames[0].stamp)
    again = [estimator.update(f) for f in frames]
    np.testing.assert_array_equal([b.p_OB for b in again], [b.p_OB for b in plain])
