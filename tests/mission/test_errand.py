"""A goal given on the way: where it may be, how it is driven, how it ends."""

import subprocess
import sys
import threading

import numpy as np
import pytest

from mobius.errors import InvalidInput, MapError
from mobius.mission import open_world
from mobius.mission.errand import Errand, place_on
from mobius.mission.prepare import plan_mission
from mobius.plan import NoPlan
from mobius.types import Mode, StateEstimate

MODES = (Mode.CRAWL, Mode.BIPED)


@pytest.fixture(scope="module")
def world():
    return open_world("demo")


def belief(xy, *, stamp: float = 10.0, yaw: float = 0.0) -> StateEstimate:
    zero = np.zeros(3)
    q = [np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2)]
    return StateEstimate(stamp, [*xy, 0.28], q, zero, zero, np.ones(4))


def errand(world, **options) -> Errand:
    return Errand(world, MODES, wait=True, **options)


def test_a_goal_moves_to_the_centre_of_the_free_cell_it_is_in(world):
    centre = world.grid.center_of(np.argwhere(~world.grid.blocked)[5])
    np.testing.assert_allclose(place_on(world, centre + [0.2, -0.2]), centre)


@pytest.mark.parametrize("far", [(-50.0, 0.0), (1e300, 0.0), (np.nan, 0.0)])
def test_a_goal_where_the_robot_never_fits_is_refused(world, far):
    with pytest.raises(MapError, match=r"does not fit within 0\.75 m"):
        place_on(world, far)


def test_it_plans_from_where_the_robot_is_and_sets_out(world):
    job, start = errand(world), world.grid.start
    assert job.command(belief(start), Mode.CRAWL) is None
    job.go(world.grid.goal, start, Mode.CRAWL)
    command = job.command(belief(start), Mode.CRAWL)
    assert job.state == "driving"
    np.testing.assert_allclose(job.plan.xy_M[-1], place_on(world, world.grid.goal))
    for k in range(1, 120):  # it may turn or straighten first
        command = job.command(belief(start, stamp=10.0 + k / 60), Mode.CRAWL)
    assert np.abs(command.twist_H).max() > 0.05


def test_at_the_goal_it_has_arrived_and_says_no_more(world):
    job, start = errand(world), world.grid.start
    there = place_on(world, start)
    job.go(there, there, Mode.CRAWL)
    for k in range(60):
        job.command(belief(there, stamp=10.0 + k / 60), Mode.CRAWL)
    assert job.state == "arrived"
    assert job.command(belief(there, stamp=12.0), Mode.CRAWL) is None


def test_cancelled_it_is_silent(world):
    job, start = errand(world), world.grid.start
    job.go(world.grid.goal, start, Mode.CRAWL)
    job.command(belief(start), Mode.CRAWL)
    job.cancel()
    assert job.command(belief(start), Mode.CRAWL) is None
    assert (job.state, job.notice) == ("idle", "somebody took the controls")


def test_where_there_is_no_way_it_is_refused_with_the_planners_words(world):
    def nowhere(*_, **__):
        raise NoPlan("the goal is walled in")

    job = errand(world, planning=nowhere)
    job.go(world.grid.goal, world.grid.start, Mode.CRAWL)
    assert job.command(belief(world.grid.start), Mode.CRAWL) is None
    assert (job.state, job.notice) == ("refused", "the goal is walled in")


def test_while_it_plans_the_robot_stands_and_a_new_goal_takes_over(world):
    may_go = threading.Event()

    def slowly(*args, **options):
        may_go.wait(10)
        return plan_mission(*args, **options)

    job, start = Errand(world, MODES, planning=slowly), world.grid.start
    job.go(world.grid.goal, start, Mode.CRAWL)
    assert job.command(belief(start), Mode.CRAWL) is None
    assert job.state == "planning"
    job.go(start, start, Mode.CRAWL)
    may_go.set()
    for _ in range(1000):
        if job.command(belief(start), Mode.CRAWL) is not None:
            break
        threading.Event().wait(0.01)
    np.testing.assert_allclose(job.plan.xy_M[-1], place_on(world, start))
    job.close()


def test_a_bug_in_the_planner_is_not_swallowed(world):
    def broken(*_, **__):
        raise ZeroDivisionError

    job = errand(world, planning=broken)
    job.go(world.grid.goal, world.grid.start, Mode.CRAWL)
    with pytest.raises(ZeroDivisionError):
        job.command(belief(world.grid.start), Mode.CRAWL)


def test_without_crawl_there_is_no_errand(world):
    with pytest.raises(InvalidInput, match="expected crawl among the modes"):
        Errand(world, (Mode.BIPED,))


def test_a_plan_in_the_making_does_not_hold_up_the_end_of_the_program():
    """As Ctrl-C while a large map is planned."""
    program = """
import threading
from mobius.mission import open_world
from mobius.mission.errand import Errand
from mobius.types import Mode
begun = threading.Event()
def for_ever(*_, **__):
    begun.set()
    threading.Event().wait()
world = open_world("demo")
job = Errand(world, (Mode.CRAWL,), planning=for_ever)
job.go(world.grid.goal, world.grid.start, Mode.CRAWL)
assert begun.wait(30)
job.close()
print("closed", flush=True)
"""
    process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout.readline() == "closed\n"
        assert process.wait(timeout=20) == 0
    finally:
        process.kill()
        process.wait()
