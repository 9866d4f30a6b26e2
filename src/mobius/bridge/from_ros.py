"""ROS 2 messages as our nouns, or as the arrays a noun is made of."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mobius.errors import InvalidInput
from mobius.geometry import quat_to_rpy
from mobius.model.joints import JOINTS
from mobius.model.passive import PASSIVE
from mobius.types import ALL_MODES_BITS, LIMBS, GridMap, JointCommand, Mode, Pose, StateEstimate

Array = NDArray[np.float64]


def _stamp(header: Any) -> float:
    return float(header.stamp.sec + 1e-9 * header.stamp.nanosec)


def _vector(v: Any) -> Array:
    return np.array([v.x, v.y, v.z])


def _quaternion(q: Any) -> Array:
    return np.array([q.w, q.x, q.y, q.z])


def _pose(message: Any) -> Pose:
    return Pose(p=_vector(message.position), q=_quaternion(message.orientation))


def clock(message: Any) -> float:
    """Time [s]."""
    return float(message.clock.sec + 1e-9 * message.clock.nanosec)


def _in_joint_order(message: Any) -> NDArray[np.int64]:
    """Where each of JOINTS stands in the message, which may list them in any order, and the
    passive joints with them.
    """
    names = [name for name in message.name if name not in PASSIVE]
    if sorted(names) != sorted(JOINTS):
        wrong = sorted(set(names) ^ set(JOINTS)) or ["a name twice"]
        raise InvalidInput(
            f"JointState.name: expected the {len(JOINTS)} joints of mobius.model.JOINTS,"
            f" got {len(names)} names; at odds: {', '.join(wrong)}"
        )
    places = list(message.name)
    return np.array([places.index(joint) for joint in JOINTS])


def joints(message: Any) -> tuple[Array, Array, Array]:
    """Angles [rad], rates [rad/s], torques [N m], each (22,) in the order of JOINTS."""
    order = _in_joint_order(message)
    return message.position[order], message.velocity[order], message.effort[order]


def targets(message: Any) -> JointCommand:
    """Position targets in the order of JOINTS."""
    order = _in_joint_order(message)
    return JointCommand(q=message.position[order], stamp=_stamp(message.header))


def imu(message: Any) -> tuple[Array, Array]:
    """Angular rate (3,) [rad/s] and specific force (3,) [m/s^2]."""
    return _vector(message.angular_velocity), _vector(message.linear_acceleration)


def wrench(message: Any) -> Array:
    """(6,) force [N] and torque [N m]."""
    return np.concatenate([_vector(message.wrench.force), _vector(message.wrench.torque)])


def vio(message: Any) -> Pose:
    """Trunk pose in the camera's own drifting frame."""
    return _pose(message.pose)


def odometry(message: Any) -> StateEstimate:
    """Pose and twist; Odometry knows no contacts, they come back as zeros."""
    cov = np.zeros((12, 12))
    pose_cov = np.reshape(message.pose.covariance, (2, 3, 2, 3))[::-1, :, ::-1]
    twist_cov = np.reshape(message.twist.covariance, (2, 3, 2, 3))[::-1, :, ::-1]
    cov[:6, :6], cov[6:, 6:] = pose_cov.reshape(6, 6), twist_cov.reshape(6, 6)
    return StateEstimate(
        stamp=_stamp(message.header),
        p_OB=_vector(message.pose.pose.position),
        q_OB=_quaternion(message.pose.pose.orientation),
        v_B=_vector(message.twist.twist.linear),
        w_B=_vector(message.twist.twist.angular),
        contact=np.zeros(4),
        cov=cov,
    )


def contacts(message: Any) -> Array:
    """(4,) probability of ground contact per limb, order LIMBS. Raises InvalidInput."""
    data = np.array(message.data, dtype=float)
    if data.shape != (len(LIMBS),):
        raise InvalidInput(f"contacts: expected {len(LIMBS)} numbers, got {len(data)}")
    return data


def obstacles(message: Any) -> Array:
    """(k, 7) poses in map: x y z [m], qw qx qy qz."""
    rows = [[*_vector(p.position), *_quaternion(p.orientation)] for p in message.poses]
    return np.array(rows).reshape(-1, 7)


def transform(message: Any) -> Pose:
    """Pose of the child in the parent of the message's first transform."""
    tf = message.transforms[0].transform
    return Pose(p=_vector(tf.translation), q=_quaternion(tf.rotation))


def map_to_odom(message: Any) -> Pose | None:
    """Pose of odom in map, if the message says it; robot_state_publisher says others."""
    for found in message.transforms:
        if (found.header.frame_id, found.child_frame_id) == ("map", "odom"):
            there = found.transform
            return Pose(p=_vector(there.translation), q=_quaternion(there.rotation))
    return None


def cmd_vel(message: Any) -> Array:
    """(3,) vx, vy [m/s], wz [rad/s] in base_footprint, of a Twist or a TwistStamped.

    Raises :class:`InvalidInput` where one is not finite.
    """
    twist = getattr(message, "twist", message)
    return _finite("twist", np.array([twist.linear.x, twist.linear.y, twist.angular.z]))


def _finite(what: str, values: Array) -> Array:
    if not np.isfinite(values).all():
        raise InvalidInput(f"{what}: expected finite numbers, got {values.tolist()}")
    return values


def joy(message: Any) -> tuple[Array, NDArray[np.int64]]:
    """Axes (a,) in [-1, 1] and buttons (b,), 1 while held. Raises :class:`InvalidInput`."""
    axes = np.array(message.axes, dtype=float).reshape(-1)
    return _finite("joy axes", axes), np.array(message.buttons, dtype=np.int64).reshape(-1)


def goal(message: Any) -> Array:
    """(2,) a point of the frame map [m]. Raises :class:`InvalidInput`."""
    frame = message.header.frame_id
    if frame.lstrip("/") not in ("map", "odom"):  # the belief's odom is the map's frame here
        raise InvalidInput(f"goal: expected a pose in frame 'map', got frame '{frame}'")
    return _finite("goal", _vector(message.pose.position)[:2])


def flag(message: Any) -> bool:
    """Of a Bool."""
    return bool(message.data)


def text(message: Any) -> str:
    """Of a String."""
    return str(message.data)


def status(message: Any) -> dict[str, Any]:
    """What a live robot says of itself."""
    said: dict[str, Any] = json.loads(message.data)
    return said


def mode(message: Any) -> Mode:
    """The mode a String names. Raises :class:`InvalidInput`."""
    try:
        return Mode(message.data)
    except ValueError:
        known = ", ".join(m.value for m in Mode)
        raise InvalidInput(f"mode: expected one of {known}, got '{message.data}'") from None


def occupancy_grid(message: Any) -> GridMap:
    """A grid with every cell above 65 or unknown (-1) blocked and all modes allowed."""
    info = message.info
    data = np.reshape(message.data, (info.height, info.width)).T
    origin = _pose(info.origin)
    return GridMap(
        name="/map",
        cell=round(float(info.resolution), 6),  # it travels as float32
        origin_M=np.array([*origin.p[:2], quat_to_rpy(origin.q)[2]]),
        blocked=(data > 65) | (data < 0),
        allowed=np.full(data.shape, ALL_MODES_BITS, dtype=np.uint8),
    )


def path(message: Any) -> Array:
    """(T+1, 2) [m] in the message's frame."""
    return np.array([_vector(p.pose.position)[:2] for p in message.poses]).reshape(-1, 2)


def plan_facts(message: Any) -> dict[str, Any]:
    """All that the JSON beside a path says: modes, cells, status, objective, bound, solve_ms."""
    return dict(json.loads(message.data))


def plan_modes(message: Any) -> tuple[Mode, ...]:
    """The mode of every step."""
    return tuple(Mode(m) for m in json.loads(message.data)["modes"])
