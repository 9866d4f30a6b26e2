"""What the page that has the controls says of itself, 20 times a second."""

from __future__ import annotations

import json
import math
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

LONGEST_PULSE = 4096
"""Longest message of a pulse [characters]."""
FRESH = 0.35
"""Keys that were told longer ago than that [s] are let go; a page tells them 20 times a second."""
SILENT = 1.0
"""A page that has said nothing for so long [s] is gone; one that closes is gone at once."""
HELD_UP = 10.0
"""A page that has been held up for so long [s] is gone, too. Drawn without a graphics card it is
held up for seconds; its keys are let go all the same."""


@dataclass
class Pulse:
    """What the page that has the controls says of itself; other pages only watch."""

    clock: Callable[[], float] = time.monotonic
    pages: dict[str, int] = field(default_factory=dict)
    """Sessions that asked for the controls and how often they are connected (a page that comes back
    may be there twice for a moment); the first has them."""
    heard: float = -1e9
    """When that page was last heard of [s]."""
    focus: bool = True
    """Whether it has the keyboard."""
    keys: frozenset[str] = frozenset()
    """Drive keys that are held, by their code in the browser (``ArrowUp``, ``KeyQ``)."""
    pressed: deque[str] = field(default_factory=deque)
    """Keys that went down and have not been taken yet: a tap is shorter than a look."""
    axes: tuple[float, ...] = ()
    """Of its first gamepad, -1 to 1, standard mapping."""
    buttons: tuple[int, ...] = ()

    age: float = 0.0
    """How old [s] what it said was when it said it: a page that is held up lets its worker speak
    on."""

    @property
    def there(self) -> bool:
        """Whether a page has the controls and goes on saying so."""
        fresh = self.clock() - self.heard <= SILENT and self.age <= HELD_UP
        return bool(self.pages) and fresh

    @property
    def hands(self) -> bool:
        """Whether its keys and gamepad are known as they are now."""
        return self.there and self.clock() - self.heard + self.age <= FRESH

    def enter(self, session: str) -> None:
        """A page asks for the controls."""
        self.pages[session] = self.pages.get(session, 0) + 1

    def leave(self, session: str) -> None:
        """It is gone; whoever comes next starts with no key held."""
        left = self.pages.get(session, 0) - 1
        if left > 0:
            self.pages[session] = left
            return
        self.hang_up(session)
        self.pages.pop(session, None)

    def hang_up(self, session: str) -> None:
        """It says no more: gone from now on, until it speaks again."""
        if next(iter(self.pages), None) == session:
            self.heard, self.keys, self.axes, self.buttons = -1e9, frozenset(), (), ()
            self.pressed.clear()

    def hear(self, session: str, text: str) -> None:
        """Take in one message of :file:`pulse.js`; what is none counts for nothing."""
        if next(iter(self.pages), None) != session:
            return
        try:
            said = json.loads(text[:LONGEST_PULSE])
            pad = said.get("pad") or {}
            axes = tuple(float(v) for v in pad.get("axes", ()))
            buttons = tuple(int(bool(v)) for v in pad.get("buttons", ()))
            keys = frozenset(str(k) for k in said["keys"])
            focus, age = bool(said["focus"]), float(said.get("age", 0.0))
        except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
            return
        if all(map(math.isfinite, (*axes, age))) and age >= 0.0:
            self.pressed.extend(sorted(keys - self.keys))
            self.focus, self.keys, self.age, self.buttons = focus, keys, age, buttons
            self.axes = tuple(max(-1.0, min(1.0, v)) for v in axes)
            self.heard = self.clock()
