"""Our nouns as ROS 2 messages. Quaternions leave as ``xyzw``, times as integer seconds
and nanoseconds, everything else in the SI units it came in.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rosbags.typesys import Stores, get_typestore

from mobius.geometry import rpy_to_quat
from mobius.model.joints import JOINTS
from mobius.model.passive import PASSIVE, passive_joints, passive_rates
from mobius.model.urdf import fixed_frames
from mobius.types import (
    LIMBS,
    GridMap,
    JointCommand,
    ModeCommand,
    Plan,
    Pose,
    SensorFrame,
    StateEstimate,
)

STORE = get_typestore(Stores.ROS2_JAZZY)
"""Message classes and serialisers; the definitions of all types used are equal from Humble on."""

_T = STORE.types
_Time = _T["builtin_interfaces/msg/Time"]
_Header = _T["std_msgs/msg/Header"]
_String = _T["std_msgs/msg/String"]
_Point = _T["geometry_msgs/msg/Point"]
_Vector3 = _T["geometry_msgs/msg/Vector3"]
_Quaternion = _T["geometry_msgs/msg/Quaternion"]
_Pose = _T["geometry_msgs/msg/Pose"]
_PoseStamped = _T["geometry_msgs/msg/PoseStamped"]
_Twist = _T["geometry_msgs/msg/Twist"]

_LINEAR_FIRST = np.array([3, 4, 5, 0, 1, 2])
_POSE_COV = (12 * _LINEAR_FIRST[:, None] + _LINEAR_FIRST).ravel()
_TWIST_COV = _POSE_COV + 12 * 6 + 6
_NAMES = list(JOINTS)
_ALL_NAMES = [*JOINTS, *PASSIVE]
_NO_TORQUE = np.zeros(len(PASSIVE))
_NO_RATES = np.zeros(0)
_ZERO_COV = np.zeros(9)
_UNKNOWN_ORIENTATION = np.array([-1.0, *[0.0] * 8])


def time_ns(stamp: float) -> int:
    """Integer nanoseconds of ``stamp`` [s]."""
    return round(stamp * 1e9)


def _time(stamp: float) -> Any:
    sec, nanosec = divmod(time_ns(stamp), 1_000_000_000)
    return _Time(sec=sec, nanosec=nanosec)


def header(stamp: float, frame: str) -> Any:
    """Time [s] and frame of a message."""
    return _Header(stamp=_time(stamp), frame_id=frame)


def _vector(v: Iterable[float], kind: Any = _Vector3) -> Any:
    x, y, z = v
    return kind(x=float(x), y=float(y), z=float(z))


def _quaternion(q: NDArray[np.float64]) -> Any:
    w, x, y, z = q.tolist()
    return _Quaternion(x=x, y=y, z=z, w=w)


def _pose(p: Iterable[float], q: NDArray[np.float64]) -> Any:
    return _Pose(position=_vector(p, _Point), orientation=_quaternion(q))


def clock(stamp: float) -> Any:
    """Simulation time [s] as rosgraph_msgs/Clock."""
    return _T["rosgraph_msgs/msg/Clock"](clock=_time(stamp))


def joints(frame: SensorFrame) -> Any:
    """Encoder angles [rad], rates [rad/s] and torques [N m] of JOINTS, then of the eight passive
    joints, which follow from the angles; without them a URDF's links would have no place.
    """
    return _T["sensor_msgs/msg/JointState"](
        header=header(frame.stamp, "base_link"),
        name=_ALL_NAMES,
        position=np.concatenate([frame.q, passive_joints(frame.q)]),
        velocity=np.concatenate([frame.dq, passive_rates(frame.q, frame.dq)]),
        effort=np.concatenate([frame.torque, _NO_TORQUE]),
    )


def targets(command: JointCommand) -> Any:
    """Position targets [rad], names = JOINTS; velocity and effort are empty."""
    return _T["sensor_msgs/msg/JointState"](
        header=header(command.stamp, "base_link"),
        name=_NAMES,
        position=command.q,
        velocity=_NO_RATES,
        effort=_NO_RATES,
    )


def imu(frame: SensorFrame) -> Any:
    """Angular rate [rad/s] and specific force [m/s^2]; orientation marked as not given."""
    return _T["sensor_msgs/msg/Imu"](
        header=header(frame.stamp, "imu"),
        orientation=_Quaternion(x=0.0, y=0.0, z=0.0, w=1.0),
        orientation_covariance=_UNKNOWN_ORIENTATION,
        angular_velocity=_vector(frame.gyro_I),
        angular_velocity_covariance=_ZERO_COV,
        linear_acceleration=_vector(frame.accel_I),
        linear_acceleration_covariance=_ZERO_COV,
    )


def _wrench(frame: SensorFrame, row: int, frame_id: str) -> Any:
    force_torque = frame.wrench_S[row]
    return _T["geometry_msgs/msg/WrenchStamped"](
        header=header(max(frame.stamp - float(frame.wrench_age[row]), 0.0), frame_id),
        wrench=_T["geometry_msgs/msg/Wrench"](
            force=_vector(force_torque[:3]), torque=_vector(force_torque[3:])
        ),
    )


def left_wrench(frame: SensorFrame) -> Any:
    """Force [N] and torque [N m] at the left wrist, sensor frame."""
    return _wrench(frame, 0, "l_wrist_ft")


def right_wrench(frame: SensorFrame) -> Any:
    """Force [N] and torque [N m] at the right wrist, sensor frame."""
    return _wrench(frame, 1, "r_wrist_ft")


def vio(frame: SensorFrame) -> Any | None:
    """Trunk pose of the visual-inertial camera; None when it did not tick."""
    if frame.vio is None:
        return None
    return _PoseStamped(
        header=header(frame.stamp, "vio_odom"), pose=_pose(frame.vio.p, frame.vio.q)
    )


def _odometry(state: StateEstimate, parent: str) -> Any:
    return _T["nav_msgs/msg/Odometry"](
        header=header(state.stamp, parent),
        child_frame_id="base_link",
        pose=_T["geometry_msgs/msg/PoseWithCovariance"](
            pose=_pose(state.p_OB, state.q_OB), covariance=state.cov.take(_POSE_COV)
        ),
        twist=_T["geometry_msgs/msg/TwistWithCovariance"](
            twist=_Twist(linear=_vector(state.v_B), angular=_vector(state.w_B)),
            covariance=state.cov.take(_TWIST_COV),
        ),
    )


def odometry(belief: StateEstimate) -> Any:
    """Believed pose of base_link in odom, twist [m/s, rad/s] in base_link."""
    return _odometry(belief, "odom")


def ground_truth(truth: StateEstimate) -> Any:
    """True pose of base_link in map (``p_OB`` holds p_MB), twist in base_link."""
    return _odometry(truth, "map")


def contacts(belief: StateEstimate) -> Any:
    """Believed probability of ground contact per limb, order LIMBS."""
    size = len(LIMBS)
    dimension = _T["std_msgs/msg/MultiArrayDimension"](
        label=",".join(LIMBS), size=size, stride=size
    )
    return _T["std_msgs/msg/Float64MultiArray"](
        layout=_T["std_msgs/msg/MultiArrayLayout"](dim=[dimension], data_offset=0),
        data=np.array(belief.contact),
    )


def obstacles(poses: NDArray[np.float64]) -> Any:
    """Poses (k, 7) of the scene's movable obstacles in map: x y z [m], qw qx qy qz."""
    return _T["geometry_msgs/msg/PoseArray"](
        header=header(0.0, "map"), poses=[_pose(row[:3], row[3:]) for row in np.asarray(poses)]
    )


def _transform(stamp: float, parent: str, child: str, p: Iterable[float], q: Any) -> Any:
    return _T["geometry_msgs/msg/TransformStamped"](
        header=header(stamp, parent),
        child_frame_id=child,
        transform=_T["geometry_msgs/msg/Transform"](
            translation=_vector(p), rotation=_quaternion(q)
        ),
    )


def tf(belief: StateEstimate) -> Any:
    """Believed transform odom -> base_link."""
    there = _transform(belief.stamp, "odom", "base_link", belief.p_OB, belief.q_OB)
    return _T["tf2_msgs/msg/TFMessage"](transforms=[there])


def tf_static(pose_MO: Pose) -> Any:
    """Transform map -> odom, then every fixed frame of the robot, stamp 0."""
    fixed = [_transform(0.0, f.parent, f.name, f.p, f.q) for f in fixed_frames()]
    return _T["tf2_msgs/msg/TFMessage"](
        transforms=[_transform(0.0, "map", "odom", pose_MO.p, pose_MO.q), *fixed]
    )


def cmd_vel(command: ModeCommand) -> Any:
    """Commanded vx, vy [m/s] and wz [rad/s] in base_footprint."""
    vx, vy, wz = command.twist_H.tolist()
    return _T["geometry_msgs/msg/TwistStamped"](
        header=header(command.stamp, "base_footprint"),
        twist=_Twist(linear=_vector((vx, vy, 0.0)), angular=_vector((0.0, 0.0, wz))),
    )


def mode(command: ModeCommand) -> Any:
    """Name of the commanded mode."""
    return _String(data=command.mode.value)


def text(words: str) -> Any:
    """Plain text, such as a URDF."""
    return _String(data=words)


def status(said: Mapping[str, Any]) -> Any:
    """JSON of what a live robot says of itself."""
    return _String(data=json.dumps(said))


def occupancy_grid(grid: GridMap) -> Any:
    """Blocked cells as 100, others 0, row after row of constant y from the lower left."""
    x, y, yaw = grid.origin_M.tolist()
    cells = np.where(grid.blocked.T, 100, 0).astype(np.int8).ravel()
    return _T["nav_msgs/msg/OccupancyGrid"](
        header=header(0.0, "map"),
        info=_T["nav_msgs/msg/MapMetaData"](
            map_load_time=_time(0.0),
            resolution=float(grid.cell),
            width=grid.shape[0],
            height=grid.shape[1],
            origin=_pose((x, y, 0.0), rpy_to_quat(0.0, 0.0, yaw)),
        ),
        data=cells,
    )


def path(plan: Plan) -> Any:
    """Centres of the planned cells [m] in map; each pose faces the next cell."""
    steps = np.diff(plan.xy_M, axis=0, append=plan.xy_M[-1:])
    yaws = np.arctan2(steps[:, 1], steps[:, 0])
    poses = [
        _PoseStamped(header=header(0.0, "map"), pose=_pose((*xy, 0.0), rpy_to_quat(0.0, 0.0, yaw)))
        for xy, yaw in zip(plan.xy_M, yaws, strict=True)
    ]
    return _T["nav_msgs/msg/Path"](header=header(0.0, "map"), poses=poses)


def plan_modes(plan: Plan) -> Any:
    """JSON: the mode of every step, and what is proven about the plan."""
    return _String(
        data=json.dumps(
            {
                "modes": [m.value for m in plan.modes],
                "cells": plan.cells.tolist(),
                "status": plan.status,
                "objective": plan.objective,
                "bound": plan.bound,
                "solve_ms": 1e3 * plan.solve_s,
            }
        )
    )
