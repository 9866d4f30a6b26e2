"""``mobius drive``: the loop, and who looks at it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from mobius.drive.loop import Line
from mobius.errors import InvalidInput
from mobius.view.live.guard import Door
from mobius.view.live.nouns import Beat, Reset, Snapshot

VIEWERS = ("web", "native", "none")


@dataclass(frozen=True)
class Driven:
    """How a drive went."""

    seconds: float
    """Wall time [s]."""
    last: Snapshot | None


def drive(
    source: str,
    *,
    viewer: str = "web",
    door: Door | None = None,
    seconds: float | None = None,
    seed: int = 0,
    randomised: bool = True,
    shadows: bool = True,
    ready: Callable[[str], None] = print,
    seen: Callable[[Any], None] | None = None,
) -> Driven:
    """Drive the robot on a map until the viewer is closed or the time is over.

    Args:
        source: A map file or a shipped map's name.
        viewer: ``web``, ``native`` or ``none``.
        door: Where the page is served; the loopback, port 8080, if not given.
        seconds: How long [s]; for ever if not given.
        seed: Of friction, mass, delay and sensors.
        randomised: Whether they are drawn.
        shadows: Whether they are drawn.
        ready: Told the address of the page.
        seen: Shown the :class:`mobius.view.live.cockpit.Cockpit` 60 times a second.

    Raises:
        MobiusError: The map cannot be used, the port is taken, the host is none of this machine,
            or there is no display for a window.
        RuntimeError: The loop ended though nobody ended it.
    """
    if viewer == "none" and seconds is None:
        raise InvalidInput("--viewer none: nobody could end it; give it --seconds N")
    door = door or Door()
    if viewer == "web":
        door.check()
    elif viewer == "native":
        from mobius.view.live.window import check_window

        check_window()
    began = time.monotonic()
    line = Line(source, seed=seed, randomised=randomised)
    try:
        if viewer == "none":
            last = _without_viewer(line, seconds or 0.0)
        else:
            from mobius.view.live.studio import watch

            last = watch(
                line,
                Reset,
                viewer=viewer,
                door=door,
                seconds=seconds,
                shadows=shadows,
                ready=ready,
                seen=seen,
            )
        line.check()
    finally:
        line.close()
    return Driven(time.monotonic() - began, last)


def _without_viewer(line: Line, seconds: float) -> Snapshot | None:
    """Let the robot stand for some seconds."""
    last: Snapshot | None = None
    end = time.monotonic() + seconds
    while time.monotonic() < end and line.alive:
        for came in line.come(0.02):
            last = came if isinstance(came, Snapshot) else last
        line.send(Beat(seen=0 if last is None else last.number))
    return last
