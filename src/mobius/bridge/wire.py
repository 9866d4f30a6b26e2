"""How rmw_zenoh writes ROS 2 on Zenoh: keys, type hashes, attachments, tokens. Pure functions.

A topic is a key that ends in the hash of its type, so that only those meet who mean the same::

    0/cmd_vel/geometry_msgs::msg::dds_::Twist_/RIHS01_9c45bf16fe0983d8...

The payload is CDR. Beside it goes an attachment: sequence number, time of sending, who sent it.
Nodes, publishers and subscriptions are known to the graph by liveliness tokens, keys below
``@ros2_lv`` that live as long as their session. Layout: design document and sources of
``ros2/rmw_zenoh``; attachments as from ros-jazzy-rmw-zenoh-cpp 0.2.4 on.
"""

from __future__ import annotations

import hashlib
import struct
from dataclasses import dataclass
from functools import cache
from typing import Literal

from mobius.bridge.to_ros import STORE
from mobius.errors import InvalidInput

__all__ = [
    "Attachment",
    "Endpoint",
    "Who",
    "data_key",
    "dds_name",
    "endpoint_token",
    "gid_of",
    "node_token",
    "pack_attachment",
    "qos_string",
    "type_hash",
    "unpack_attachment",
]

ADMIN = "@ros2_lv"
_ATTACHMENT = struct.Struct("<qqB16s")
_GID_BYTES = 16


@dataclass(frozen=True)
class Who:
    """One node in one session."""

    domain: int
    """ROS_DOMAIN_ID."""
    session: str
    """The session's Zenoh id, hexadecimal."""
    name: str
    """Of the node, without a slash; its namespace is ``/``."""
    number: int = 0
    """Of the node in its session."""


@dataclass(frozen=True)
class Endpoint:
    """One publisher or subscription of a node."""

    who: Who
    number: int
    """In its session; the node's own is 0."""
    kind: Literal["MP", "MS"]
    """Message publisher or message subscription."""
    topic: str
    type: str
    """Such as ``sensor_msgs/msg/JointState``."""
    latched: bool = False


def dds_name(kind: str) -> str:
    """``geometry_msgs/msg/Twist`` as ``geometry_msgs::msg::dds_::Twist_``."""
    package, middle, name = kind.split("/")
    return f"{package}::{middle}::dds_::{name}_"


@cache
def type_hash(kind: str) -> str:
    """RIHS01 hash of a message type, the same from Iron to Lyrical where its fields are."""
    return str(STORE.hash_rihs01(kind))


def data_key(domain: int, topic: str, kind: str) -> str:
    """Where messages of a topic and type are put."""
    return f"{domain}/{topic.strip('/')}/{dds_name(kind)}/{type_hash(kind)}"


def qos_string(*, latched: bool) -> str:
    """Reliable, keep last 10; latched: transient local, keep last 1.

    Fields are reliability, durability, history and depth, deadline, lifespan, liveliness; empty
    ones are the defaults of rmw_zenoh.
    """
    return ":1:,1:,:,:,," if latched else "::,10:,:,:,,"


def node_token(who: Who) -> str:
    """The token by which the graph knows a node."""
    return f"{_begin(who, who.number)}/NN/%/%/{_mangled(who.name)}"


def endpoint_token(end: Endpoint) -> str:
    """The token by which the graph knows a publisher or a subscription."""
    parts = (
        f"{_begin(end.who, end.number)}/{end.kind}/%/%/{_mangled(end.who.name)}",
        _mangled(end.topic),
        dds_name(end.type),
        type_hash(end.type),
        qos_string(latched=end.latched),
    )
    return "/".join(parts)


def _begin(who: Who, number: int) -> str:
    return f"{ADMIN}/{who.domain}/{who.session}/{who.number}/{number}"


def _mangled(name: str) -> str:
    """A name with slashes in one part of a key."""
    return name.replace("/", "%")


def gid_of(token: str) -> bytes:
    """16 bytes that name an endpoint. rmw_zenoh takes another hash of the same token, which no
    receiver computes again from a message.
    """
    return hashlib.blake2b(token.encode(), digest_size=_GID_BYTES).digest()


@dataclass(frozen=True)
class Attachment:
    """What goes beside every message."""

    sequence: int
    """Counts from 1."""
    sent_ns: int
    """Wall time of sending [ns since 1970]."""
    gid: bytes
    """(16,) of the sender."""


def pack_attachment(attachment: Attachment) -> bytes:
    """As rmw_zenoh writes it."""
    return _ATTACHMENT.pack(
        attachment.sequence, attachment.sent_ns, len(attachment.gid), attachment.gid
    )


def unpack_attachment(data: bytes) -> Attachment:
    """Read one. Raises :class:`InvalidInput` where it is none."""
    if len(data) != _ATTACHMENT.size or data[16] != _GID_BYTES:
        raise InvalidInput(
            f"attachment: expected {_ATTACHMENT.size} bytes of rmw_zenoh >= 0.2.4, got {len(data)}"
        )
    sequence, sent_ns, _, gid = _ATTACHMENT.unpack(data)
    return Attachment(sequence, sent_ns, gid)
