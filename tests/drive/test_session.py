"""A person at the controls, in simulated time."""

import numpy as np
import pytest

from mobius.errors import MobiusError
from mobius.types import Mode
from mobius.view.live.nouns import (
    Beat,
    Drag,
    Go,
    Halt,
    LoadMap,
    MakePlan,
    Place,
    Push,
    Record,
    Release,
    Reset,
    SpeedLimit,
    UsePolicy,
    Wait,
    WantMode,
)

AHEAD = Beat(page=True, driving=True, share=(1.0, 0.0, 0.0))


def test_a_held_key_moves_the_robot_and_letting_go_stops_it_within_half_a_second(live):
    live.run(1.0)
    x = live.last.true_pose[0]
    live.run(3.0, AHEAD)
    assert live.last.true_pose[0] - x > 0.5
    live.run(0.5, Beat(page=True, driving=True))
    assert np.linalg.norm(live.last.twist[2, :2]) < 0.1
    x = live.last.true_pose[0]
    live.run(1.0, Beat(page=True, driving=True))
    assert abs(live.last.true_pose[0] - x) < 0.05 and live.last.mode == "crawl"


def test_a_page_that_is_gone_stops_the_robot_within_half_a_second(live):
    live.run(1.0)
    live.run(1.5, AHEAD)
    live.run(0.5, Beat(page=False))
    assert live.last.stopped and "gone" in live.last.message
    assert np.linalg.norm(live.last.twist[2, :2]) < 0.1


def test_a_viewer_that_hangs_stops_the_robot_which_sinks_where_it_is(live):
    """It is gone after 0.3 s of silence; on soft servos the trunk sinks, within 5 cm."""
    live.run(1.0)
    live.run(1.5, AHEAD)
    live.run(0.5, None)
    assert live.last.stopped and "gone" in live.last.message
    assert np.linalg.norm(live.last.twist[2, :2]) < 0.25
    x, y = live.last.true_pose[:2]
    live.run(2.0, None)
    assert np.hypot(live.last.true_pose[0] - x, live.last.true_pose[1] - y) < 0.05
    assert np.linalg.norm(live.last.twist[2, :2]) < 0.02


def test_the_stop_holds_against_keys_and_plans_until_it_is_released(live):
    live.run(1.0)
    live.ask(Halt("emergency stop (Space)"))
    live.ask(Go(("crawl",)))
    live.run(1.0, AHEAD)
    assert live.last.stopped and not live.last.following
    live.ask(Release())
    live.run(4.0)
    assert live.last.mode == "crawl" and not live.last.stopped


def test_a_body_is_reached_through_the_mode_machine_and_keys_go_to_the_body_it_is(live):
    live.run(1.0)
    live.ask(WantMode("biped"))
    live.run(0.2)
    assert live.last.mode == "crawl" and "on the way" in live.last.notice
    live.run(7.0)
    assert live.last.mode == "biped"
    live.run(1.0, AHEAD)
    assert live.last.twist[0, 0] == pytest.approx(0.25)


def test_a_roll_is_made_once(live_on, open_floor):
    live = live_on(str(open_floor))
    live.run(1.0)
    live.ask(WantMode("roll"))
    seen = []
    for _ in range(60):
        live.run(0.2)
        seen.append(live.last.mode)
    assert "roll" in seen and seen[-1] == "crawl" and live.last.wanted == "crawl"


def test_a_roll_into_a_wall_is_refused_with_where_it_is(live_on, open_floor):
    live = live_on(str(open_floor))
    live.ask(Place(start=(-3.0, 0.0)))  # its tail looks at the wall 1 m behind
    live.run(0.5)
    live.ask(WantMode("roll"))
    live.run(1.0)
    assert live.last.mode == "crawl" and live.last.wanted == "crawl"
    assert "no roll" in live.last.message and "turn the tail" in live.last.message


def test_a_plan_is_made_followed_and_paused_and_a_key_takes_the_robot_from_it(live):
    live.run(1.6)
    live.ask(Go(("crawl",)))
    live.run(2.0)
    assert live.last.following and live.session.way.status.startswith("optimal")
    assert live.last.twist[0].any()
    live.ask(Wait())
    live.run(0.5)
    assert not live.last.following and not live.last.twist[0].any()
    live.ask(Go(("crawl",)))
    live.run(0.2)
    assert live.last.following
    live.run(0.1, AHEAD)
    live.run(0.1)
    assert not live.last.following


def test_a_goal_is_set_and_a_bad_one_is_explained_with_the_nearest_good_one(live):
    live.run(0.1)
    live.ask(Place(goal=(2.8, 1.7)))
    assert live.session.way.goal == (2.8, 1.7)
    live.ask(Place(goal=(0.1, 0.1)))
    assert "nearest free cell" in live.session.message
    assert live.session.way.goal == (2.8, 1.7)
    live.ask(Place(goal=(99.0, 0.0)))
    assert "off the map" in live.session.message


def test_the_robot_is_put_at_another_start_and_keeps_its_goal(live):
    scene = live.session.scene_number
    live.ask(Place(goal=(2.8, 1.7)))
    live.ask(Place(start=(1.8, 3.2)))
    live.run(0.1)
    assert np.allclose(live.last.true_pose[:2], (1.8, 3.2), atol=0.02)
    assert live.session.way.goal == (2.8, 1.7) and live.session.scene_number == scene + 1


@pytest.mark.parametrize(
    ("request_", "says"),
    [
        (LoadMap("nope"), "unknown map 'nope'"),
        (WantMode("fly"), "unknown mode 'fly'"),
        (SpeedLimit(3.0), "speed limit"),
        (Push(9.0, 0.0), "push: expected 0 to 2"),
        (UsePolicy("crawl", "nope"), "unknown policy 'nope'"),
        (MakePlan(("fly",)), "unknown mode 'fly'"),
        (MakePlan(("biped",)), "without crawl"),
    ],
)
def test_a_request_that_cannot_be_carried_out_is_explained_and_changes_nothing(
    live, request_, says
):
    live.run(0.1)
    before = live.session.stack
    live.ask(request_)
    live.run(0.1)
    assert says in live.last.message
    assert live.session.stack is before and live.last.mode == "crawl"


def test_a_push_goes_where_it_is_told_from_the_robots_heading(live):
    live.run(1.0)
    live.ask(Push(0.4, np.pi / 2))
    live.run(0.05)
    force = live.session.robot.data.xfrc_applied[:, :2].sum(axis=0)
    yaw = live.last.true_pose[3]
    assert np.allclose(force / np.linalg.norm(force), [-np.sin(yaw), np.cos(yaw)], atol=0.05)


def test_the_mouse_pulls_and_lets_go(live):
    live.run(0.5)
    force = np.zeros_like(live.session.robot.data.xfrc_applied)
    force[live.session.robot.model.body("base_link").id, 1] = 60.0
    live.ask(Drag(force))
    live.run(0.2)
    assert live.session.robot.data.xfrc_applied[:, 1].sum() == 60.0
    live.ask(Drag(0.0 * force))
    assert not live.session.robot.data.xfrc_applied.any()
    live.ask(Drag(np.ones((3, 6))))  # of an older scene
    assert not live.session.robot.data.xfrc_applied.any()


def test_reset_puts_the_robot_back_and_draws_it_anew(live):
    live.run(1.0)
    live.run(1.0, AHEAD)
    live.ask(Reset())
    live.run(0.1)
    assert np.allclose(live.last.true_pose[:2], live.session.scene.start, atol=0.02)


def test_reset_keeps_the_goal_and_the_policy_that_were_chosen(live):
    live.run(0.1)
    rough = live.session.scene.policies["crawl"]
    live.ask(Place(goal=(2.8, 1.7)))
    live.ask(UsePolicy("crawl", "zero"))
    live.ask(Reset())
    assert live.session.way.goal == (2.8, 1.7)
    assert rough == "rough" and live.session.scene.policies["crawl"] == "zero"


def test_a_policy_is_exchanged_while_the_robot_stands_on_it(live):
    live.run(0.5)
    live.ask(UsePolicy("crawl", "zero"))
    live.run(1.0, AHEAD)
    x = live.last.true_pose[0]
    live.run(1.0, AHEAD)
    assert abs(live.last.true_pose[0] - x) < 0.05  # zero stands still whatever is asked
    live.ask(UsePolicy("crawl", "flat"))
    live.run(2.0, AHEAD)
    assert live.last.true_pose[0] - x > 0.3


def test_a_log_is_begun_and_ended_by_a_button(live, tmp_path):
    live.session.log.folder = tmp_path
    live.run(0.2)
    live.ask(Record(True))
    live.run(0.5)
    assert live.last.recording.endswith("run.mcap")
    live.ask(Record(False))
    (log,) = tmp_path.glob("drive_*/run.mcap")
    assert log.stat().st_size > 10_000
    assert live.session.stack.machine.mode is Mode.CRAWL


class Slow:
    """A planner whose answer comes when it is told to."""

    def __init__(self, planner):
        self.planner, self.ready = planner, False

    def ask(self, *question):
        return self.planner.ask(*question)

    def answer(self, number):
        return self.planner.answer(number) if self.ready else None


@pytest.fixture
def slow(live):
    """A drive in which Go has been asked and the plan is still being made."""
    planner = Slow(live.session._planner)
    live.session._planner = live.session.guide._planner = planner
    live.run(1.6)
    live.ask(Go(("crawl",)))
    live.run(0.1)
    assert live.session.guide.planning
    return live, planner


def test_a_plan_that_comes_is_followed(slow):
    live, planner = slow
    planner.ready = True
    live.run(0.1)
    assert live.last.following


@pytest.mark.parametrize("ends", [Halt(), Wait(), WantMode("crawl"), AHEAD, Beat(page=False)])
def test_a_plan_that_comes_after_its_driver_let_it_go_is_not_followed(slow, ends):
    """Go, and before the plan is there: a stop, Pause, another body, a key, nobody there."""
    live, planner = slow
    if isinstance(ends, Beat):
        live.run(0.1, ends)
    else:
        live.ask(ends)
    planner.ready = True
    live.run(0.3)
    assert len(live.session.way.xy) and not live.last.following
    if live.last.stopped:
        live.ask(Release())
        live.run(6.0)
        assert live.last.mode == "crawl" and not live.last.following


@pytest.mark.parametrize("request_", [Go(("crawl",)), WantMode("biped"), Release()])
def test_a_click_that_comes_after_its_page_has_gone_moves_nothing(live, request_):
    live.run(1.6)
    live.run(0.1, Beat(page=False))
    live.ask(request_)
    live.run(1.5, Beat(page=False))
    assert "nobody is at the controls" in live.last.message
    assert live.last.wanted == "crawl" and not live.last.following and not live.last.twist[0].any()


def test_a_robot_that_stopped_by_itself_does_not_go_on_with_its_plan_when_released(live):
    live.run(1.6)
    live.ask(Go(("crawl",)))
    live.run(1.0)
    assert live.last.following
    live.session.stack.machine.emergency_stop("fallen 5 times in a row")  # as it does itself
    live.run(0.5)
    assert not live.last.following
    live.ask(Release())
    live.run(4.0)
    assert live.last.mode == "crawl" and not live.last.following


def test_while_stopped_goals_and_bodies_are_refused_with_what_to_press(live):
    live.run(1.0)
    live.ask(Halt())
    for request in (Go(("crawl",)), WantMode("biped")):
        live.ask(request)
        live.run(0.05)
        assert "release the stop first" in live.last.message
    live.ask(MakePlan(("crawl",)))
    live.run(0.05)
    assert live.last.message.startswith("plan: optimal")


def test_a_released_robot_waits_until_keys_that_were_held_all_along_are_let_go(live):
    live.run(1.0)
    live.run(0.3, AHEAD)
    live.ask(Halt())
    live.ask(Release())
    live.run(4.0, AHEAD)
    assert live.last.mode == "crawl" and not live.last.twist[0].any()
    live.run(0.1, Beat(driving=True))
    live.run(0.1, AHEAD)
    assert live.last.twist[0, 0] > 0.5


def test_a_push_while_the_mouse_pulls_leaves_no_force_behind(live):
    live.run(0.5)
    applied = live.session.robot.data.xfrc_applied
    live.ask(Push(0.3, 0.0))
    live.run(0.05)
    live.ask(Drag(np.zeros_like(applied)))
    assert applied.any()  # the push goes on
    live.run(0.3)
    assert not applied.any()


def test_the_mouse_lets_go_when_its_page_is_gone(live):
    live.run(0.3, AHEAD)
    force = np.zeros_like(live.session.robot.data.xfrc_applied)
    force[1, 2] = 20.0
    live.ask(Drag(force))
    live.run(0.1, Beat(page=False))
    assert not live.session.robot.data.xfrc_applied.any()


def test_a_log_that_cannot_be_made_or_goes_on_no_more_is_explained_and_the_robot_goes_on(
    live, tmp_path
):
    (tmp_path / "file").write_text("")
    live.session.log.folder = tmp_path / "file"  # no folder can be made in a file
    live.run(0.2)
    live.ask(Record(True))
    live.run(0.1)
    assert "cannot be written" in live.last.message and not live.last.recording
    live.session.log.folder = tmp_path
    live.ask(Record(True))
    live.run(0.1)

    def full(*_, **__):
        raise MobiusError("the log can no longer be written (No space left on device)")

    live.session.log._recorder.see = full
    live.run(0.1)
    assert "No space left" in live.last.message and not live.last.recording


def test_a_log_ends_with_its_robot_and_says_so(live, tmp_path):
    live.session.log.folder = tmp_path
    live.run(0.2)
    for _ in range(2):  # two within one second
        live.ask(Record(True))
        live.run(0.1)
        live.ask(Reset())
        live.run(0.1)
        assert live.last.message.startswith(f"saved {tmp_path}") and not live.last.recording
    assert len(list(tmp_path.glob("drive_*/run.mcap"))) == 2
