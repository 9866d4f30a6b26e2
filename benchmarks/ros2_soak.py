"""A long run of ``mobius ros2``, listened to from outside: rate, latency, losses, memory.

    python benchmarks/ros2_soak.py [--seconds 600] [--map demo] [--json FILE]

Starts a Zenoh router, the program and a listener, each a process of its own, as on a robot. The
listener sends /cmd_vel at 10 Hz and takes down every message of /joint_states, /odom and /clock:
when it was sent (the attachment says) and when it came. Memory is the program's resident set,
once a second; its growth is the slope of a line through the last two thirds. CPU time per
second of the robot's own time tells what the program needs, however busy the machine is.

The bar: /joint_states at 60 Hz within 2 %, nothing lost, 99 % of the messages within 5 ms, memory
grows less than 1 MB a minute. ``miss_share`` is that of the 300 Hz loop.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from mobius.bridge.link import Node, open_session
from mobius.bridge.messages import TOPICS
from mobius.bridge.to_ros import STORE, cmd_vel
from mobius.bridge.wire import data_key, unpack_attachment
from mobius.files import write_json_atomic
from mobius.types import Mode, ModeCommand

HEARD = ("/joint_states", "/odom", "/clock")
TWIST = "geometry_msgs/msg/TwistStamped"
BARS = {"rate_hz": (58.8, 61.2), "lost": 0, "p99_ms": 5.0, "growth_mb_per_min": 1.0}
ROUTER = """
import json, sys, threading, zenoh
settings = zenoh.Config()
settings.insert_json5("mode", '"router"')
settings.insert_json5("listen/endpoints", json.dumps([sys.argv[1]]))
settings.insert_json5("scouting/multicast/enabled", "false")
session = zenoh.open(settings)
threading.Event().wait()
"""


class Ear:
    """Sequence numbers, times of sending and of arrival of one topic."""

    def __init__(self) -> None:
        self.rows: list[tuple[int, int, int]] = []

    def __call__(self, sample: Any) -> None:
        """Take one message down."""
        came = time.time_ns()
        beside = unpack_attachment(sample.attachment.to_bytes())
        self.rows.append((beside.sequence, beside.sent_ns, came))

    def figures(self) -> dict[str, float]:
        """Rate, losses and percentiles of the time from sending to arrival."""
        rows = np.array(self.rows, dtype=np.int64)
        late = 1e-6 * (rows[:, 2] - rows[:, 1])
        took = 1e-9 * (rows[-1, 1] - rows[0, 1])
        p50, p99, p999 = np.percentile(late, [50, 99, 99.9])
        return {
            "messages": len(rows),
            "rate_hz": (len(rows) - 1) / took,
            "lost": int(rows[-1, 0] - rows[0, 0] + 1 - len(rows)),
            "p50_ms": float(p50),
            "p99_ms": float(p99),
            "p999_ms": float(p999),
            "worst_ms": float(late.max()),
            "p99_last_third_ms": float(np.percentile(late[-len(late) // 3 :], 99)),
        }


def resident_mb(pid: int) -> float:
    """Resident memory of a process [MB]."""
    pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def cpu_s(pid: int) -> float:
    """CPU time that a process has used, all threads together [s]."""
    words = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")


def soak(seconds: float, name: str | None) -> dict[str, Any]:
    """Run router, robot and listener; returns the figures."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp/127.0.0.1:{free.getsockname()[1]}"
    router = subprocess.Popen([sys.executable, "-c", ROUTER, address])
    words = ["ros2", "--connect", address, "--domain", "0", *(["--map", name] if name else [])]
    robot = subprocess.Popen(
        [sys.executable, "-m", "mobius.cli", *words], stdout=subprocess.PIPE, text=True
    )
    try:
        figures = listen(address, robot.pid, seconds)
    finally:
        robot.send_signal(signal.SIGTERM)
        words = end_of(robot)
        router.kill()
        router.wait()
    return {"seconds": seconds, "map": name, "program_says": words, **figures}


def end_of(robot: subprocess.Popen[str]) -> str:
    """The program's last line; killed where it does not end."""
    try:
        return robot.communicate(timeout=30)[0].strip().splitlines()[-1]
    except subprocess.TimeoutExpired:
        robot.kill()
        return "did not end within 30 s of SIGTERM"


def listen(address: str, pid: int, seconds: float) -> dict[str, Any]:
    """What a node beside the robot hears in this time, while it drives the robot."""
    ears, memory, status = {topic: Ear() for topic in HEARD}, [], []
    session = open_session(connect=[address], listen=[], scouting=False)
    with session, Node("soak", connect=(address,)) as node:
        node.hear("/mobius/status", "std_msgs/msg/String", lambda m: status.append(m.data))
        speaker = node.speaker("/cmd_vel", TWIST)
        end = time.monotonic() + 60
        held = {
            t: session.declare_subscriber(data_key(0, t, TOPICS[t].type), ear)
            for t, ear in ears.items()
        }
        while not ears["/clock"].rows:
            if time.monotonic() > end:
                raise SystemExit("the robot was not heard within a minute")
            time.sleep(0.1)
        time.sleep(5.0)  # everything has been loaded once
        for ear in ears.values():
            ear.rows.clear()
        begin, used = time.monotonic(), cpu_s(pid)
        while (now := time.monotonic()) - begin < seconds:
            turn = 0.3 * np.sin(now)
            twist = ModeCommand(Mode.CRAWL, np.array([0.2, 0.0, turn]), now)
            speaker.send(STORE.serialize_cdr(cmd_vel(twist), TWIST))
            if len(memory) < now - begin:
                memory.append(resident_mb(pid))
            time.sleep(0.1)
        node.check()
        used = cpu_s(pid) - used
        for subscriber in held.values():
            subscriber.undeclare()
    kept = np.array(memory[len(memory) // 3 :])
    slope = float(np.polyfit(np.arange(len(kept)) / 60, kept, 1)[0]) if len(kept) > 1 else 0.0
    said = json.loads(status[-1]) if status else {}
    return {
        "topics": {topic: ear.figures() for topic, ear in ears.items()},
        "resident_mb": {"first": memory[0], "last": memory[-1], "growth_mb_per_min": slope},
        "cpu_s_per_robot_s": used / (len(ears["/clock"].rows) / TOPICS["/clock"].rate),
        "real_time_factor": said.get("real_time_factor"),
        "miss_share": said.get("miss_share"),
    }


def verdict(figures: dict[str, Any]) -> dict[str, bool]:
    """Which bars are met."""
    joints = figures["topics"]["/joint_states"]
    low, high = BARS["rate_hz"]
    return {
        "rate": bool(low <= joints["rate_hz"] <= high),
        "lost": all(t["lost"] == BARS["lost"] for t in figures["topics"].values()),
        "latency": joints["p99_ms"] <= BARS["p99_ms"],
        "memory": figures["resident_mb"]["growth_mb_per_min"] < BARS["growth_mb_per_min"],
    }


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=600.0)
    parser.add_argument("--map", default=None, help="a map, e.g. demo; an endless floor if not")
    parser.add_argument("--json", type=Path, default=None, help="file for the figures")
    args = parser.parse_args()
    figures = soak(args.seconds, args.map)
    figures["met"] = verdict(figures)
    figures["cpus"] = len(os.sched_getaffinity(0))
    figures["load_1min"] = os.getloadavg()[0]
    print(json.dumps(figures, indent=2))
    if args.json is not None:
        write_json_atomic(args.json, figures)
    return 0 if all(figures["met"].values()) else 1


if __name__ == "__main__":
    sys.exit(main())
