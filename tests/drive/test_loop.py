"""The loop in its own process, and the line to it."""

import os
import signal
import time

import pytest

from mobius.drive.guide import Planner
from mobius.drive.loop import Line
from mobius.drive.run import drive
from mobius.drive.stage import build_stage
from mobius.errors import InvalidInput, PlanError, UnknownName
from mobius.types import Mode, Plan
from mobius.view.live.nouns import Beat, Freeze, Halt, Reset, Snapshot, WantMode, Way


@pytest.fixture
def line():
    made = Line("arena", randomised=False)
    yield made
    made.close()
    assert not made.alive


def until(line, done, seconds=10.0, beat=Beat(page=True)):  # noqa: B008
    """The first snapshot for which ``done`` holds."""
    end, seen = time.monotonic() + seconds, 0
    while time.monotonic() < end:
        for came in line.come(0.05):
            if isinstance(came, Snapshot):
                seen = came.number
                if done(came):
                    return came
        line.send(Beat(beat.page, beat.driving, beat.share, seen))
    pytest.fail("it did not come about")


def test_snapshots_come_and_requests_go(line):
    first = until(line, lambda s: s.t > 0.3)
    assert first.mode == "crawl" and first.qpos.shape == (line.first.model.nq,)
    line.send(WantMode("fly"))
    assert "unknown mode" in until(line, lambda s: s.message).message


def test_a_viewer_that_falls_silent_is_gone_and_the_loop_does_not_wait_for_it(line):
    ahead = Beat(page=True, driving=True, share=(0.0, 0.0, 1.0))
    before = until(line, lambda s: s.twist[0, 2] > 0.5, beat=ahead)
    time.sleep(1.5)  # nobody takes what the loop sends
    last = until(line, lambda s: s.stopped)
    assert "viewer is gone" in last.message
    assert until(line, lambda s: s.t > before.t + 1.2).stopped


def test_when_the_line_breaks_the_loop_ends():
    line = Line("arena", randomised=False)
    pid = line._process.pid
    line._line.close()
    line._process.join(5.0)
    assert line._process.exitcode == 0
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


def test_a_map_that_cannot_be_used_is_the_users_to_mend():
    with pytest.raises(UnknownName, match="unknown map 'nope'"):
        Line("nope")


def test_without_a_viewer_it_stands_for_some_seconds():
    driven = drive("arena", viewer="none", seconds=0.8)
    assert driven.last is not None and 0.3 < driven.last.t < 2.0
    with pytest.raises(InvalidInput, match="--seconds"):
        drive("arena", viewer="none")


def test_a_plan_crosses_the_line(line):
    from mobius.view.live.nouns import MakePlan

    until(line, lambda s: s.t > 0.2)
    line.send(MakePlan(("crawl",)))
    end, ways = time.monotonic() + 15.0, []
    seen = 0
    while time.monotonic() < end and not (ways and len(ways[-1].xy)):
        for came in line.come(0.05):
            seen = came.number if isinstance(came, Snapshot) else seen
            ways += [came] if isinstance(came, Way) else []
        line.send(Beat(seen=seen))
    assert len(ways[-1].xy) > 2 and ways[-1].status


def test_while_time_stands_still_what_is_asked_is_shown(line):
    until(line, lambda s: s.t > 0.2)
    line.send(Freeze(True))
    still = until(line, lambda s: s.frozen)
    line.send(Halt("a stop"))
    assert until(line, lambda s: s.stopped).t == still.t
    line.send(Reset())
    again = until(line, lambda s: s.scene == still.scene + 1)
    assert again.t < 0.01 and again.frozen and not again.stopped


def test_a_loop_that_is_killed_does_not_pass_for_one_that_was_ended():
    line = Line("arena", randomised=False)
    os.kill(line._process.pid, signal.SIGKILL)
    line._process.join(5.0)
    with pytest.raises(RuntimeError, match="exit code -9"):
        line.check()
    line.close()


def test_a_planner_that_is_killed_is_replaced():
    planner = Planner()
    try:
        world = build_stage("arena").world
        question = (world, (Mode.CRAWL,), world.grid.start, Mode.CRAWL)
        number = planner.ask(*question)
        planner._process.kill()
        planner._process.join()
        answer = planner.answer(number)
        assert isinstance(answer, PlanError) and "ask again" in str(answer)
        number, end = planner.ask(*question), time.monotonic() + 15.0
        while (plan := planner.answer(number)) is None and time.monotonic() < end:
            time.sleep(0.02)
        assert isinstance(plan, Plan)
    finally:
        planner.close()
