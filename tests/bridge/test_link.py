"""A node: who hears what, who comes late, and what becomes of errors."""

import logging
import sys
import threading
import time

import pytest

from mobius.bridge.link import Node, config
from mobius.bridge.to_ros import STORE, text
from mobius.errors import InvalidInput, MissingDependency

STRING = "std_msgs/msg/String"
zenoh = pytest.importorskip("zenoh", reason="eclipse-zenoh is not installed")


def words(said: str) -> memoryview:
    return STORE.serialize_cdr(text(said), STRING)


def wait(what, seconds: float = 10.0):
    ends = time.monotonic() + seconds
    while not what():
        assert time.monotonic() < ends, "it did not come about"
        time.sleep(0.01)


@pytest.fixture
def pair(router):
    """Two nodes of the same domain."""
    where = {"connect": (f"tcp/127.0.0.1:{router}",), "domain": 7}
    with Node("one", **where) as one, Node("two", **where) as two:
        yield one, two


def test_what_one_says_the_other_hears_in_order(pair):
    one, two = pair
    heard = []
    two.hear("/chat", STRING, lambda m: heard.append(m.data))
    speaker = one.speaker("/chat", STRING)
    wait(lambda: speaker.send(words("hello")) or heard)
    heard.clear()
    for k in range(100):
        speaker.send(words(str(k)))
    wait(lambda: heard[-1:] == ["99"])
    assert [h for h in heard if h != "hello"] == [str(k) for k in range(100)]


def test_other_domains_and_other_types_are_not_heard(pair, router):
    one, two = pair
    heard = []
    two.hear("/chat", "std_msgs/msg/Bool", lambda m: heard.append("type"))
    with Node("three", connect=(f"tcp/127.0.0.1:{router}",), domain=8) as three:
        three.hear("/chat", STRING, lambda m: heard.append("domain"))
        two.hear("/chat", STRING, lambda m: heard.append("right"))
        speaker = one.speaker("/chat", STRING)
        wait(lambda: speaker.send(words("hello")) or len(heard) > 3)
    assert set(heard) == {"right"}


def test_a_latched_topic_is_heard_by_who_comes_late_once_and_newest(pair, router):
    one, two = pair
    there: list[str] = []
    two.hear("/late", STRING, lambda m: there.append(m.data))
    speaker = one.speaker("/late", STRING, latched=True)
    for k in range(3):
        speaker.send(words(str(k)))
    wait(lambda: "2" in there)  # nothing is on its way any more when the late one comes
    from zenoh import ext

    heard: list[str] = []
    settings = zenoh.Config()
    settings.insert_json5("mode", '"client"')
    settings.insert_json5("connect/endpoints", f'["tcp/127.0.0.1:{router}"]')
    settings.insert_json5("scouting/multicast/enabled", "false")
    with zenoh.open(settings) as session:
        subscriber = ext.declare_advanced_subscriber(
            session,
            "7/late/**",
            lambda s: heard.append(STORE.deserialize_cdr(s.payload.to_bytes(), STRING).data),
            history=ext.HistoryConfig(detect_late_publishers=True, max_samples=1),
        )
        wait(lambda: heard)
        time.sleep(0.1)
        subscriber.undeclare()
    assert heard == ["2"]


def test_a_bug_in_a_subscriber_is_raised_where_somebody_asks(pair):
    one, two = pair
    speaker = one.speaker("/chat", STRING)
    two.hear("/chat", STRING, lambda m: m.no_such_field)
    wait(lambda: speaker.send(words("hello")) or two._broken)
    with pytest.raises(AttributeError, match="no_such_field"):
        two.check()
    one.check()


def test_messages_that_cannot_be_used_are_counted_and_told_once(pair, caplog):
    one, two = pair

    def refuse(message):
        raise InvalidInput("expected something else")

    two.hear("/chat", STRING, refuse)
    two.hear("/numbers", STRING, lambda m: None)
    chat, numbers = one.speaker("/chat", STRING), one.speaker("/numbers", STRING)
    with caplog.at_level(logging.WARNING, "mobius.ros2"):
        wait(lambda: chat.send(words("x")) or two.unreadable["/chat"] >= 3)
        wait(lambda: numbers.send(b"\x00\x01\x00\x00\xff") or two.unreadable["/numbers"] >= 3)
    told = [r.getMessage() for r in caplog.records]
    assert [t for t in told if t.startswith("/chat")] == ["/chat: expected something else"]
    (numbers_told,) = [t for t in told if t.startswith("/numbers")]
    assert "expected CDR of std_msgs/msg/String, got 5 bytes" in numbers_told
    two.check()


def test_closing_leaves_the_graph_and_no_thread_of_ours(router):
    before = threading.active_count()
    with Node("gone", connect=(f"tcp/127.0.0.1:{router}",), domain=9) as node:
        node.speaker("/a", STRING)
        node.speaker("/b", STRING, latched=True)
        node.hear("/c", STRING, print)
        with Node("watcher", connect=(f"tcp/127.0.0.1:{router}",), domain=9) as watcher:

            def tokens() -> list[str]:
                replies = watcher._live.get("@ros2_lv/9/**", timeout=1.0)
                return [str(r.ok.key_expr) for r in replies if r.ok is not None]

            wait(lambda: sum("/gone/" in t or t.endswith("/gone") for t in tokens()) == 4)
            node.close()
            wait(lambda: not any("gone" in t for t in tokens()))
    assert threading.active_count() <= before


def test_nobody_is_sought_by_multicast_unless_asked():
    assert config(connect=(), listen=(), scouting=False)["scouting/multicast/enabled"] is False
    assert config(connect=(), listen=(), scouting=True)["scouting/multicast/enabled"] is True


@pytest.mark.parametrize("address", ["bla", "tcp/127.0.0.1:99999", "tcp/203.0.113.7:7448"])
def test_an_address_that_cannot_be_bound_is_a_users_mistake(address):
    with pytest.raises(InvalidInput, match="expected free addresses such as") as error:
        Node(connect=(), listen=(address,))
    assert address in str(error.value)
    assert "/src/" not in str(error.value)


def test_without_zenoh_the_message_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "zenoh", None)
    with pytest.raises(MissingDependency, match=r"mobius\[ros2\]"):
        Node()
