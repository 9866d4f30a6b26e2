"""What the pump and the panels share: the newest snapshot, the requests to send, held keys.

The pump (main thread) moves between the loop's line and Studio; the panels run in the viewer's
thread. Each attribute is written by one side only; the queue of requests is a ``deque``.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable

import numpy as np

from mobius.view.live.nouns import (
    MODE_KEYS,
    Beat,
    Halt,
    History,
    Release,
    Request,
    Scene,
    Snapshot,
    WantMode,
    Way,
)
from mobius.view.live.pulse import Pulse

FRAME_STALE = 0.3
"""Keys count for so long after the frame in which they were seen [s]."""
PLOT_EVERY = 4
"""Snapshots between two points of the plots (15 Hz, 20 s)."""
DEAD_MAN = 4
"""Gamepad button that must be held, the left shoulder button of the standard mapping."""
STOP_BUTTON = 1
"""Gamepad button that stops, the right one of the four."""
DEAD_ZONE = 0.15


class Cockpit:
    """State of one live view."""

    def __init__(self, pulse: Pulse | None, clock: Callable[[], float] = time.monotonic) -> None:
        """Args: what is known of the page, None for a window of this machine; a clock [s]."""
        self.pulse, self._clock = pulse, clock
        self.scene: Scene | None = None
        self.way: Way | None = None
        self.snapshot: Snapshot | None = None
        self.seen = 0
        """Number of the last snapshot that came, were it of a scene that is over."""
        self.history = History()
        self.requests: deque[Request] = deque()
        self.driving = False
        """Whether the Drive toggle is on."""
        self.typing = False
        """Whether a number is being typed into a field: keys are no commands then."""
        self.tab = ""
        """Tab of the plots to open next."""
        self.places: dict[str, tuple[float, float]] = {}
        """Where buttons are on the page [pixels], for those who click without hands."""
        self._window, self._window_at = frozenset[str](), -1e9
        self._held, self._focus, self._pad_stop = frozenset[str](), True, False

    # -- the panels' side ------------------------------------------------------------------

    def ask(self, request: Request) -> None:
        """Send a request with the next beat."""
        self.requests.append(request)

    def press(self, keys: frozenset[str]) -> None:
        """Drive keys held in this frame of a window; a page tells them itself."""
        self._window, self._window_at = keys, self._clock()

    # -- the pump's side -------------------------------------------------------------------

    def show(self, snapshot: Snapshot) -> None:
        """The newest snapshot; every few it goes into the plots."""
        self.snapshot = snapshot
        if snapshot.number % PLOT_EVERY == 0:
            self.history.add(snapshot.t, _plotted(snapshot))

    def beat(self) -> Beat:
        """What to tell the loop now; keys that were just pressed become requests."""
        there, keys = self._keys()
        self._watch_focus()
        pressed = self._pressed(keys)
        if self.driving:
            self._commands(frozenset({"Space"}) & pressed if self.typing else pressed)
        pad = self._pad()
        share = twist_of(keys) if self.driving and not self.typing else (0.0, 0.0, 0.0)
        return Beat(
            page=there,
            driving=self.driving or pad is not None,
            share=share if pad is None else pad,
            seen=self.seen,
        )

    def _keys(self) -> tuple[bool, frozenset[str]]:
        """Whether somebody is there, and which keys they hold."""
        if self.pulse is not None:
            return self.pulse.there, self.pulse.keys if self.pulse.hands else frozenset()
        there = self._clock() - self._window_at <= FRAME_STALE
        return there, self._window if there else frozenset()

    def _pressed(self, keys: frozenset[str]) -> frozenset[str]:
        """Keys that have gone down since last asked."""
        if self.pulse is None:
            new, self._held = keys - self._held, keys
            return new
        taps = self.pulse.pressed
        return frozenset(taps.popleft() for _ in range(len(taps)))

    def _commands(self, pressed: frozenset[str]) -> None:
        if "Space" in pressed:
            self.ask(Halt("emergency stop (Space)"))
        if "KeyR" in pressed:
            self.ask(Release())
        for digit, mode in MODE_KEYS:
            if f"Digit{digit}" in pressed:
                self.ask(WantMode(mode))

    def _watch_focus(self) -> None:
        if self.pulse is None:
            return
        had, self._focus = self._focus, self.pulse.focus
        if self.driving and had and not self._focus:
            self.ask(Halt("the page has lost the focus"))

    def _pad(self) -> tuple[float, float, float] | None:
        """Twist that the gamepad asks for; None while its dead man's button is not held."""
        pulse = self.pulse
        if pulse is None or not pulse.hands:
            return None
        buttons = pulse.buttons
        stop = len(buttons) > STOP_BUTTON and bool(buttons[STOP_BUTTON])
        if stop and not self._pad_stop:
            self.ask(Halt("stop button of the gamepad"))
        self._pad_stop = stop
        if len(buttons) <= DEAD_MAN or not buttons[DEAD_MAN] or len(pulse.axes) < 3:
            return None
        x, y, turn = (_dead_zone(-pulse.axes[k]) for k in (1, 0, 2))
        return x, y, turn


def twist_of(keys: frozenset[str]) -> tuple[float, float, float]:
    """Shares of vx, vy, wz that held keys ask for; keys against each other cancel."""

    def both(plus: str, minus: str) -> float:
        return float(plus in keys) - float(minus in keys)

    return both("ArrowUp", "ArrowDown"), both("KeyQ", "KeyE"), both("ArrowLeft", "ArrowRight")


def _dead_zone(value: float) -> float:
    """The stick's value with its middle cut out, still -1 to 1."""
    size = max(0.0, abs(value) - DEAD_ZONE) / (1.0 - DEAD_ZONE)
    return float(np.copysign(min(size, 1.0), value))


def _plotted(s: Snapshot) -> list[float]:
    """One row of the plots: 9 twists, power, 4 contacts, 2 wrist forces, factor, lateness."""
    forces = np.linalg.norm(s.wrench[:, :3], axis=1)
    return [
        *s.twist.ravel().tolist(),
        s.power,
        *s.contact.tolist(),
        *forces.tolist(),
        100.0 * s.keeping.factor,
        s.keeping.late_p99_ms,
    ]
