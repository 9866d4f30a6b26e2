"""Commands from far away as a source for the stack: twists, a gamepad, mode requests, goals.

Who holds the controls. A gamepad whose dead-man button is held comes first, then ``/cmd_vel``,
then the plan to a goal. Whoever takes the controls ends the plan; it does not come back by
itself. A twist counts for half a second: silence, a lost network, a released button stop the
robot. Nothing moves that was not asked for within that time.

Threads. ``take_*`` are called by whoever hears (:class:`mobius.bridge.link.Node`, in its threads)
and only check and put down; :meth:`Remote.attend` and :meth:`Remote.command` carry out, in the
thread that turns the stack.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from mobius.errors import InvalidInput, MobiusError
from mobius.modes import ModeMachine
from mobius.types import Mode, ModeCommand, StateEstimate

Array = NDArray[np.float64]

__all__ = ["SILENCE", "Errands", "Gamepad", "Remote"]

SILENCE = 0.5
"""A twist or a held button counts this long [s]."""
_EARLY = 1 / 60
"""The command after a silence comes at the next 60 Hz tick; asked for this much earlier [s]."""
MOST_ORDERS = 100
"""So many goals, modes and stops may wait for the next tick; a further stop always may."""
MODE_TOPIC = "/mobius/mode_request"
"""Under which :attr:`Remote.refused` tells what was wrong with a mode."""
ONCE = (Mode.ROLL, Mode.PUSH_UPS)
"""Modes that end by themselves: wanted once, not for ever."""

Limits = Mapping[Mode, tuple[Array, Array]]
"""Slowest and fastest twist (3,) of each walking mode."""


@dataclass(frozen=True)
class Gamepad:
    """Which axis and button of ``/joy`` does what; as ``joy_node`` counts an Xbox pad."""

    forward: int = 1
    """Axis of vx; stick up is +1."""
    left: int = 0
    """Axis of vy; stick left is +1."""
    turn: int = 3
    """Axis of wz; stick left is +1."""
    held: int = 4
    """Dead-man button (L1): nothing moves unless it is held."""
    stop: int = 1
    """Emergency stop (B), held or not."""


class Errands(Protocol):
    """Who plans to a goal and drives there."""

    def go(self, goal: Array, at: Array, actual: Mode) -> None:
        """Plan from ``at`` to ``goal``, (2,) [m] each, frame map, and set out."""

    def cancel(self) -> None:
        """Forget it."""

    def command(self, belief: StateEstimate, actual: Mode) -> ModeCommand | None:
        """The next command; None while there is nowhere to go."""


class _Pushed(NamedTuple):
    """Somebody's wish and when it came."""

    twist: Array
    when: float


class Remote:
    """A source of commands; see the module's text."""

    def __init__(
        self,
        machine: ModeMachine,
        limits: Limits,
        *,
        speed: float = 1.0,
        gamepad: Gamepad | None = None,
        errands: Errands | None = None,
        check: Callable[[Mode, StateEstimate], None] | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Begin in the machine's mode, standing.

        Args:
            machine: Of the stack; its modes are the ones that may be asked for.
            limits: Twists are clipped to these.
            speed: Share of the limits that is let through, in (0, 1].
            gamepad: Axes and buttons.
            errands: Where goals go; without it they are refused.
            check: Called with a motion that is wanted and the belief while the robot crawls
                and would begin it; raises a :class:`mobius.errors.MobiusError` where it must not.
            clock: Seconds that never run backwards.

        Raises:
            InvalidInput: ``speed`` is no share.
        """
        if not 0.0 < speed <= 1.0:
            raise InvalidInput(f"speed: expected a share in (0, 1], got {speed:g}")
        self.machine, self._limits, self._speed = machine, limits, speed
        self.gamepad, self.errands, self._check = gamepad or Gamepad(), errands, check
        self._clock = clock
        self.wanted = machine.mode
        """Mode asked for last."""
        self._twist: _Pushed | None = None
        self._stick: _Pushed | None = None
        self._stop_held = self._taken = False
        self._orders: deque[tuple[str, Any]] = deque()
        self.refused: dict[str, str] = {}
        """By topic: why the last message was not taken; gone once one is."""

    # -- heard, in any thread ---------------------------------------------------------------

    def take_twist(self, twist: Array) -> None:
        """Velocity (3,) vx, vy [m/s], wz [rad/s] in base_footprint, of /cmd_vel."""
        self._twist, self._taken = _Pushed(twist, self._clock()), True

    def take_joy(self, joy: tuple[Array, NDArray[np.int64]]) -> None:
        """Axes in [-1, 1] and buttons. Raises InvalidInput where the pad has too few."""
        (axes, buttons), pad = joy, self.gamepad
        need = (max(pad.forward, pad.left, pad.turn), max(pad.held, pad.stop))
        if len(axes) <= need[0] or len(buttons) <= need[1]:
            raise InvalidInput(
                f"joy: expected at least {need[0] + 1} axes and {need[1] + 1} buttons,"
                f" got {len(axes)} and {len(buttons)}"
            )
        stop = bool(buttons[pad.stop])
        if stop and not self._stop_held:
            self.take_stop(True)
        self._stop_held = stop
        if buttons[pad.held]:
            share = np.clip(axes[[pad.forward, pad.left, pad.turn]], -1.0, 1.0)
            self._stick, self._taken = _Pushed(share, self._clock()), True
        else:
            self._stick = None

    def take_mode(self, mode: Mode) -> None:
        """A mode to be in, ``stop`` included. Raises InvalidInput for one that is not there."""
        known = [m for m in (Mode.CRAWL, Mode.BIPED, *ONCE) if m in self.machine.available]
        if mode is not Mode.STOP and mode not in known:
            names = ", ".join([*known, Mode.STOP])
            raise InvalidInput(f"mode request: expected one of {names}, got '{mode}'")
        if mode is Mode.STOP:
            self.take_stop(True)
        else:
            self._put("mode", mode)

    def take_goal(self, goal: Array) -> None:
        """A place (2,) [m], frame map. Raises InvalidInput without a map."""
        if self.errands is None:
            raise InvalidInput("goal: there is no map to plan on; start with --map")
        self._put("goal", goal)

    def take_stop(self, stop: bool) -> None:
        """Emergency stop, or its release; there is always room for one more."""
        self._orders.append(("stop", stop))

    def _put(self, what: str, value: Any) -> None:
        """An order that may be refused where nobody has carried out those before."""
        if len(self._orders) >= MOST_ORDERS:
            raise InvalidInput(f"{what}: {MOST_ORDERS} orders wait already, send fewer")
        self._orders.append((what, value))

    # -- carried out, in the stack's thread --------------------------------------------------

    def attend(self, belief: StateEstimate | None) -> None:
        """Carry out what was heard; call before every tick: a stop waits for no sample."""
        if self._taken:
            self._taken = False
            self._cancel()
        later: list[tuple[str, Any]] = []
        while self._orders:
            what, value = self._orders.popleft()
            if what == "stop":
                if value:
                    later.clear()  # what was asked for before a stop is forgotten
                self._stop(value)
            elif what == "mode":
                self._cancel()
                self.wanted = value
            elif belief is None:  # before the first sample: it waits, but for stops
                later.append((what, value))
            elif what == "goal" and self.errands is not None:
                self.errands.go(value, belief.p_OB[:2], self.machine.mode)
        self._orders.extendleft(reversed(later))

    def command(self, belief: StateEstimate) -> ModeCommand:
        """The source: what whoever holds the controls wants now."""
        if self.wanted in ONCE:
            self._look_before(belief)
            if self.machine.mode is self.wanted:
                self.wanted = Mode.CRAWL
        twist = self._pushed()
        if twist is None and self.errands is not None:
            driven = self.errands.command(belief, self.machine.mode)
            if driven is not None:
                if driven.mode not in ONCE:  # taken over half-way it shall not roll by itself
                    self.wanted = driven.mode
                return driven
        if twist is None:
            twist = np.zeros(3)
        return ModeCommand(mode=self.wanted, twist_H=twist, stamp=belief.stamp)

    def _pushed(self) -> Array | None:
        """The twist of stick or /cmd_vel, as the body lets it through; None in silence."""
        low, high = self._limits.get(self.machine.mode, (np.zeros(3), np.zeros(3)))
        low, high = self._speed * np.asarray(low), self._speed * np.asarray(high)
        now, stick, twist = self._clock(), self._stick, self._twist
        if stick is not None and now - stick.when < SILENCE - _EARLY:
            return np.where(stick.twist < 0.0, -stick.twist * low, stick.twist * high)
        if twist is not None and now - twist.when < SILENCE - _EARLY:
            return np.clip(twist.twist, low, high)
        return None

    def _look_before(self, belief: StateEstimate) -> None:
        """Give a motion up that the check has something against, right before it begins."""
        if self._check is None or self.machine.mode is not Mode.CRAWL:
            return
        try:
            self._check(self.wanted, belief)
        except MobiusError as error:
            self.refused[MODE_TOPIC], self.wanted = str(error), Mode.CRAWL

    def _stop(self, stop: bool) -> None:
        self._cancel()
        if stop:
            self.machine.emergency_stop("emergency stop from afar")
        elif self.machine.stopped:
            self.wanted = Mode.CRAWL if Mode.CRAWL in self.machine.available else self.wanted
            self.machine.release()

    def _cancel(self) -> None:
        if self.errands is not None:
            self.errands.cancel()
