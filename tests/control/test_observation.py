"""The observation: sizes of the paper, frames, history, mirror."""

import numpy as np
import pytest

from mobius.control.bodies import body_of
from mobius.control.observation import (
    History,
    Layout,
    build_frame,
    heading_twist,
    mirror_frame,
    mirror_joints,
)
from mobius.errors import InvalidInput, UnknownName
from mobius.geometry import quat_conj, quat_mul, rotate, rpy_to_quat

BODY = body_of("crawl")
LAYOUTS = [Layout("fast", 14, 3, True), Layout("fast", 14, 2), Layout("paper", 14, 16)]


def state(n: int = 5, seed: int = 0) -> dict:
    rng = np.random.default_rng(seed)
    return dict(
        q_OB=rpy_to_quat(*rng.uniform(-0.4, 0.4, (2, n)), rng.uniform(-3, 3, n)),
        v_B=rng.normal(size=(n, 3)),
        w_B=rng.normal(size=(n, 3)),
        yaw0=np.zeros(n),
        joints=rng.normal(size=(n, 14)),
        default=rng.normal(size=14),
        action=rng.normal(size=(n, 14)),
        command=rng.normal(size=(n, 3)),
        clock=rng.normal(size=(n, 2)),
    )


def test_sizes_of_the_paper():
    assert Layout("paper", 14, 16).size == 608  # 38 x 16, Sec. IV-A2
    assert Layout("paper", 8, 16).size == 416  # 26 x 16
    assert len(BODY.joints) == 14


@pytest.mark.parametrize("layout", LAYOUTS)
def test_frame_has_the_size_it_says(layout):
    assert build_frame(layout, BODY, **state()).shape == (5, layout.frame_size)


def test_fast_frame_by_hand():
    """Level trunk turned by 90 deg, moving along world x: that is to its right, -y in H."""
    layout = Layout("fast", 14, 1)
    s = state(1)
    s["q_OB"] = rpy_to_quat(0.0, 0.0, [np.pi / 2])
    s["v_B"] = rotate(quat_conj(s["q_OB"]), np.array([[0.5, 0.0, 0.0]]))
    frame = build_frame(layout, BODY, **s)[0]
    np.testing.assert_allclose(frame[:3], [0, 0, -1], atol=1e-12)  # gravity in the trunk
    np.testing.assert_allclose(frame[6:9], [0, -0.5, 0], atol=1e-12)  # heading-frame velocity
    np.testing.assert_allclose(frame[9:23], s["joints"][0] - s["default"])
    np.testing.assert_allclose(frame[37:40], s["command"][0])


def test_fast_frame_does_not_know_absolute_yaw():
    layout, s = Layout("fast", 14, 1), state()
    a = build_frame(layout, BODY, **s)
    s["q_OB"] = quat_mul(rpy_to_quat(0.0, 0.0, 1.234), s["q_OB"])
    np.testing.assert_allclose(build_frame(layout, BODY, **s), a, atol=1e-12)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_mirror_is_an_involution(layout):
    for index, sign in (mirror_frame(layout, BODY), mirror_joints(BODY)):
        x = np.random.default_rng(0).normal(size=len(index))
        np.testing.assert_allclose(sign * (sign * x[index])[index], x)


@pytest.mark.parametrize("kind", ["fast", "paper"])
def test_mirror_of_a_frame_is_the_frame_of_the_mirror(kind):
    """Mirror the state in space, build its frame: the same as mirroring the frame."""
    layout, s = Layout(kind, 14, 1, True), state()
    index, sign = mirror_joints(BODY)
    m = dict(s)
    m["q_OB"] = s["q_OB"] * [1, -1, 1, -1]
    m["v_B"] = s["v_B"] * [1, -1, 1]
    m["w_B"] = s["w_B"] * [-1, 1, -1]
    m["default"] = s["default"] = 0.5 * (s["default"] + sign * s["default"][index])
    for key in ("joints", "action"):
        m[key] = sign * s[key][:, index]
    m["command"] = s["command"] * [1, -1, -1]
    m["clock"] = -s["clock"]
    perm, signs = mirror_frame(layout, BODY)
    a, b = build_frame(layout, BODY, **s), build_frame(layout, BODY, **m)
    np.testing.assert_allclose(signs * a[:, perm], b, atol=1e-9)


def test_history_is_newest_first_and_starts_full():
    layout = Layout("fast", 14, 3)
    h = History(layout, 2)
    one = np.full((2, layout.frame_size), 1.0)
    assert (h.push(one) == 1).all()
    out = h.push(2 * one).reshape(2, 3, -1)
    assert out[:, :, 0].tolist() == [[2, 1, 1], [2, 1, 1]]
    h.reset(np.array([True, False]))
    out = h.push(3 * one).reshape(2, 3, -1)
    assert out[:, :, 0].tolist() == [[3, 3, 3], [3, 2, 1]]


def test_heading_twist_leaves_yaw_rate_and_speed():
    s = state()
    v, w = heading_twist(BODY, s["q_OB"], s["v_B"], s["w_B"])
    np.testing.assert_allclose(np.linalg.norm(v, axis=1), np.linalg.norm(s["v_B"], axis=1))
    np.testing.assert_allclose(np.linalg.norm(w, axis=1), np.linalg.norm(s["w_B"], axis=1))


def test_mistakes_are_named():
    with pytest.raises(UnknownName, match="Did you mean 'fast'"):
        Layout("fst", 14, 1)  # type: ignore[arg-type]
    s = state()
    s.pop("clock")
    with pytest.raises(InvalidInput, match="clock"):
        build_frame(Layout("fast", 14, 1, True), BODY, **s)
    with pytest.raises(UnknownName, match="crawl"):
        body_of("crwl")


def test_the_standing_trunk_s_attitude_is_that_of_its_level_frame():
    """A biped's trunk is pitched by -90 deg, where roll and yaw of base_link are one angle."""
    biped, layout = body_of("biped"), Layout("paper", 8, 1)
    standing = rpy_to_quat(0.0, -np.pi / 2, 0.0)
    want = np.array([[0.05, 0.1, 0.7], [-0.1, -0.2, -2.0]])
    q = quat_mul(rpy_to_quat(*want.T), standing)
    s = state(2)
    s.update(q_OB=q, joints=s["joints"][:, :8], action=s["action"][:, :8], default=np.zeros(8))
    np.testing.assert_allclose(build_frame(layout, biped, **s)[:, :3], want, atol=1e-9)
