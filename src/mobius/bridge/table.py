"""The topics as Markdown: ``python -m mobius.bridge.table`` prints what ``docs/ros2.md`` holds."""

from __future__ import annotations

from mobius.bridge.messages import HEARD, TOPICS

__all__ = ["heard_table", "said_table"]

_WHERE = {"both": "live and log", "live": "live", "log": "log"}


def said_table() -> str:
    """What goes out: topic, type, rate, reliability and durability, where."""
    lines = ["| Topic | Type | Rate [Hz] | QoS | Where |", "|---|---|---|---|---|"]
    for row in TOPICS.values():
        kind = row.type.replace("/msg/", "/")
        qos = "reliable, transient local, 1" if row.latched else "reliable, volatile, 10"
        lines.append(f"| `{row.name}` | {kind} | {row.rate} | {qos} | {_WHERE[row.where]} |")
    return "\n".join(lines)


def heard_table() -> str:
    """What is listened to: topic, type, what for."""
    lines = ["| Topic | Type | What for |", "|---|---|---|"]
    lines += [f"| `{h.name}` | {h.type.replace('/msg/', '/')} | {h.says} |" for h in HEARD]
    return "\n".join(lines)


if __name__ == "__main__":
    print(said_table(), heard_table(), sep="\n\n")
