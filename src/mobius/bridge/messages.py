"""What goes out under which ROS 2 topic, and what is heard: one table for log and bridge.

The bytes are ROS 2 CDR made by rosbags (``00 01 00 00``, then little endian). Topic
names are the ones that rviz, Nav2, Foxglove and ros2_control already know.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Literal

from mobius.bridge import camera as eye
from mobius.bridge import from_ros as back
from mobius.bridge import to_ros as out
from mobius.errors import UnknownName

__all__ = ["CLOCK_HZ", "HEARD", "TOPICS", "Heard", "Topic", "decode", "due_rows", "encode"]

_Codec = Callable[[Any], Any]

CLOCK_HZ = 600
"""Base clock of the stack [Hz]; every rate in the table divides it."""


@dataclass(frozen=True)
class Topic:
    """One row of the table of what is said."""

    name: str
    type: str
    """ROS type, such as ``sensor_msgs/msg/JointState``."""
    noun: str
    """Which argument of :class:`mobius.bridge.record.McapRecorder` or
    :class:`mobius.bridge.live.Live` feeds it."""
    rate: int
    """How often it is said [Hz]; 0: when it is new, and late subscribers hear it (latched)."""
    to_ros: _Codec
    """Noun to message, or to None when the device did not tick."""
    from_ros: _Codec
    """Message to noun, or to the arrays a noun is made of."""
    where: Literal["both", "log", "live"] = "both"
    """Whether it is recorded, published live, or both."""

    @property
    def latched(self) -> bool:
        """Whether the topic is published as transient_local."""
        return self.rate == 0


@dataclass(frozen=True)
class Heard:
    """One row of the table of what is listened to."""

    name: str
    type: str
    """ROS type; a topic may be heard in several."""
    noun: str
    """Which ``take_`` method of :class:`mobius.bridge.pilot.Remote` gets it."""
    from_ros: _Codec
    """Message to what that method takes; raises :class:`InvalidInput`."""
    says: str
    """What it is for, for the table of the documents."""


def _row(
    name: str,
    kind: str,
    noun: str,
    rate: int,
    to: _Codec,
    from_: _Codec,
    where: Literal["both", "log", "live"] = "both",
) -> Topic:
    return Topic(name, kind.replace("/", "/msg/"), noun, rate, to, from_, where)


_JOINTS = "sensor_msgs/JointState"
_WRENCH = "geometry_msgs/WrenchStamped"
_POSES = "geometry_msgs/PoseArray"
_STRING = "std_msgs/String"
_STAMPED = "geometry_msgs/TwistStamped"

# All ticks but the camera's are multiples of ten: calling at 60 Hz misses nothing. The
# VIO camera speaks at every third tick only, so it is said at every thirtieth.
_ROWS = (
    _row("/clock", "rosgraph_msgs/Clock", "clock", 60, out.clock, back.clock),
    _row("/joint_states", _JOINTS, "frame", 60, out.joints, back.joints),
    _row("/imu/data", "sensor_msgs/Imu", "frame", 30, out.imu, back.imu),
    _row("/left_gripper/wrench", _WRENCH, "frame", 30, out.left_wrench, back.wrench),
    _row("/right_gripper/wrench", _WRENCH, "frame", 30, out.right_wrench, back.wrench),
    _row("/mobius/vio", "geometry_msgs/PoseStamped", "frame", 20, out.vio, back.vio),
    _row("/odom", "nav_msgs/Odometry", "belief", 60, out.odometry, back.odometry),
    _row("/tf", "tf2_msgs/TFMessage", "belief", 30, out.tf, back.transform),
    _row("/cmd_vel", _STAMPED, "command", 30, out.cmd_vel, back.cmd_vel, "log"),
    _row("/mobius/command", _STAMPED, "command", 30, out.cmd_vel, back.cmd_vel, "live"),
    _row("/mobius/mode", _STRING, "command", 10, out.mode, back.mode),
    _row(
        "/mobius/contacts", "std_msgs/Float64MultiArray", "belief", 30, out.contacts, back.contacts
    ),
    _row("/mobius/joint_targets", _JOINTS, "target", 30, out.targets, back.targets),
    _row("/mobius/ground_truth", "nav_msgs/Odometry", "truth", 30, out.ground_truth, back.odometry),
    _row("/mobius/status", _STRING, "status", 2, out.status, back.status, "live"),
    _row(
        "/camera/color/image_raw", "sensor_msgs/Image", "picture", 10, eye.image, eye.pixels, "live"
    ),
    _row(
        "/camera/color/camera_info",
        "sensor_msgs/CameraInfo",
        "picture",
        10,
        eye.info,
        eye.focal,
        "live",
    ),
    _row("/map", "nav_msgs/OccupancyGrid", "grid", 0, out.occupancy_grid, back.occupancy_grid),
    _row("/plan", "nav_msgs/Path", "plan", 0, out.path, back.path),
    _row("/mobius/plan_modes", _STRING, "plan", 0, out.plan_modes, back.plan_modes),
    _row("/mobius/obstacles", _POSES, "obstacles", 0, out.obstacles, back.obstacles, "log"),
    _row("/tf_static", "tf2_msgs/TFMessage", "pose_MO", 0, out.tf_static, back.transform),
    _row("/robot_description", _STRING, "description", 0, out.text, back.text),
)

TOPICS: dict[str, Topic] = {row.name: row for row in _ROWS}
"""Every topic we speak, by name."""

_TWIST = "velocity in base_footprint; 0.5 s of silence stop the robot"
HEARD: tuple[Heard, ...] = (
    Heard("/cmd_vel", "geometry_msgs/msg/Twist", "twist", back.cmd_vel, _TWIST),
    Heard("/cmd_vel", "geometry_msgs/msg/TwistStamped", "twist", back.cmd_vel, _TWIST),
    Heard("/joy", "sensor_msgs/msg/Joy", "joy", back.joy, "gamepad; moves only while L1 is held"),
    Heard(
        "/goal_pose",
        "geometry_msgs/msg/PoseStamped",
        "goal",
        back.goal,
        "a place on the map to plan and go to (rviz: 2D Goal Pose)",
    ),
    Heard(
        "/mobius/mode_request",
        "std_msgs/msg/String",
        "mode",
        back.mode,
        "a mode to be in: crawl, biped, roll, push_ups, stop",
    ),
    Heard(
        "/mobius/emergency_stop",
        "std_msgs/msg/Bool",
        "stop",
        back.flag,
        "true: soft servos at once; false: release",
    ),
)
"""Every topic we listen to while live."""


def due_rows(rows: Iterable[Topic]) -> list[tuple[Topic, ...]]:
    """Rows that are due at each tick of one second of the base clock; latched ones never are."""
    periodic = [row for row in rows if not row.latched]
    return [
        tuple(row for row in periodic if tick % (CLOCK_HZ // row.rate) == 0)
        for tick in range(CLOCK_HZ)
    ]


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
