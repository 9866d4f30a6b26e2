"""What a motion may say: angles all round, limits, cranks apart."""

import numpy as np
import pytest

from mobius.errors import InvalidInput, UnknownName
from mobius.geometry import rpy_to_quat
from mobius.model import JOINTS
from mobius.model.robot import keyframe, keyframe_joints
from mobius.modes.motions import Feedback, Motion, Stage, Tilt, Until, Window, tilt_of

CRAWL = keyframe_joints("crawl")[0]


@pytest.mark.parametrize(
    ("pose", "pitch"),
    [("crawl", 0.0), ("stand", -np.pi / 2), ("supine", np.pi), ("on_head", np.pi / 2)],
)
def test_pitch_tells_the_keyframes_apart(pose, pitch):
    tilt = tilt_of(keyframe(pose)[0][3:7])
    assert abs(abs(tilt.pitch_B) - abs(pitch)) < 1e-9
    assert np.sign(tilt.pitch_B) == np.sign(pitch) or pose in ("crawl", "supine")
    assert abs(tilt.lean_B) < 1e-9


def test_a_backward_roll_runs_down_to_minus_pi_and_on_from_plus_pi():
    turned = [tilt_of(rpy_to_quat(0.0, -a, 0.0)).pitch_B for a in (0.5, 1.5, 3.0)]
    assert turned == pytest.approx([-0.5, -1.5, -3.0])
    assert tilt_of(rpy_to_quat(np.pi, 0.5, 0.3)).pitch_B == pytest.approx(np.pi - 0.5)


def test_the_left_side_up_is_a_positive_roll_and_lean():
    tilt = tilt_of(rpy_to_quat(0.7, 0.0, 2.0))
    assert (tilt.roll_B, tilt.lean_B) == pytest.approx((0.7, 0.7))


def at(pitch):
    return Tilt(pitch, 0.0, 0.0)


def test_until_holds_beyond_one_bound_between_two_and_round_the_back():
    assert Until("pitch_B", below=-1.0).holds(at(-1.1)) and not Until("pitch_B", below=-1.0).holds(
        at(-0.9)
    )
    between = Until("pitch_B", above=-1.0, below=1.0)
    assert between.holds(at(0.0)) and not between.holds(at(2.0))
    back = Until("pitch_B", above=2.5, below=-2.5)
    assert back.holds(at(3.0)) and back.holds(at(-3.0)) and not back.holds(at(0.0))


def test_a_window_is_counted_round_the_circle():
    window = Window(pitch=np.pi, within=0.5)
    assert window.holds(at(-3.0)) and window.holds(at(3.0)) and not window.holds(at(2.0))
    assert not Window(lean=0.3).holds(Tilt(0.0, 0.0, -0.4))


def test_a_target_beyond_a_limit_is_refused_with_its_joint():
    q = CRAWL.copy()
    q[JOINTS.index("left_hip_yaw")] = 2.0
    with pytest.raises(InvalidInput, match=r"left_hip_yaw: expected -1.8326 to 1.8326 rad, got 2"):
        Stage(q, 1.0)


def test_cranks_too_close_are_refused():
    q = CRAWL.copy()
    q[1], q[2] = 0.5, 1.1
    with pytest.raises(InvalidInput, match=r"at least 0.70 rad apart, got 0.6"):
        Stage(q, 1.0)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Until("yaw", above=1.0), "unknown trunk angle 'yaw'"),
        (lambda: Until("pitch_B"), "expected 'above', 'below' or both"),
        (lambda: Until("pitch_B", above=np.nan), "Until.above: expected a finite number"),
        (lambda: Window(within=0.0), "Window.within: expected an angle > 0"),
        (lambda: Feedback("left_knee", 1.0, 0.0), "unknown joint 'left_knee'"),
        (lambda: Stage(CRAWL, 0.0), "Stage.seconds: expected a finite number >= 0.001"),
        (lambda: Stage(CRAWL, 1.0, hold=-1.0), "Stage.hold: expected a finite number >= 0"),
        (lambda: Stage(CRAWL[:20], 1.0), "Stage.q: expected shape"),
        (lambda: Motion("m", "prone", "crawling", ()), "at least one stage"),
        (lambda: Motion("m", "asleep", "crawling", (Stage(CRAWL, 1.0),)), "posture 'asleep'"),
    ],
)
def test_a_mistake_is_named(make, message):
    with pytest.raises((InvalidInput, UnknownName), match=message.replace("(", r"\(")):
        make()
