"""The live robot in one process: commands in, motion and messages out, no wall clock."""

import json
from collections import defaultdict
from types import SimpleNamespace

import numpy as np
import pytest

from mobius.bridge.messages import TOPICS, decode
from mobius.bridge.read_run import open_run
from mobius.bridge.record import McapRecorder
from mobius.control.policy import load_policy, shipped_policy
from mobius.errors import MapError
from mobius.mission.serve import build_served, serve
from mobius.pace import Pace
from mobius.robot import TICK
from mobius.types import Mode


class Graph:
    """A node whose other end is the test."""

    def __init__(self) -> None:
        self.sent: dict[str, list[bytes]] = defaultdict(list)
        self.ears: dict[str, object] = {}
        self.checks = 0

    def speaker(self, topic, kind, *, latched=False):
        return SimpleNamespace(send=lambda data: self.sent[topic].append(bytes(data)))

    def hear(self, topic, kind, take):
        self.ears[topic] = take

    def check(self):
        self.checks += 1

    def last(self, topic):
        return decode(topic, self.sent[topic][-1])


class Time:
    """A wall that goes exactly as fast as the robot."""

    now = 0.0

    def __call__(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.now += seconds


def run(served, seconds, *, graph=None, **options):
    graph, wall = graph or Graph(), Time()
    served.remote._clock = wall
    pace = Pace(served.stack, clock=wall, sleep=wall.sleep)
    timing = serve(served, graph, seconds=seconds, pace=pace, **options)
    return graph, timing


@pytest.fixture(scope="module")
def floor():
    return build_served(modes=("crawl", "biped"))


def test_it_says_what_it_does_and_keeps_time(floor):
    recorder = McapRecorder()
    graph, timing = run(floor, 1.0, recorder=recorder)
    assert timing.simulated == pytest.approx(1.0)
    counts = {name: len(said) for name, said in graph.sent.items()}
    silent = {n for n, r in TOPICS.items() if r.latched or "camera" in n}
    silent -= {"/tf_static", "/robot_description"}  # there is no map
    live = {n: r for n, r in TOPICS.items() if r.where != "log" and n not in silent}
    for name, row in live.items():
        assert counts[name] == pytest.approx(row.rate or 1, abs=1), name
    assert not silent & set(counts)
    assert graph.checks == 600
    assert len(recorder) > 300


def test_the_status_says_how_it_goes(floor):
    graph, _ = run(floor, 1.0)
    status = graph.last("/mobius/status")
    assert status["mode"] == status["wanted"] == "crawl"
    assert status["goal"] == "no map"
    assert set(status["available"]) >= {"crawl", "biped"}
    assert json.dumps(status)


def test_a_twist_moves_it_and_its_end_stops_it(floor):
    graph, wall_end = Graph(), 1.5
    begin = floor.robot.truth().p_OB[0]

    def push(sample, timing):
        if sample.tick * TICK < begun + wall_end:
            floor.remote.take_twist(np.array([0.4, 0.0, 0.0]))

    begun = floor.stack.tick * TICK
    run(floor, 3.0, graph=graph, watch=push)
    # words come twice a second, a twist counts half a second: it moved for about 1.5 s
    assert 0.3 < floor.robot.truth().p_OB[0] - begin < 1.0
    assert graph.last("/mobius/command").tolist() == [0.0, 0.0, 0.0]
    assert np.linalg.norm(floor.robot.truth().v_B[:2]) < 0.1


def test_a_mode_request_goes_through_the_mode_machine(floor):
    floor.remote.take_mode(Mode.BIPED)
    graph, _ = run(floor, 9.0)
    modes = [decode("/mobius/mode", data) for data in graph.sent["/mobius/mode"]]
    order = list(dict.fromkeys(modes))
    gathers = [Mode.GATHER] if load_policy(shipped_policy("crawl")).apart else []
    assert order == [Mode.CRAWL, *gathers, Mode.STAND_UP, Mode.BIPED]


def test_a_goal_is_planned_told_and_reached():
    served = build_served("demo", modes=("crawl",))
    served.errand._wait = True
    goal = served.world.grid.start + [1.0, 0.5]
    served.remote.take_goal(goal)
    graph, _ = run(served, 12.0)
    assert served.errand.state == "arrived"
    assert np.linalg.norm(served.robot.truth().p_OB[:2] - goal) < 0.6
    grid, path = graph.last("/map"), graph.last("/plan")
    assert grid.shape == served.world.grid.shape
    assert np.linalg.norm(path[-1] - goal) < 0.5
    assert len(graph.sent["/plan"]) == 1
    assert graph.last("/mobius/status")["goal"] == "arrived"


def test_it_ends_between_two_ticks_when_it_is_told_to(floor):
    begun = floor.stack.tick
    _, timing = run(floor, 5.0, ended=lambda: floor.stack.tick >= begun + 123)
    assert floor.stack.tick == begun + 123
    assert timing.simulated == pytest.approx(123 * TICK)


def test_its_log_shows_the_map_it_was_driven_on(tmp_path):
    served = build_served("demo", modes=("crawl",), seed=4)
    with McapRecorder(path=tmp_path / "run.mcap", about=served.about()) as recorder:
        run(served, 0.5, recorder=recorder)
    shown = open_run(tmp_path / "run.mcap")
    assert not shown.notes
    assert (shown.about.map, shown.about.seed) == ("demo", 4)
    assert shown.model().ngeom == served.robot.model.ngeom
    assert shown.about.versions["mujoco"]


def test_what_was_not_taken_is_in_the_status(floor):
    floor.remote.refused["/goal_pose"] = "goal: there is no map"
    graph, _ = run(floor, 1.0)
    assert graph.last("/mobius/status")["refused"] == ["/goal_pose: goal: there is no map"]
    floor.remote.refused.clear()


def test_a_map_that_physics_cannot_build_is_the_maps_mistake(monkeypatch):
    def wrong(*_, **__):
        raise ValueError("size 0 must be positive\nin geom")

    monkeypatch.setattr("mobius.world.scene.build_scene", wrong)
    with pytest.raises(MapError, match=r"map 'demo': physics cannot build it \(size 0 must be"):
        build_served("demo")
