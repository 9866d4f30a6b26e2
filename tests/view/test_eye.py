"""The camera sees what is there, and never keeps the robot waiting."""

import os
import time

import mujoco
import numpy as np
import pytest

from mobius.bridge.camera import Picture, info
from mobius.errors import MobiusError
from mobius.model.cameras import Camera
from mobius.view.eye import Eye
from mobius.view.gl import gl_available

pytestmark = pytest.mark.skipif(gl_available() is not None, reason=str(gl_available()))

SCENE = """
<mujoco>
  <worldbody>
    <light pos="0 0 3" dir="0 0 -1" diffuse="1 1 1"/>
    <geom type="box" size="5 5 0.1" pos="0 0 -0.1" rgba="0 0 1 1"/>
    <body name="cart">
      <joint type="slide" axis="1 0 0"/>
      <camera name="head" pos="0 0 2" fovy="60"/>
      <geom type="sphere" size="0.01" pos="0 0 -9" mass="1"/>
    </body>
    <geom type="box" size="0.5 0.5 0.1" pos="3 0 0.1" rgba="1 0 0 1"/>
  </worldbody>
</mujoco>
"""


@pytest.fixture(scope="module")
def model():
    return mujoco.MjModel.from_xml_string(SCENE)


def picture(eye, x, stamp):
    eye.look(np.array([x]), stamp)
    ends = time.monotonic() + 30
    while (seen := eye.take()) is None:
        assert time.monotonic() < ends
        time.sleep(0.01)
    return seen


def test_the_middle_of_the_picture_is_what_is_below_the_camera(model):
    with Eye(model, size=(40, 30)) as eye:
        stamp, pixels = picture(eye, 3.0, 1.5)
        assert (stamp, pixels.shape, pixels.dtype) == (1.5, (30, 40, 3), np.uint8)
        red, _, blue = pixels[15, 20].astype(int)
        assert red > blue + 50
        stamp, pixels = picture(eye, -2.0, 2.5)
        red, _, blue = pixels[15, 20].astype(int)
        assert stamp == 2.5
        assert blue > red + 50


def test_who_asks_while_it_draws_is_not_kept_and_not_answered_twice(model):
    with Eye(model, size=(40, 30)) as eye:
        eye.look(np.array([0.0]), 1.0)
        eye.look(np.array([0.0]), 2.0)  # still at the first: not taken
        ends = time.monotonic() + 30
        while (seen := eye.take()) is None:
            assert time.monotonic() < ends
            time.sleep(0.01)
        assert seen[0] == 1.0
        assert eye.take() is None


def test_a_child_that_dies_is_told(model):
    with Eye(model, size=(40, 30)) as eye:
        eye._child.kill()
        eye._reader.join()
        with pytest.raises(MobiusError, match="run without --camera"):
            eye.look(np.array([0.0]), 1.0)


def test_what_the_camera_info_says_is_where_things_are_drawn():
    """A board whose edges lie on the edges of pixels, so that its pixels have an exact middle."""
    width, height, depth, at = 40, 30, 2.0, (5, -3)
    focal = Camera((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), 60.0).focal(height)
    x, y, half = (depth / focal * pixels for pixels in (*at, 4))
    scene = f"""
    <mujoco>
      <visual><headlight ambient="1 1 1" diffuse="0 0 0" specular="0 0 0"/></visual>
      <worldbody>
        <body>
          <joint type="slide"/>
          <camera name="head" pos="0 0 0" fovy="60"/>
          <geom type="sphere" size="0.01" pos="0 0 1" mass="1"/>
        </body>
        <geom type="box" size="{half} {half} 0.001" pos="{x} {y} {-depth - 0.001}"
         rgba="1 0 0 1"/>
      </worldbody>
    </mujoco>"""
    with Eye(mujoco.MjModel.from_xml_string(scene), size=(width, height)) as eye:
        stamp, pixels = picture(eye, 0.0, 1.0)
    rows, columns = np.nonzero(pixels[..., 0] > 100)
    assert len(rows) == 64
    k = info(Picture(stamp, pixels, focal)).k.reshape(3, 3)
    u, v, w = k @ [x, -y, depth]  # optical frame: x right, y down, z forward
    np.testing.assert_allclose([columns.mean(), rows.mean()], [u / w, v / w], atol=1e-6)


def test_nothing_is_left_behind(model):
    with Eye(model, size=(40, 30)) as eye:
        folder, child = eye._folder.name, eye._child
        assert os.getpgid(child.pid) != os.getpgid(0)  # Ctrl-C ends the robot's program alone
    assert not os.path.exists(folder)
    assert child.poll() is not None
