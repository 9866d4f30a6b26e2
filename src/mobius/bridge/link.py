"""A ROS 2 node without ROS: publishers and subscriptions over one Zenoh session.

The session is a peer, as rmw_zenoh's are: it connects to a router (``rmw_zenohd``) whenever there
is one, and hears of other nodes from it. It listens on the loopback interface alone and looks for
nobody by multicast, unless told otherwise.

Messages arrive in threads of Zenoh's. What a subscriber makes of them, errors included, is this
program's affair: a message that cannot be read is counted and reported, once a topic and cause;
any other error is kept and raised by :meth:`Node.check` in the thread that asks.
"""

from __future__ import annotations

import json
import logging
import threading
import time
from collections import Counter
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from mobius.bridge.to_ros import STORE
from mobius.bridge.wire import (
    Attachment,
    Endpoint,
    Who,
    data_key,
    endpoint_token,
    gid_of,
    node_token,
    pack_attachment,
)
from mobius.errors import InvalidInput, MissingDependency, MobiusError

if TYPE_CHECKING:
    import zenoh

__all__ = ["ROUTER", "HERE", "Node", "Speaker"]

ROUTER = "tcp/127.0.0.1:7447"
"""Where a router listens, unless told otherwise."""
HERE = "tcp/127.0.0.1:0"
"""Loopback, any free port."""
_HEARTBEAT_S = 0.5
"""How often a latched publisher says what it said last [s], as rmw_zenoh does."""
_LOG = logging.getLogger("mobius.ros2")


def config(*, connect: Sequence[str], listen: Sequence[str], scouting: bool) -> dict[str, Any]:
    """Settings of the session, by their names in Zenoh's configuration."""
    return {
        "mode": "peer",
        "connect/endpoints": list(connect),
        "connect/timeout_ms": {"router": -1, "peer": -1, "client": 0},
        "connect/exit_on_failure": {"router": False, "peer": False, "client": True},
        "listen/endpoints": list(listen),
        "scouting/multicast/enabled": scouting,
        "scouting/gossip/enabled": True,
        "timestamping/enabled": True,  # latched publishers need it
        "transport/shared_memory/enabled": False,
    }


def open_session(**settings: Any) -> zenoh.Session:
    """A Zenoh session; arguments as for :func:`config`.

    Raises:
        MissingDependency: Zenoh is not installed.
        InvalidInput: An endpoint cannot be parsed or bound.
    """
    try:
        import zenoh
    except ImportError:
        raise MissingDependency("eclipse-zenoh", "ros2", "talking to ROS 2") from None
    zenoh.init_log_from_env_or("error")
    made = zenoh.Config()
    try:
        for key, value in config(**settings).items():
            made.insert_json5(key, json.dumps(value))
        return zenoh.open(made)
    except zenoh.ZError as error:
        where = ", ".join((*settings["connect"], *settings["listen"]))
        why = str(error).split(" at /")[0]  # without places in Zenoh's sources
        raise InvalidInput(
            f"one of {where} cannot be used ({why}); expected free addresses such as"
            " tcp/127.0.0.1:7447"
        ) from None


class Speaker:
    """One publisher."""

    def __init__(self, publisher: Any, token: Any, gid: bytes) -> None:
        self._publisher, self._token, self._gid = publisher, token, gid
        self.sent = 0

    def send(self, data: bytes | memoryview) -> None:
        """Put CDR bytes of the topic's type."""
        self.sent += 1
        beside = pack_attachment(Attachment(self.sent, time.time_ns(), self._gid))
        self._publisher.put(bytes(data), attachment=beside)

    def close(self) -> None:
        """Leave the graph."""
        self._token.undeclare()
        self._publisher.undeclare()


class Node:
    """A node of the ROS 2 graph; ``with`` closes it.

    Args:
        name: Of the node.
        domain: ROS_DOMAIN_ID.
        connect: Where to find a router or other nodes; tried again and again.
        listen: Where others may connect.
        scouting: Whether to look for others, and be found, by multicast on the network.
    """

    def __init__(
        self,
        name: str = "mobius",
        *,
        domain: int = 0,
        connect: Sequence[str] = (ROUTER,),
        listen: Sequence[str] = (HERE,),
        scouting: bool = False,
    ) -> None:
        self._session = open_session(connect=connect, listen=listen, scouting=scouting)
        self._live = self._session.liveliness()
        self.who = Who(domain, str(self._session.zid()), name)
        self._open: list[Any] = [_Held(self._live.declare_token(node_token(self.who)))]
        self._ends = 0
        self.unreadable: Counter[str] = Counter()
        """Messages that could not be used, by topic."""
        self._told: set[tuple[str, str]] = set()
        self._broken: BaseException | None = None
        self._lock = threading.Lock()

    def speaker(self, topic: str, kind: str, *, latched: bool = False) -> Speaker:
        """Publish a topic; a latched one keeps its last message for those who come late."""
        import zenoh

        end = self._end("MP", topic, kind, latched=latched)
        key = data_key(self.who.domain, topic, kind)
        options: dict[str, Any] = {
            "congestion_control": zenoh.CongestionControl.DROP,
            "reliability": zenoh.Reliability.RELIABLE,
        }
        if latched:
            from zenoh import ext

            options |= {
                "cache": ext.CacheConfig(1),
                "publisher_detection": True,
                "sample_miss_detection": ext.MissDetectionConfig(
                    heartbeat=None, sporadic_heartbeat=_HEARTBEAT_S
                ),
            }
            publisher: Any = ext.declare_advanced_publisher(self._session, key, **options)
        else:
            publisher = self._session.declare_publisher(key, **options)
        token = endpoint_token(end)
        made = Speaker(publisher, self._live.declare_token(token), gid_of(token))
        self._open.append(made)
        return made

    def hear(self, topic: str, kind: str, take: Callable[[Any], None]) -> None:
        """Call ``take`` with every message of a topic, in a thread of Zenoh's.

        ``take`` refuses a message with a :class:`MobiusError`.
        """
        end = self._end("MS", topic, kind)

        def arrived(sample: Any) -> None:
            try:
                take(self._read(topic, kind, sample.payload.to_bytes()))
            except MobiusError as error:
                self._complain(topic, str(error))
            except BaseException as error:
                self._broken = self._broken or error

        key = data_key(self.who.domain, topic, kind)
        self._open.append(_Held(self._session.declare_subscriber(key, arrived)))
        self._open.append(_Held(self._live.declare_token(endpoint_token(end))))

    def check(self) -> None:
        """Raise what went wrong in a subscriber, if anything did: a bug, not a bad message."""
        if self._broken is not None:
            broken, self._broken = self._broken, None
            raise broken

    def close(self) -> None:
        """Leave the graph and close the session; a second time does nothing."""
        while self._open:
            self._open.pop().close()
        if not self._session.is_closed():
            self._session.close()

    def __enter__(self) -> Node:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # -- inside --------------------------------------------------------------------------

    def _end(self, kind: Any, topic: str, message: str, *, latched: bool = False) -> Endpoint:
        self._ends += 1
        return Endpoint(self.who, self._ends, kind, topic, message, latched)

    def _read(self, topic: str, kind: str, data: bytes) -> Any:
        """The message, or InvalidInput: bytes from outside may be anything."""
        try:
            return STORE.deserialize_cdr(data, kind)
        except Exception as error:
            raise InvalidInput(
                f"expected CDR of {kind}, got {len(data)} bytes that are none"
                f" ({type(error).__name__})"
            ) from None

    def _complain(self, topic: str, why: str) -> None:
        with self._lock:
            self.unreadable[topic] += 1
            about = (topic, why.split(",")[0])  # without the values that came
            new = about not in self._told and len(self._told) < 100
            if new:
                self._told.add(about)
        if new:
            _LOG.warning("%s: %s", topic, why)


class _Held:
    """A subscription or a token."""

    def __init__(self, held: Any) -> None:
        self._held = held

    def close(self) -> None:
        self._held.undeclare()
