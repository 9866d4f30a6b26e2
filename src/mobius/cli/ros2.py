"""``mobius ros2``: the live robot as a node of the ROS 2 graph, without ROS installed here."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from threading import Event
from typing import Any

from mobius.cli.common import XY, at_least, place
from mobius.errors import InvalidInput

MOST_DOMAIN = 232
"""ROS_DOMAIN_ID is at most this."""


@dataclass
class Ros2:
    """Drive the live robot from ROS 2: /cmd_vel, /joy, /goal_pose, rviz2, Foxglove."""

    map: str | None = None
    """A Nav2 map.yaml, a MovingAI .map, or the name of a shipped map; an endless floor if left
    out. With a map there are /map and /goal_pose."""
    start: XY | None = None
    """Where the robot starts: x y [m] in the map frame; the map's own if left out."""
    modes: tuple[str, ...] = ("crawl", "biped", "roll", "push_ups")
    """Modes that may be asked for, joined by commas or spaces; plans use crawl, biped and roll."""
    seconds: float | None = None
    """How long [s], > 0; until Ctrl-C if left out."""
    domain: int | None = None
    """ROS_DOMAIN_ID, 0 to 232; that of the environment, else 0, if left out."""
    connect: tuple[str, ...] = ()
    """Where the Zenoh router is, or other nodes; tcp/127.0.0.1:7447 if left out."""
    listen: tuple[str, ...] = ()
    """Where others may connect; a free loopback port if left out. An address of the network lets
    everybody there drive the robot."""
    scouting: bool = False
    """Look for others, and be found, by multicast on the network."""
    speed: float = 1.0
    """Share of the fastest twist that is let through, in (0, 1]."""
    deadman: int = 4
    """Button of /joy that must be held to move, >= 0."""
    camera: bool = False
    """Publish pictures of the head camera (needs OpenGL)."""
    record: Path | None = None
    """Log to write as it goes, new, ends in .mcap."""
    policy: str | None = None
    """ONNX file, or flat or rough, for the crawling robot; rough where the map is, if left out."""
    seed: int = 0
    """Seed of friction, mass, delay and sensor drift, with --randomised; >= 0."""
    randomised: bool = False
    """Draw robot, floor and sensors from the seed."""

    def __call__(self) -> int:
        """Serve until the time is over or Ctrl-C."""
        from mobius.headless import import_mujoco

        domain, modes = self._check(), self._modes()
        import_mujoco()
        from mobius.bridge.link import HERE, ROUTER, Node
        from mobius.bridge.record import McapRecorder
        from mobius.mission.serve import build_served, serve
        from mobius.pace import Pace, hurry

        served = build_served(
            self.map,
            start=self.start,
            modes=modes,
            seed=self.seed,
            randomised=self.randomised,
            policy=self.policy,
            speed=self.speed,
            deadman=self.deadman,
        )
        pace = Pace(served.stack)
        hurry()
        connect, listen = self.connect or (ROUTER,), self.listen or (HERE,)
        with ExitStack() as held:
            if served.errand is not None:
                held.callback(served.errand.close)
            pictures = self._pictures(held, served)
            node = held.enter_context(
                Node(domain=domain, connect=connect, listen=listen, scouting=self.scouting)
            )
            recorder = None  # begun last: what fails before leaves no log
            if self.record is not None:
                recorder = held.enter_context(McapRecorder(path=self.record, about=served.about()))
            print(advice(domain, connect, with_map=self.map is not None), flush=True)
            ended = held.enter_context(ends_between_ticks())
            serve(
                served,
                node,
                seconds=self.seconds,
                pace=pace,
                recorder=recorder,
                pictures=pictures,
                ended=ended.is_set,
            )
        if recorder is not None:
            print(f"log          {self.record}")
        t = pace.timing()
        print(
            f"{t.simulated:.1f} s at {t.factor:.3f} x real time, {100 * t.miss_share:.2f} % of"
            f" {t.rounds} rounds late, {t.dropped:.2f} s given up"
        )
        return 0

    def _check(self) -> int:
        """Refuse options that make no sense, before any work; returns the domain."""
        at_least("--seed", self.seed, 0)
        at_least("--deadman", self.deadman, 0)
        place("--start", self.start)
        if self.start is not None and self.map is None:
            raise InvalidInput("--start: expected a --map to start on")
        if self.seconds is not None and not 0 < self.seconds < 1e9:
            raise InvalidInput(f"--seconds: expected seconds > 0, got {self.seconds:g}")
        if self.record is not None and self.record.suffix != ".mcap":
            raise InvalidInput(f"--record: expected a file that ends in .mcap, got {self.record}")
        return self._domain()

    def _modes(self) -> list[str]:
        modes = [m for word in self.modes for m in word.split(",") if m]
        if not modes:
            raise InvalidInput("--modes: expected at least crawl or biped, got none")
        return modes

    def _domain(self) -> int:
        said = os.environ.get("ROS_DOMAIN_ID") or "0"
        name, value = "ROS_DOMAIN_ID", said
        if self.domain is not None:
            name, value = "--domain", str(self.domain)
        if not value.isascii() or not value.isdigit() or int(value) > MOST_DOMAIN:
            raise InvalidInput(
                f"{name}: expected a whole number from 0 to {MOST_DOMAIN}, got '{value}'"
            )
        return int(value)

    def _pictures(self, held: ExitStack, served: Any) -> Any:
        """Who takes pictures, or None."""
        if not self.camera:
            return None
        from mobius.mission.eye import HeadCamera

        return held.enter_context(HeadCamera(served.robot.model))


@contextmanager
def ends_between_ticks() -> Iterator[Event]:
    """Ctrl-C, and SIGTERM as service managers send it, set an event: the tick is finished and the
    log closed, no message of it is torn. A second one ends the program at once.
    """
    ended = Event()

    def end(*_: object) -> None:
        if ended.is_set():
            raise KeyboardInterrupt
        ended.set()

    before: dict[int, Any] = {signal.SIGTERM: signal.signal(signal.SIGTERM, end)}
    if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:  # a shell's background job
        before[signal.SIGINT] = signal.signal(signal.SIGINT, end)
    try:
        yield ended
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def advice(domain: int, connect: tuple[str, ...], *, with_map: bool) -> str:
    """What to type on the ROS side."""
    goal = (
        ""
        if not with_map
        else (
            "\n  ros2 topic pub --once /goal_pose geometry_msgs/msg/PoseStamped \\"
            '\n    "{header: {frame_id: map}, pose: {position: {x: 6.0, y: 3.0}}}"'
        )
    )
    return f"""\
mobius is a node of ROS domain {domain}; stop with Ctrl-C. It connects to {", ".join(connect)}.
On the ROS 2 side (Jazzy or newer), in every shell:
  export RMW_IMPLEMENTATION=rmw_zenoh_cpp ROS_DOMAIN_ID={domain}
  ros2 run rmw_zenoh_cpp rmw_zenohd                      # the router, once
  ros2 topic echo /joint_states --once
  ros2 run teleop_twist_keyboard teleop_twist_keyboard   # drive; silence stops
  ros2 topic pub --once /mobius/mode_request std_msgs/msg/String "{{data: biped}}"
  ros2 topic pub --once /mobius/emergency_stop std_msgs/msg/Bool "{{data: true}}"{goal}
See docs/ros2.md for rviz2, Foxglove and gamepads."""
