"""The stack against the wall clock: real time, and how much of it is missed.

The problem. The stack counts ticks of 1/600 s and knows no clock; a person at the keys, a
browser and ROS live by the wall. Sleeping 1/600 s after each tick is wrong twice over: the work
of the tick comes on top, so the robot runs slow, and every sleep that lasts too long is lost for
good. Running as many ticks as the clock has gone on, without a limit, is worse: after a pause of
a minute (a debugger, a laptop lid) the robot would race through a minute of motion on commands
that nobody gives any more.

The schedule. Tick k is due at ``t0 + k / 600``, wherever the ticks before it ended: what one
sleep takes too long, the next one takes less. The clock is looked at on even ticks alone, where
the robot is read (300 Hz); the odd tick after it follows at once. So one 300 Hz round is: wait
until it is due, read, believe, perhaps act, two steps of physics, done.

Late. A round is on time when it is *done* one period, 1/300 s, after it was due; later than that
it has missed its deadline, as it would on a real robot whose servos expect the next targets.
:attr:`Timing.misses` counts these.

Behind. Where rounds take longer than a period, the lag grows. Up to 0.1 s of it is made good,
by rounds without a wait. What is beyond is given up: ``t0`` moves, the robot's time falls behind
the wall's for good, and :attr:`Timing.dropped` says by how much. Real-time factor = robot's time /
wall time; a machine that is too slow shows a factor below 1 and a steady lag of 0.1 s, and never
a robot that races.

Worked example. Rounds are due at 0.0, 3.3, 6.7, 10.0 ms ... Each takes 1 ms, but the second
takes 7.5 ms (a garbage collection, say)::

    round   due    begins   done    late by        deadline due + 3.3
    0        0.0     0.0      1.0     1.0  ms      met
    1        3.3     3.3     10.8     7.5          missed
    2        6.7    10.8     11.8     5.2          missed: the pause is not over yet
    3       10.0    11.8     12.8     2.8          met
    4       13.3    13.3     14.3     1.0          waits again: all made good

Two misses, nothing dropped, factor 1.
"""

from __future__ import annotations

import os
import time
from bisect import bisect_left, insort
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from mobius.robot import TICK
from mobius.stack import READ_EVERY, Sample, Source, Stack

__all__ = ["CATCH_UP", "PERIOD", "Pace", "Timing", "hurry"]

PERIOD = READ_EVERY * TICK
"""Time between two rounds [s]: 1/300."""
CATCH_UP = 0.1
"""Most that is made good [s]."""
REMEMBERED = 3000
"""So many rounds, ten seconds, count for :attr:`Timing.recent_factor` and the percentile."""


@dataclass(frozen=True)
class Timing:
    """How well real time was kept, for a panel or a summary. Times in seconds."""

    wall: float
    """Since the first turn, pauses left out."""
    simulated: float
    """What the stack turned in that time."""
    factor: float
    """``simulated / wall``; 1 before anything is known."""
    recent_factor: float
    """The same over the last ten seconds."""
    rounds: int
    """Of 300 Hz."""
    misses: int
    """Rounds done more than 1/300 s after they were due."""
    miss_share: float
    """``misses / rounds``."""
    late_p99: float
    """99 % of the last ten seconds' rounds were done within this time after they were due."""
    lag: float
    """How far the stack is behind its schedule now; 0.1 and the round that runs at most."""
    dropped: float
    """What was given up for good."""


class _Spread:
    """Percentiles of the last n numbers, kept in order: sorting 3000 of them whenever a panel
    asks takes a round that also acts past its deadline.
    """

    def __init__(self, n: int) -> None:
        self._newest: deque[float] = deque(maxlen=n)
        self._sorted: list[float] = []

    def take(self, value: float) -> None:
        """One more number; the oldest is forgotten."""
        if len(self._newest) == self._newest.maxlen:
            del self._sorted[bisect_left(self._sorted, self._newest[0])]
        self._newest.append(value)
        insort(self._sorted, value)

    def percentile(self, p: float) -> float:
        """As numpy's, between the two nearest numbers; 0 before the first."""
        if not self._sorted:
            return 0.0
        rank = p / 100 * (len(self._sorted) - 1)
        low = self._sorted[int(rank)]
        high = self._sorted[min(int(rank) + 1, len(self._sorted) - 1)]
        return low + (rank - int(rank)) * (high - low)


class Pace:
    """Turns a stack in real time."""

    def __init__(
        self,
        stack: Stack,
        *,
        catch_up: float = CATCH_UP,
        clock: Callable[[], float] = time.perf_counter,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        """Time begins at the first :meth:`turn`.

        Args:
            stack: What is turned, by nobody else.
            catch_up: Most that is made good [s].
            clock: Gives seconds that never run backwards.
            sleep: Waits some seconds.
        """
        self.stack, self._catch_up = stack, catch_up
        self._clock, self._sleep = clock, sleep
        self._running = False
        self._origin = self._started = 0.0  # when tick 0 was due; when this stretch began
        self._first = stack.tick
        self._wall, self._ticks = 0.0, 0  # of the stretches before
        self._rounds = self._misses = 0
        self._dropped = self._due = 0.0
        self._done, self._late = [0.0] * REMEMBERED, _Spread(REMEMBERED)

    def turn(self, source: Source) -> Sample | None:
        """Wait until the next tick is due, then turn it; a :class:`Sample` at 60 Hz."""
        if not self._running:
            self._start()
        if self.stack.tick % READ_EVERY == 0:
            self._wait()
        sample = self.stack.turn(source)
        if self.stack.tick % READ_EVERY == 0:
            self._round_is_done()
        return sample

    @property
    def wait(self) -> float:
        """For how long [s] :meth:`turn` would sleep now; 0 where the next tick is due.

        Who must not be kept waiting, as a viewer that also draws, asks first.
        """
        if not self._running or self.stack.tick % READ_EVERY:
            return 0.0
        return max(0.0, self._next() - self._clock())

    def pause(self) -> None:
        """Time stands still until the next :meth:`turn`, whose tick is due at once."""
        if self._running:
            self._wall += self._clock() - self._started
            self._ticks += self.stack.tick - self._first
            self._running = False

    def restart(self, stack: Stack) -> None:
        """Go on with another stack, say after a reset; the figures go on, too."""
        self.pause()
        self.stack = stack

    def timing(self) -> Timing:
        """The figures so far."""
        wall, ticks, lag = self._wall, self._ticks, 0.0
        if self._running:
            now = self._clock()
            wall, ticks = wall + now - self._started, ticks + self.stack.tick - self._first
            lag = max(0.0, now - self._next())
        known = min(self._rounds, REMEMBERED)
        return Timing(
            wall=wall,
            simulated=ticks * TICK,
            factor=ticks * TICK / wall if wall > 0.0 else 1.0,
            recent_factor=self._recent_factor(known),
            rounds=self._rounds,
            misses=self._misses,
            miss_share=self._misses / max(self._rounds, 1),
            late_p99=self._late.percentile(99),
            lag=lag,
            dropped=self._dropped,
        )

    # -- inside --------------------------------------------------------------------------

    def _start(self) -> None:
        self._running = True
        self._first = self.stack.tick
        self._origin = self._started = self._due = self._clock()

    def _next(self) -> float:
        """When the next tick is due, on the clock."""
        return self._origin + (self.stack.tick - self._first) * TICK

    def _wait(self) -> None:
        """Sleep until the next tick is due, or give up what cannot be made good."""
        self._due = self._next()
        ahead = self._due - self._clock()
        if ahead > 0.0:
            self._sleep(ahead)
        elif -ahead > self._catch_up:
            excess = -ahead - self._catch_up
            self._origin += excess
            self._dropped += excess

    def _round_is_done(self) -> None:
        now = self._clock()
        late = now - self._due
        self._done[self._rounds % REMEMBERED] = self._wall + now - self._started
        self._late.take(late)
        self._rounds += 1
        self._misses += late > PERIOD

    def _recent_factor(self, known: int) -> float:
        if known < 2:
            return 1.0
        newest = (self._rounds - 1) % REMEMBERED
        oldest = 0 if self._rounds <= REMEMBERED else self._rounds % REMEMBERED
        took = self._done[newest] - self._done[oldest]
        return (known - 1) * PERIOD / took if took > 0.0 else 1.0


def hurry() -> bool:
    """Ask for real-time scheduling, as control loops do; whether the machine granted it.

    A page drawn without a graphics card takes every core there is.
    """
    flag = getattr(os, "SCHED_RESET_ON_FORK", 0)
    try:
        os.sched_setscheduler(0, os.SCHED_RR | flag, os.sched_param(10))
    except (AttributeError, OSError):
        return False
    return True
