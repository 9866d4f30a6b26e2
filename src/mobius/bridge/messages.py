"""Which noun goes out under which ROS 2 topic: one table for the log and for every bridge.

The bytes are ROS 2 CDR made by rosbags (``00 01 00 00``, then little endian). Topic
names are the ones that rviz, Nav2, Foxglove and ros2_control already know.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from mobius.bridge import from_ros as back
from mobius.bridge import to_ros as out
from mobius.errors import UnknownName

__all__ = ["CLOCK_HZ", "TOPICS", "Topic", "decode", "encode"]

_Codec = Callable[[Any], Any]

CLOCK_HZ = 600
"""Base clock of the stack [Hz]; every rate in the table divides it."""


@dataclass(frozen=True)
class Topic:
    """One row of the table."""

    name: str
    type: str
    """ROS type, such as ``sensor_msgs/msg/JointState``."""
    noun: str
    """Which argument of :class:`mobius.bridge.record.McapRecorder` feeds it."""
    rate: int
    """How often it is recorded [Hz]; 0: once, and late subscribers hear it (latched)."""
    to_ros: _Codec
    """Noun to message, or to None when the device did not tick."""
    from_ros: _Codec
    """Message to noun, or to the arrays a noun is made of."""

    @property
    def latched(self) -> bool:
        """Whether the topic is published once, as transient_local."""
        return self.rate == 0


def _row(name: str, kind: str, noun: str, rate: int, to: _Codec, from_: _Codec) -> Topic:
    return Topic(name, kind.replace("/", "/msg/"), noun, rate, to, from_)


_JOINTS = "sensor_msgs/JointState"
_WRENCH = "geometry_msgs/WrenchStamped"
_POSES = "geometry_msgs/PoseArray"

# All recorded ticks are multiples of ten: calling the recorder at 60 Hz misses nothing. The
# VIO camera speaks at every third tick only, so it is recorded at every thirtieth.
_ROWS = (
    _row("/clock", "rosgraph_msgs/Clock", "clock", 10, out.clock, back.clock),
    _row("/joint_states", _JOINTS, "frame", 60, out.joints, back.joints),
    _row("/imu/data", "sensor_msgs/Imu", "frame", 30, out.imu, back.imu),
    _row("/left_gripper/wrench", _WRENCH, "frame", 30, out.left_wrench, back.wrench),
    _row("/right_gripper/wrench", _WRENCH, "frame", 30, out.right_wrench, back.wrench),
    _row("/mobius/vio", "geometry_msgs/PoseStamped", "frame", 20, out.vio, back.vio),
    _row("/odom", "nav_msgs/Odometry", "belief", 60, out.odometry, back.odometry),
    _row("/tf", "tf2_msgs/TFMessage", "belief", 30, out.tf, back.transform),
    _row("/cmd_vel", "geometry_msgs/TwistStamped", "command", 30, out.cmd_vel, back.cmd_vel),
    _row("/mobius/mode", "std_msgs/String", "command", 10, out.mode, back.mode),
    _row(
        "/mobius/contacts", "std_msgs/Float64MultiArray", "belief", 30, out.contacts, back.contacts
    ),
    _row("/mobius/joint_targets", _JOINTS, "target", 30, out.targets, back.targets),
    _row("/mobius/ground_truth", "nav_msgs/Odometry", "truth", 30, out.ground_truth, back.odometry),
    _row("/map", "nav_msgs/OccupancyGrid", "grid", 0, out.occupancy_grid, back.occupancy_grid),
    _row("/plan", "nav_msgs/Path", "plan", 0, out.path, back.path),
    _row("/mobius/plan_modes", "std_msgs/String", "plan", 0, out.plan_modes, back.plan_modes),
    _row("/mobius/obstacles", _POSES, "obstacles", 0, out.obstacles, back.obstacles),
    _row("/tf_static", "tf2_msgs/TFMessage", "pose_MO", 0, out.tf_static, back.transform),
)

TOPICS: dict[str, Topic] = {row.name: row for row in _ROWS}
"""Every topic we speak, by name."""


def topic(name: str) -> Topic:
    """The row of a topic. Raises :class:`UnknownName`."""
    try:
        return TOPICS[name]
    except KeyError:
        raise UnknownName("topic", name, TOPICS) from None


def encode(name: str, noun: Any) -> memoryview | None:
    """CDR bytes of a noun under a topic, or None when its device did not tick."""
    row = topic(name)
    message = row.to_ros(noun)
    return None if message is None else out.STORE.serialize_cdr(message, row.type)


def decode(name: str, data: bytes | memoryview) -> Any:
    """What CDR bytes heard under a topic say, as the topic's ``from_ros`` gives it."""
    row = topic(name)
    return row.from_ros(out.STORE.deserialize_cdr(data, row.type))
