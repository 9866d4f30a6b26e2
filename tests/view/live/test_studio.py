"""What the pump does with what comes."""

import mujoco
import numpy as np
import pytest

from mobius.errors import InvalidInput
from mobius.view.live.cockpit import Cockpit
from mobius.view.live.nouns import Keeping, Scene, Snapshot
from mobius.view.live.window import check_window

studio = pytest.importorskip("mobius.view.live.studio")


class Handle:
    """Stands for Studio's."""

    def __init__(self):
        self.models = []

    def set_model(self, model):
        self.models.append(model)
        self.data = mujoco.MjData(model)


def scene(number, picture=255, yaw=0.0):
    return Scene(
        number=number,
        model=mujoco.MjModel.from_xml_string("<mujoco/>"),
        map="map",
        maps=(),
        picture=np.full((4, 6, 3), picture, np.uint8),
        origin_M=np.array([1.0, 2.0, yaw]),
        resolution=0.5,
        start=(0.0, 0.0),
        goal=None,
        modes=(),
    )


def snapshot(number, of):
    zeros = np.zeros
    return Snapshot(
        number=number, scene=of, t=0.0, qpos=zeros(0), mode="crawl", wanted="crawl", stopped=False,
        notice="", message="", twist=zeros((3, 3)), true_pose=zeros(4), believed_pose=zeros(4),
        power=0.0, contact=zeros(4), wrench=zeros((2, 6)), keeping=Keeping(), plan=0,
        following=False, arrived=False, frozen=False, recording="",
    )  # fmt: skip


def test_snapshots_are_acknowledged_across_scenes_or_the_loop_would_send_no_more():
    """Eight of the old scene under way, not acknowledged: the page stood still for ever."""
    handle, cockpit = Handle(), Cockpit(None)
    for came in (scene(1), snapshot(8, 1), scene(2)):
        studio._take(handle, cockpit, came)
    assert cockpit.snapshot is None and cockpit.beat().seen == 8
    studio._take(handle, cockpit, snapshot(9, 1))  # of the old one: not shown
    assert cockpit.snapshot is None and cockpit.beat().seen == 9


def test_the_page_gets_another_model_for_another_map_of_the_same_name_alone():
    handle, cockpit = Handle(), Cockpit(None)
    for came in (scene(1), scene(2), scene(3, picture=0), scene(4, picture=0)):
        studio._take(handle, cockpit, came)
    assert len(handle.models) == 2


@pytest.mark.parametrize("yaw", [0.0, 0.5, -2.0])
def test_a_click_goes_where_it_points_to_on_a_turned_map(yaw):
    shown = scene(1, yaw=yaw)
    across = np.array([np.cos(yaw), np.sin(yaw)])  # the map's own x
    up = np.array([-across[1], across[0]])
    # lower left corner of the picture: column 0, row 4; a pixel is 0.5 m
    assert np.allclose(shown.place([0.0, 4.0]), [1.0, 2.0])
    assert np.allclose(shown.place([2.0, 1.0]), [1.0, 2.0] + 1.0 * across + 1.5 * up)
    points = np.random.default_rng(0).normal(size=(5, 2))
    assert np.allclose(shown.place(shown.pixel(points)), points)


def test_without_a_display_there_is_no_window(monkeypatch):
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("sys.platform", "linux")
    with pytest.raises(InvalidInput, match="--viewer web"):
        check_window()
    monkeypatch.setenv("DISPLAY", ":0")
    check_window()


def test_studios_window_can_be_loaded_by_every_python_that_is_supported():
    from collections import abc

    had = hasattr(abc, "Buffer")
    studio.prepare_window()
    assert hasattr(abc, "Buffer") == had


def test_a_file_dropped_on_the_page_is_left_alone(tmp_path):
    from mujoco.studio import messages, viewer_handle
    from mujoco.studio.launch_thread import make_thread_endpoints

    from mobius.view.live.nouns import Reset

    (tmp_path / "other.xml").write_text("<mujoco><worldbody><light/></worldbody></mujoco>")
    _, sim = make_thread_endpoints()
    reins = studio.Reins(Cockpit(None), Reset)
    handle = viewer_handle.ViewerHandle(sim, sim_plugins=[reins])
    handle.set_model(mujoco.MjModel.from_xml_string("<mujoco/>"))
    ours = handle.model
    handle.dispatch(messages.LoadModelEvent(path=str(tmp_path / "other.xml")))
    assert handle.model is ours
