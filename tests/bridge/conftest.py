"""Nouns to send, and another make of ROS 2 node to send them to."""

import importlib.util
import json
import queue
import socket
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from mobius.assemble import Start, build_sim_stack
from mobius.bridge.about import About
from mobius.bridge.camera import Picture
from mobius.bridge.record import McapRecorder
from mobius.mission import open_world
from mobius.model.robot import load_spec
from mobius.types import (
    GridMap,
    JointCommand,
    Mode,
    ModeCommand,
    Plan,
    Pose,
    SensorFrame,
    StateEstimate,
)
from mobius.world.scene import build_scene

YAW_90 = np.array([np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)])


@pytest.fixture
def nouns():
    """One of every noun, no two numbers alike where a swap could hide."""
    rng = np.random.default_rng(3)
    blocked = np.zeros((3, 2), dtype=bool)
    blocked[2, 0] = True
    cells = np.array([[0, 0], [1, 0], [1, 1]])
    grid = GridMap(
        name="room",
        cell=0.5,
        origin_M=np.array([-1.0, 2.0, 0.25]),
        blocked=blocked,
        allowed=np.full((3, 2), 7, dtype=np.uint8),
    )
    cov = rng.normal(size=(12, 12))
    return {
        "clock": 1.5,
        "frame": SensorFrame(
            stamp=1.5,
            q=rng.normal(size=22),
            dq=rng.normal(size=22),
            torque=rng.normal(size=22),
            wrench_S=rng.normal(size=(2, 6)),
            gyro_I=rng.normal(size=3),
            accel_I=rng.normal(size=3),
            vio=Pose(p=np.array([1.0, 2.0, 3.0]), q=YAW_90),
        ),
        "belief": StateEstimate(
            stamp=1.5,
            p_OB=np.array([0.1, 0.2, 0.3]),
            q_OB=YAW_90,
            v_B=np.array([0.4, 0.5, 0.6]),
            w_B=np.array([0.7, 0.8, 0.9]),
            contact=np.zeros(4),
            cov=cov,
        ),
        "truth": StateEstimate(
            stamp=1.5,
            p_OB=np.array([1.1, 1.2, 1.3]),
            q_OB=YAW_90,
            v_B=np.array([1.4, 1.5, 1.6]),
            w_B=np.array([1.7, 1.8, 1.9]),
            contact=np.zeros(4),
        ),
        "command": ModeCommand(mode=Mode.CRAWL, twist_H=np.array([0.3, -0.1, 0.2]), stamp=1.5),
        "target": JointCommand(q=rng.normal(size=22), stamp=1.5),
        "grid": grid,
        "plan": Plan(
            cells=cells,
            modes=(Mode.CRAWL, Mode.BIPED),
            xy_M=grid.center_of(cells),
            status="optimal",
            objective=2.5,
            bound=2.5,
            solve_s=0.01,
        ),
        "obstacles": np.array([[1.0, 2.0, 0.5, *YAW_90], [0.0, 0.0, -20.0, 1.0, 0.0, 0.0, 0.0]]),
        "description": "<robot name='mobius'/>",
        "status": {"mode": "crawl", "notice": ""},
        "picture": Picture(
            stamp=1.5,
            pixels=rng.integers(0, 256, size=(4, 6, 3), dtype=np.uint8),
            focal=5.0,
        ),
        "pose_MO": Pose(p=np.array([5.0, 6.0, 0.0]), q=YAW_90),
    }


class Drive(NamedTuple):
    """Two seconds of crawling, as a recorder is told them."""

    samples: list
    truths: list
    scene: str
    about: About
    grid: GridMap

    def tell(self, recorder):
        """All of it, to a recorder."""
        recorder.once(grid=self.grid, pose_MO=Pose(p=np.zeros(3), q=np.array([1.0, 0, 0, 0])))
        for sample, truth in zip(self.samples, self.truths, strict=True):
            recorder.see(sample, truth)


@pytest.fixture(scope="session")
def drive():
    """Real physics on the demo map, ahead and turning for 2 s."""
    world = open_world("demo")
    spec = build_scene(world, load_spec("full"))
    model = spec.compile()
    scene = spec.to_xml()
    start = Start(xy=tuple(world.grid.start), seed=3)
    stack, robot = build_sim_stack(model, start)
    samples, truths = [], []
    for _ in range(1200):
        sample = stack.turn(lambda b: ModeCommand(Mode.CRAWL, np.array([0.4, 0.0, 0.3]), b.stamp))
        if sample is not None:
            samples.append(sample)
            truths.append(robot.truth())
    about = About(
        map="demo", seed=3, variation=asdict(robot.variation), versions={"a": "1"}, scene=scene
    )
    return Drive(samples, truths, scene, about, world.grid)


@pytest.fixture
def run_file(drive, tmp_path):
    """The same two seconds as a log."""
    recorder = McapRecorder(about=drive.about)
    drive.tell(recorder)
    recorder.save(tmp_path / "run.mcap")
    return tmp_path / "run.mcap"


class Peer:
    """The other node; see ``peer.py``."""

    def __init__(self, port: int, folder: Path) -> None:
        self._process = subprocess.Popen(
            [sys.executable, str(Path(__file__).with_name("peer.py")), str(port), str(folder)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self.heard: list[dict[str, Any]] = []
        self._answers: queue.Queue[dict[str, Any]] = queue.Queue()
        threading.Thread(target=self._read, daemon=True).start()
        assert self._answers.get(timeout=90) == {"ready": True}

    def _read(self) -> None:
        for line in self._process.stdout:
            words = json.loads(line)
            if "topic" in words:
                self.heard.append(words)
            else:
                self._answers.put(words)

    def order(self, **words: Any) -> dict[str, Any]:
        """Make it do something; returns what it answers."""
        self._process.stdin.write(json.dumps(words) + "\n")
        self._process.stdin.flush()
        answer = self._answers.get(timeout=90)
        if "done" not in answer:
            assert "done" in self._answers.get(timeout=90)
        return answer

    def hear(self, topic: str, kind: str, *, latched: bool = False) -> None:
        self.order(do="hear", topic=topic, type=kind, latched=latched)

    def say(self, topic: str, kind: str, **fields: Any) -> None:
        self.order(do="say", topic=topic, type=kind, fields=fields)

    def of(self, topic: str) -> list[dict[str, Any]]:
        """Messages heard under a topic so far."""
        return [h for h in list(self.heard) if h["topic"] == topic]

    def wait(self, what: Callable[[], Any], seconds: float = 90.0) -> Any:
        """Wait until something is true; returns it."""
        ends = time.monotonic() + seconds
        while time.monotonic() < ends:
            if found := what():
                return found
            time.sleep(0.02)
        raise AssertionError(
            f"nothing in {seconds} s; heard {Counter(h['topic'] for h in self.heard)}"
        )

    def close(self) -> None:
        self._process.stdin.close()
        try:
            self._process.wait(timeout=5)
        except subprocess.TimeoutExpired:
            self._process.kill()


@pytest.fixture(scope="session")
def write_definitions():
    """Writes .msg files for the other implementation."""
    spec = importlib.util.spec_from_file_location("peer", Path(__file__).with_name("peer.py"))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.write_definitions


@pytest.fixture(scope="session")
def definitions(tmp_path_factory, write_definitions):
    """Message definitions for the peer."""
    folder = tmp_path_factory.mktemp("messages")
    write_definitions(folder)
    return folder


@pytest.fixture(scope="session")
def router():
    """The port of a Zenoh router on the loopback interface, as rmw_zenohd is one."""
    zenoh = pytest.importorskip("zenoh", reason="eclipse-zenoh is not installed")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    settings = zenoh.Config()
    for key, value in {
        "mode": "router",
        "listen/endpoints": [f"tcp/127.0.0.1:{port}"],
        "connect/endpoints": [],
        "scouting/multicast/enabled": False,
        "timestamping/enabled": True,
    }.items():
        settings.insert_json5(key, json.dumps(value))
    session = zenoh.open(settings)
    yield port
    session.close()


@pytest.fixture(scope="module")
def peers(router, definitions):
    """Makes peers that end with the module's tests."""
    pytest.importorskip(
        "zenoh_ros2_sdk", reason="zenoh-ros2-sdk is not usable", exc_type=ImportError
    )
    made: list[Peer] = []

    def make() -> Peer:
        made.append(Peer(router, definitions))
        return made[-1]

    yield make
    for peer in made:
        peer.close()
