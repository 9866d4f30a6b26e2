"""A ROS 2 node of another make, zenoh-ros2-sdk, in a process of its own.

``python peer.py PORT FOLDER`` connects to a Zenoh endpoint on the loopback interface, obeys JSON
lines on standard input and tells on standard output, a JSON line each, what it hears. FOLDER holds
message definitions, so that the SDK need not fetch any.
"""

from __future__ import annotations

import json
import os
import sys
import threading
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

TYPES = (
    "geometry_msgs/msg/PoseStamped",
    "geometry_msgs/msg/Twist",
    "geometry_msgs/msg/TwistStamped",
    "nav_msgs/msg/Odometry",
    "nav_msgs/msg/Path",
    "rosgraph_msgs/msg/Clock",
    "sensor_msgs/msg/JointState",
    "sensor_msgs/msg/Joy",
    "std_msgs/msg/Bool",
    "std_msgs/msg/String",
    "tf2_msgs/msg/TFMessage",
)


def write_definitions(folder: Path, kinds: Iterable[str] = TYPES) -> None:
    """The .msg files of types and of all within, from rosbags' table; the SDK computes its own
    hashes of them.
    """
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    for kind in kinds:
        text, _ = store.generate_msgdef(kind, ros_version=2)
        own, *others = text.split("=" * 80 + "\n")
        named = [part.removeprefix("MSG: ").partition("\n")[::2] for part in others]
        for name, fields in [(kind.replace("/msg/", "/"), own), *named]:
            package, short = name.split("/")
            (folder / package / "msg").mkdir(parents=True, exist_ok=True)
            (folder / package / "msg" / f"{short}.msg").write_text(fields)


def plain(value: Any) -> Any:
    """A message as JSON."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, list | tuple):
        return [plain(v) for v in value]
    if hasattr(value, "__dataclass_fields__"):
        return {k: plain(getattr(value, k)) for k in value.__dataclass_fields__ if k[0] != "_"}
    return value


def made(store: Any, kind: str, fields: dict[str, Any]) -> dict[str, Any]:
    """JSON as keyword arguments of a message class, messages inside made, the rest zero."""
    arguments = {}
    for name, (node, detail) in store.fielddefs[kind][1]:
        if node == 2:  # a message
            inner = made(store, detail, fields.get(name, {}))
            arguments[name] = store.types[detail](**inner)
        elif node == 1:
            arguments[name] = fields.get(name, "" if detail[0] == "string" else 0)
        else:
            dtype = {"float32": np.float32, "int32": np.int32}.get(detail[0][1][0], np.float64)
            arguments[name] = np.array(fields.get(name, []), dtype=dtype)
    return arguments


def main(port: int, folder: Path) -> None:
    """Obey until standard input ends."""
    from zenoh_ros2_sdk import ROS2Publisher, ROS2Subscriber, message_registry, qos, session

    shared = session.ZenohSession.get_instance("127.0.0.1", port)
    message_registry.get_registry().messages_dir = folder
    there = {"router_ip": "127.0.0.1", "router_port": port}
    lock, publishers = threading.Lock(), {}

    def tell(**words: Any) -> None:
        with lock:
            print(json.dumps(words), flush=True)

    def heard(topic: str) -> Any:
        return lambda m: tell(topic=topic, t=time.monotonic(), message=plain(m))

    tell(ready=True)
    for line in sys.stdin:
        order = json.loads(line)
        topic, kind = order.get("topic", ""), order.get("type", "")
        if order["do"] == "hear":
            durability = qos.QosDurability
            profile = qos.QosProfile(
                durability=durability.TRANSIENT_LOCAL if order["latched"] else durability.VOLATILE
            )
            ROS2Subscriber(topic, kind, heard(topic), qos=profile, **there)
        elif order["do"] == "say":
            key = (topic, kind)
            if key not in publishers:
                publishers[key] = ROS2Publisher(topic, kind, **there)
            publishers[key].publish(**made(shared.store, kind, order["fields"]))
        elif order["do"] == "graph":
            replies = shared.liveliness.get("@ros2_lv/**", timeout=1.0)
            tell(graph=[str(r.ok.key_expr) for r in replies if r.ok is not None])
        tell(done=order["do"])
    os._exit(0)  # the SDK keeps threads that would hold the process


if __name__ == "__main__":
    main(int(sys.argv[1]), Path(sys.argv[2]))
