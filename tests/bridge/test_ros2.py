"""``mobius ros2`` as a node of another make sees it, through a router.

The other node is zenoh-ros2-sdk, which shares no code with the bridge but the message definitions.
No ROS is installed here: what is tested is the protocol.
"""

import json
import os
import random
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from mobius.bridge.messages import HEARD, TOPICS
from mobius.bridge.wire import data_key
from mobius.model.joints import JOINTS
from mobius.model.passive import PASSIVE
from mobius.model.urdf import build_urdf, fixed_frames

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
STRING, TWIST = "std_msgs/msg/String", "geometry_msgs/msg/Twist"


@pytest.fixture(scope="module")
def robot(router):
    """The program, on a map, listening and speaking through the router."""
    pytest.importorskip(
        "zenoh_ros2_sdk", reason="zenoh-ros2-sdk is not usable", exc_type=ImportError
    )
    process = subprocess.Popen(
        [
            sys.executable, "-m", "mobius.cli", "ros2", "--map", "demo",
            "--connect", f"tcp/127.0.0.1:{router}", "--domain", "0",
        ],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )  # fmt: skip
    yield process
    process.send_signal(signal.SIGTERM)
    out, err = process.communicate(timeout=20)
    assert process.returncode == 0, err
    assert "x real time" in out
    assert "Traceback" not in err


@pytest.fixture(scope="module")
def peer(robot, peers):
    """It comes when the robot is there already."""
    return peers()


def position(odom) -> np.ndarray:
    p = odom["message"]["pose"]["pose"]["position"]
    return np.array([p["x"], p["y"]])


def test_joint_states_come_at_60_hz_under_the_right_names(peer):
    peer.hear("/joint_states", "sensor_msgs/msg/JointState")
    messages = peer.wait(lambda: len(m := peer.of("/joint_states")) >= 121 and m[:121])
    assert tuple(messages[0]["message"]["name"]) == (*JOINTS, *PASSIVE)
    stamps = [m["message"]["header"]["stamp"] for m in messages]
    seconds = np.array([s["sec"] + 1e-9 * s["nanosec"] for s in stamps])
    np.testing.assert_allclose(np.diff(seconds), 1 / 60, atol=1e-6)  # none is missing
    took = messages[-1]["t"] - messages[0]["t"]
    assert took > 1.8  # two seconds of the wall's, less what is made good; more if it is busy


def test_who_comes_late_gets_the_description_and_the_static_frames(peer):
    peer.hear("/robot_description", STRING, latched=True)
    peer.hear("/tf_static", "tf2_msgs/msg/TFMessage", latched=True)
    (urdf,) = peer.wait(lambda: peer.of("/robot_description"))
    assert urdf["message"]["data"] == build_urdf()
    (static,) = peer.wait(lambda: peer.of("/tf_static"))
    children = [t["child_frame_id"] for t in static["message"]["transforms"]]
    assert children == ["odom", *(f.name for f in fixed_frames())]


def test_the_graph_shows_every_publisher_and_subscription(peer):
    tokens = peer.wait(lambda: peer.order(do="graph")["graph"])
    ours = [t.split("/") for t in tokens if "/%/%/mobius" in t]
    spoken = {p[9].replace("%", "/") for p in ours if p[5] == "MP"}
    live = {t.name for t in TOPICS.values() if t.where != "log" and "camera" not in t.name}
    assert spoken == live
    heard = sorted(p[9].replace("%", "/") for p in ours if p[5] == "MS")
    assert heard == sorted(h.name for h in HEARD)
    assert sum(p[5] == "NN" for p in ours) == 1


@pytest.mark.parametrize("kind", ["Twist", "TwistStamped"])
def test_a_velocity_from_outside_drives_the_robot_and_silence_stops_it(kind, peer):
    peer.hear("/odom", "nav_msgs/msg/Odometry")
    peer.hear("/mobius/command", "geometry_msgs/msg/TwistStamped")
    begun = time.monotonic()
    begin = position(peer.wait(lambda: peer.of("/odom"))[-1])
    twist = {"linear": {"x": 0.3}}
    fields = twist if kind == "Twist" else {"twist": twist}

    def gone() -> float:
        return float(np.linalg.norm(position(peer.of("/odom")[-1]) - begin))

    def push() -> bool:
        peer.say("/cmd_vel", f"geometry_msgs/msg/{kind}", **fields)
        return gone() > 0.2

    peer.wait(push)
    silent = time.monotonic()

    def speed(heard):
        return heard["message"]["twist"]["linear"]["x"]

    said = [c for c in peer.of("/mobius/command") if c["t"] > begun]
    assert max(speed(c) for c in said) == pytest.approx(0.3)
    peer.wait(  # half a second on a clock of its own is tested in test_pilot.py
        lambda: [c for c in peer.of("/mobius/command") if c["t"] > silent and speed(c) == 0.0]
    )
    count = len(peer.of("/odom"))
    peer.wait(lambda: len(peer.of("/odom")) > count + 100)  # a second and a half of its time
    places = np.array([position(o) for o in peer.of("/odom")[count:]])
    assert np.linalg.norm(places[-1] - places[60]) < 0.03


def test_a_goal_from_outside_is_planned_and_the_controls_taken_end_it(peer):
    peer.hear("/plan", "nav_msgs/msg/Path", latched=True)
    peer.hear("/mobius/status", STRING)

    def goal():
        said = peer.of("/mobius/status")
        return json.loads(said[-1]["message"]["data"])["goal"] if said else None

    place = {"header": {"frame_id": "map"}, "pose": {"position": {"x": 7.3, "y": 3.2}}}
    peer.wait(lambda: peer.say("/goal_pose", "geometry_msgs/msg/PoseStamped", **place) or
              peer.of("/plan"))  # fmt: skip
    last = peer.of("/plan")[-1]["message"]["poses"][-1]["pose"]["position"]
    assert abs(last["x"] - 7.3) < 0.5 and abs(last["y"] - 3.2) < 0.5
    peer.wait(lambda: goal() == "driving")
    peer.say("/cmd_vel", TWIST)
    peer.wait(lambda: goal() == "idle")


def test_garbage_on_any_topic_does_not_end_the_program(robot, peer, router):
    import zenoh

    rng = random.Random(0)
    settings = zenoh.Config()
    settings.insert_json5("mode", '"client"')
    settings.insert_json5("connect/endpoints", json.dumps([f"tcp/127.0.0.1:{router}"]))
    settings.insert_json5("scouting/multicast/enabled", "false")
    with zenoh.open(settings) as session:
        for heard in HEARD:
            key = data_key(0, heard.name, heard.type)
            for k in range(40):
                body = rng.randbytes(rng.choice([0, 1, 3, 4, 8, 20, 60, 300]))
                header = b"\x00\x01\x00\x00" if k % 2 else b""
                session.put(key, header + body, attachment=rng.randbytes(k))
    peer.hear("/clock", "rosgraph_msgs/msg/Clock")
    peer.wait(lambda: len(peer.of("/clock")) > 60)
    assert robot.poll() is None
    peer.say("/mobius/emergency_stop", "std_msgs/msg/Bool", data=False)  # garbage may stop it


def test_a_stop_from_outside_stops_and_its_release_gets_up_again(peer):
    peer.hear("/mobius/mode", STRING)

    def modes():
        return [m["message"]["data"] for m in peer.of("/mobius/mode")]

    peer.wait(lambda: modes()[-1:] == ["crawl"])
    peer.say("/mobius/emergency_stop", "std_msgs/msg/Bool", data=True)
    peer.wait(lambda: modes()[-1:] == ["stop"])
    peer.say("/mobius/emergency_stop", "std_msgs/msg/Bool", data=False)
    peer.wait(lambda: modes()[-1:] == ["crawl"])


def test_every_listening_socket_is_bound_to_loopback(robot):
    """Read from the kernel's own tables, not from our settings."""
    inodes = set()
    for fd in os.listdir(f"/proc/{robot.pid}/fd"):
        try:
            inodes.add(os.readlink(f"/proc/{robot.pid}/fd/{fd}"))
        except FileNotFoundError:
            continue
    found = []
    for table in ("tcp", "tcp6", "udp", "udp6"):
        with open(f"/proc/{robot.pid}/net/{table}") as lines:
            for line in lines.readlines()[1:]:
                words = line.split()
                open_to_all = words[3] == "0A" if table.startswith("tcp") else True
                if open_to_all and f"socket:[{words[9]}]" in inodes:
                    found.append((table, words[1].split(":")[0]))
    loopback = {"0100007F", "00000000000000000000000001000000"}
    assert found, "the program listens somewhere"
    assert {address for _, address in found} <= loopback, found
