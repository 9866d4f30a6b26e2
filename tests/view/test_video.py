"""The video shows the robot and its plan, and is whole or absent."""

import os

import imageio_ffmpeg
import mujoco
import numpy as np
import pytest

from mobius.errors import InvalidInput, MobiusError
from mobius.view import drawing
from mobius.view.gl import NoOpenGL, gl_available
from mobius.view.palette import MODE_COLOURS, rgb
from mobius.view.video import ChaseCamera, render_still, render_video, resample

XML = """
<mujoco>
  <worldbody>
    <light pos="0 0 3" dir="0 0 -1"/>
    <geom type="plane" size="0 0 1" rgba=".8 .8 .8 1"/>
    <body pos="0 0 .1"><freejoint/><geom type="box" size=".2 .1 .05" rgba="1 0 0 1"/></body>
  </worldbody>
</mujoco>
"""
SMALL = {"size": (160, 90), "oversample": 1.0, "shadow": 0}


@pytest.fixture(scope="module")
def model():
    return mujoco.MjModel.from_xml_string(XML)


@pytest.fixture(scope="module")
def ride(model):
    """(31, 7): one second at 30 Hz, 1 m along x."""
    rows = np.tile(model.qpos0, (31, 1))
    rows[:, 0] = np.linspace(0, 1, 31)
    return rows


@pytest.fixture
def needs_gl():
    reason = gl_available()
    if reason is not None:
        pytest.skip(reason)


def frames_of(path):
    """What a player sees: facts about the video, and its pictures."""
    reader = imageio_ffmpeg.read_frames(str(path))
    meta = next(reader)
    return meta, [np.frombuffer(f, dtype=np.uint8).reshape(90, 160, 3) for f in reader]


def test_frames_lie_between_recorded_rows_in_proportion(model, ride):
    frames, source = resample(model, ride, qpos_fps=30, fps=20, speed=1.0)
    # one second: 21 frames, 1.5 rows and 0.05 m apart
    assert len(frames) == 21
    np.testing.assert_allclose(source, np.arange(21) * 1.5)
    np.testing.assert_allclose(frames[:, 0], np.arange(21) * 0.05, atol=1e-12)


def test_at_double_speed_there_are_half_the_frames(model, ride):
    frames, _ = resample(model, ride, qpos_fps=30, fps=20, speed=2.0)
    assert len(frames) == 11
    np.testing.assert_allclose(frames[-1], ride[-1])


def test_rotations_are_interpolated_as_rotations(model):
    rows = np.tile(model.qpos0, (2, 1))
    rows[1, 3:] = [np.cos(0.5), 0, 0, np.sin(0.5)]  # 1 rad about z
    frames, _ = resample(model, rows, qpos_fps=1, fps=2, speed=1.0)
    # half way: 0.5 rad, so half of that in the quaternion
    np.testing.assert_allclose(frames[1, 3:], [np.cos(0.25), 0, 0, np.sin(0.25)], atol=1e-9)


def test_one_configuration_is_a_video_of_one_frame(model):
    frames, source = resample(model, model.qpos0[None], qpos_fps=30, fps=20, speed=1.0)
    np.testing.assert_array_equal(frames, model.qpos0[None])
    assert source.tolist() == [0.0]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"size": (161, 90)}, r"even width and height \[px\], got \(161, 90\)"),
        ({"fps": 0.0}, r"expected fps > 0, got 0\.0"),
        ({"oversample": -1.0}, r"expected oversample > 0, got -1\.0"),
        ({"speed": float("nan")}, "expected speed > 0, got nan"),
        ({"captions": ["a"]}, "expected 31 captions, one per qpos, got 1"),
    ],
)
def test_what_does_not_fit_is_refused_before_anything_is_written(
    model, ride, tmp_path, options, message
):
    with pytest.raises(InvalidInput, match=message):
        render_video(tmp_path / "video.mp4", model, ride, **options)
    assert os.listdir(tmp_path) == []


def test_configurations_of_another_model_are_refused(model, tmp_path):
    with pytest.raises(InvalidInput, match=r"expected qpos \(m, 7\) with m >= 1, got \(3, 8\)"):
        render_video(tmp_path / "video.mp4", model, np.zeros((3, 8)))


def test_another_ending_is_refused(model, ride, tmp_path):
    with pytest.raises(InvalidInput, match=r"ending in \.mp4"):
        render_video(tmp_path / "video.gif", model, ride)


def test_without_opengl_one_line_is_said_and_nothing_is_left(model, ride, tmp_path, monkeypatch):
    monkeypatch.setenv("MUJOCO_GL", "off")
    with pytest.raises(NoOpenGL, match="MUJOCO_GL=off turns"):
        render_video(tmp_path / "video.mp4", model, ride)
    assert os.listdir(tmp_path) == []


def test_a_still_shows_the_robot_in_the_middle(model, needs_gl):
    picture = render_still(model, model.qpos0, **SMALL)
    assert picture.shape == (90, 160, 3) and picture.dtype == np.uint8
    red, green, _ = picture[45, 80].astype(int)
    assert red > 2 * green + 20
    corner_red, corner_green, _ = picture[80, 5].astype(int)
    assert abs(corner_red - corner_green) < 20


def test_the_plan_lies_on_the_floor_in_the_colour_of_its_mode(model, needs_gl):
    camera = ChaseCamera(side=0.0)
    plan = np.array([[0.0, 0.0], [3.0, 0.0]])
    bare = render_still(model, model.qpos0, camera=camera, **SMALL).astype(int)
    painted = render_still(
        model, model.qpos0, camera=camera, plan_xy=plan, plan_modes=["crawl"], **SMALL
    ).astype(int)
    changed = np.abs(painted - bare).sum(axis=2) > 60
    assert 30 < changed.sum() < 2000
    rows, columns = np.nonzero(changed)
    # straight ahead: above the robot in the picture, on the middle column
    assert rows.max() < 60
    assert abs(columns.mean() - 80) < 4
    seen, want = painted[changed].mean(axis=0), np.array(rgb(MODE_COLOURS["crawl"]))
    assert np.argmax(seen) == np.argmax(want) and np.argmin(seen) == np.argmin(want)


def test_a_video_has_the_frames_and_the_size_asked_for(model, ride, needs_gl, tmp_path):
    told = []
    render_video(
        tmp_path / "out" / "video.mp4",
        model,
        ride,
        plan_xy=ride[:, :2],
        path_true=ride[:, :2],
        captions=[f"{k / 30:.1f} s" for k in range(31)],
        progress=lambda done, count: told.append((done, count)),
        **SMALL,
    )
    assert os.listdir(tmp_path / "out") == ["video.mp4"]
    meta, frames = frames_of(tmp_path / "out" / "video.mp4")
    assert (meta["size"], meta["fps"], meta["codec"]) == ((160, 90), 20.0, "h264")
    assert meta["pix_fmt"].startswith("yuv420p")
    assert len(frames) == 21
    assert told == [(k, 21) for k in range(1, 22)]
    assert not np.array_equal(frames[0], frames[-1])


def test_frames_dealt_to_several_children_come_back_in_order(model, ride, needs_gl, tmp_path):
    shown = {}
    for count in (1, 2):
        path = tmp_path / f"{count}.mp4"
        render_video(path, model, ride, workers=count, fps=4, path_true=ride[:, :2], **SMALL)
        shown[count] = np.array(frames_of(path)[1], dtype=float)
    assert len(shown[1]) == len(shown[2]) == 5
    far = np.abs(shown[1][:, None] - shown[2][None]).mean(axis=(2, 3, 4))
    assert np.argmin(far, axis=1).tolist() == [0, 1, 2, 3, 4]


def test_pictures_larger_than_a_pipe_come_whole_from_unbuffered_children(
    model, needs_gl, monkeypatch
):
    """PYTHONUNBUFFERED takes the buffer from a child's standard output. A pipe then took
    64 KiB of a picture, the rest was dropped, and the video stopped at its last frame."""
    monkeypatch.setenv("PYTHONUNBUFFERED", "1")
    picture = render_still(model, model.qpos0, size=(640, 360), oversample=1.0, shadow=0)
    assert picture.shape == (360, 640, 3)


def test_a_child_that_dies_is_one_line_and_leaves_no_video(
    model, ride, needs_gl, tmp_path, monkeypatch
):
    monkeypatch.setattr(
        drawing, "worker_command", lambda *_: ["sh", "-c", "echo 'card lost' >&2; exit 3"]
    )
    with pytest.raises(MobiusError, match="drawing stopped at frame 0 of 21: card lost"):
        render_video(tmp_path / "video.mp4", model, ride, **SMALL)
    assert os.listdir(tmp_path) == []


def test_poses_of_moved_obstacles_come_one_per_configuration(tmp_path):
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><worldbody><body name="crate" mocap="true"><geom size="1"/></body>'
        '<body><freejoint/><geom size="0.1"/></body></worldbody></mujoco>'
    )
    qpos = np.tile([0, 0, 1, 1, 0, 0, 0.0], (3, 1))
    with pytest.raises(InvalidInput, match=r"mocap \(3, 1, 7\).*got \(2, 1, 7\)"):
        render_video(tmp_path / "v.mp4", model, qpos, mocap=np.zeros((2, 1, 7)))
