"""The live robot in the ROS 2 graph: says what the table tells, hears what the table tells."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from mobius.bridge.link import Node, Speaker
from mobius.bridge.messages import CLOCK_HZ, HEARD, TOPICS, Topic, due_rows, encode
from mobius.bridge.pilot import Remote
from mobius.errors import MobiusError

__all__ = ["Live"]


class Live:
    """Publishes nouns under their topics, at their rates; gives what is heard to a remote.

    Args:
        node: Of the graph; whoever opened it closes it.
        remote: Gets what is heard; nothing is listened to without it.
        without: Topics that are not published.
    """

    def __init__(
        self, node: Node, remote: Remote | None = None, *, without: Collection[str] = ()
    ) -> None:
        rows = [r for r in TOPICS.values() if r.where != "log" and r.name not in without]
        self._speakers: dict[str, Speaker] = {
            row.name: node.speaker(row.name, row.type, latched=row.latched) for row in rows
        }
        self._latched = [row for row in rows if row.latched]
        self._due = due_rows(rows)
        for heard in HEARD if remote is not None else ():
            self._listen(node, heard.name, heard.type, heard.from_ros, f"take_{heard.noun}", remote)

    @property
    def topics(self) -> tuple[str, ...]:
        """What is published."""
        return tuple(self._speakers)

    def once(self, **nouns: Any) -> None:
        """Say latched topics anew: ``grid``, ``plan``, ``pose_MO``, ``description``."""
        self._say(self._latched, nouns)

    def step(self, tick: int, **nouns: Any) -> None:
        """Say what is due at a tick of the 600 Hz base clock; call at 60 Hz.

        Args:
            tick: Count of the base clock.
            nouns: ``frame``, ``belief``, ``command``, ``target``, ``truth``, ``status``,
                ``picture``; one left out, or None, is not said.
        """
        due = self._due[tick % CLOCK_HZ]
        if due:
            self._say(due, {"clock": tick / CLOCK_HZ, **nouns})

    def _say(self, rows: Collection[Topic], nouns: dict[str, Any]) -> None:
        for row in rows:
            noun = nouns.get(row.noun)
            data = None if noun is None else encode(row.name, noun)
            if data is not None:
                self._speakers[row.name].send(data)

    @staticmethod
    def _listen(node: Node, name: str, kind: str, from_ros: Any, method: str, remote: Any) -> None:
        take = getattr(remote, method)

        def heard(message: Any) -> None:
            remote.refused.pop(name, None)  # before: the stack's thread may refuse it, too
            try:
                take(from_ros(message))
            except MobiusError as error:
                remote.refused[name] = str(error)
                raise

        node.hear(name, kind, heard)
