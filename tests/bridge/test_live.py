"""What is said live, how often, and that every heard topic reaches the remote."""

from collections import Counter
from types import SimpleNamespace

import numpy as np
import pytest

from mobius.bridge import pilot
from mobius.bridge.live import Live
from mobius.bridge.messages import CLOCK_HZ, HEARD, TOPICS
from mobius.bridge.to_ros import STORE
from mobius.errors import InvalidInput
from mobius.modes import ModeMachine
from mobius.types import Mode

PERIODIC = ("frame", "belief", "command", "target", "truth", "status", "picture")


class Graph:
    """A node that talks to itself."""

    def __init__(self) -> None:
        self.sent: Counter[str] = Counter()
        self.latched: dict[str, bool] = {}
        self.ears: dict[tuple[str, str], object] = {}

    def speaker(self, topic, kind, *, latched=False):
        self.latched[topic] = latched

        def send(data):
            assert bytes(data[:4]) == b"\x00\x01\x00\x00"
            self.sent[topic] += 1

        return SimpleNamespace(send=send)

    def hear(self, topic, kind, take):
        self.ears[topic, kind] = take


class Remote:
    def __init__(self) -> None:
        self.taken: list[tuple[str, object]] = []
        self.refused: dict[str, str] = {}

    def __getattr__(self, name):
        return lambda value: self.taken.append((name, value))


def test_one_second_says_every_live_topic_as_often_as_the_table_tells(nouns):
    graph = Graph()
    live = Live(graph)
    live.once(**{row.noun: nouns[row.noun] for row in TOPICS.values() if row.latched})
    for tick in range(0, CLOCK_HZ, 10):
        live.step(tick, **{name: nouns[name] for name in PERIODIC})
    rows = {name: row for name, row in TOPICS.items() if row.where != "log"}
    assert graph.sent == {name: row.rate or 1 for name, row in rows.items()}
    assert {t for t, latched in graph.latched.items() if latched} == {
        name for name, row in rows.items() if row.rate == 0
    }


def test_commands_of_others_are_never_said_back():
    """A robot that published /cmd_vel would hear itself, and never fall silent."""
    live = Live(Graph())
    assert not set(live.topics) & {heard.name for heard in HEARD}


def test_a_topic_left_out_is_not_in_the_graph(nouns):
    graph = Graph()
    live = Live(graph, without=("/odom", "/mobius/contacts"))
    live.step(0, belief=nouns["belief"])
    assert "/odom" not in graph.latched
    assert graph.sent == {"/clock": 1, "/tf": 1}


@pytest.mark.parametrize("heard", HEARD, ids=lambda h: f"{h.name}:{h.type}")
def test_what_is_heard_reaches_the_method_of_its_row(heard):
    from mobius.bridge.pilot import Remote as Real

    graph, remote = Graph(), Remote()
    Live(graph, remote)
    message = zero(heard.type)
    if heard.noun == "mode":
        message.data = "crawl"
    if heard.noun == "goal":
        message.header.frame_id = "map"
    graph.ears[heard.name, heard.type](message)
    (((method, _)),) = remote.taken
    assert method == f"take_{heard.noun}"
    assert callable(getattr(Real, method))


def zero(kind):
    """A message of zeros."""
    values = {}
    for name, (node, detail) in STORE.fielddefs[kind][1]:
        if node == 2:
            values[name] = zero(detail)
        elif node == 1:
            values[name] = "" if detail[0] == "string" else 0
        else:
            values[name] = np.zeros(0)
    return STORE.types[kind](**values)


def test_who_asks_for_what_is_not_there_can_read_why_until_he_asks_for_something_else():
    graph = Graph()
    remote = pilot.Remote(ModeMachine(frozenset({Mode.CRAWL})), {})
    Live(graph, remote)
    ask = graph.ears["/mobius/mode_request", "std_msgs/msg/String"]
    said = STORE.types["std_msgs/msg/String"]
    for wrong, why in (("fly", "got 'fly'"), ("biped", "expected one of crawl, stop")):
        with pytest.raises(InvalidInput):
            ask(said(data=wrong))
        assert why in remote.refused["/mobius/mode_request"]
    ask(said(data="crawl"))
    assert remote.refused == {}
