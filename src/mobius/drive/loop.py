"""The loop in a process of its own, and the viewer's end of the line to it.

The line is a pair of connected sockets. The loop never waits for the viewer: with
:data:`UNSEEN` snapshots under way that nobody has seen it sends none, and it stops the robot when
beats fail to come. When the line breaks, the loop ends.
"""

from __future__ import annotations

import multiprocessing
import signal
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing.connection import Connection
from typing import Any

from mobius.drive.guide import Planner
from mobius.drive.session import Looked, Session
from mobius.errors import MobiusError
from mobius.headless import import_mujoco
from mobius.pace import Pace, hurry
from mobius.stack import Sample
from mobius.view.live.nouns import Beat, Keeping, Request, Scene, Snapshot, Way

UNSEEN = 8
"""Snapshots that may be under way."""
LOOK_EVERY = 6
"""Snapshots between two looks at how time is kept."""
FROZEN_S = 0.02
"""Between two looks at the requests while time stands still [s]."""


class Line:
    """The viewer's end: requests go in, scenes, plans and snapshots come out."""

    def __init__(self, source: str, *, seed: int = 0, randomised: bool = True) -> None:
        """Start the loop's process and wait until the robot stands.

        Raises:
            MobiusError: The map cannot be used.
        """
        context = multiprocessing.get_context("spawn")
        self._line, theirs = context.Pipe()
        self._process = context.Process(
            target=run_loop, args=(theirs, source, seed, randomised), name="mobius-loop"
        )
        with _ctrl_c_left_out():
            self._process.start()
        theirs.close()
        try:
            first = self._receive()
            if isinstance(first, MobiusError):
                raise first
        except BaseException:  # Ctrl+C, too: the process must not be waited for in vain
            self.close()
            raise
        self.first: Scene = first

    @property
    def alive(self) -> bool:
        """Whether the loop runs."""
        return self._process.is_alive()

    def check(self) -> None:
        """Say so where the loop has ended though nobody has closed the line.

        Raises:
            RuntimeError: It has; its own words stand above.
        """
        if not self.alive:
            raise RuntimeError(f"the loop ended, exit code {self._process.exitcode}")

    def send(self, request: Request) -> None:
        """Ask something of the loop; nothing happens where it has ended."""
        try:
            self._line.send(request)
        except (BrokenPipeError, ConnectionResetError):
            return

    def come(self, timeout: float = 0.0) -> Iterator[Scene | Way | Snapshot]:
        """What has come since last asked, waiting at most ``timeout`` [s] for the first."""
        try:
            while self._line.poll(timeout):
                timeout = 0.0
                yield self._line.recv()
        except (EOFError, ConnectionResetError, BrokenPipeError):
            return

    def close(self) -> None:
        """End the loop and wait for it."""
        self._line.close()
        self._process.join(timeout=5.0)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()

    def _receive(self) -> Any:
        try:
            return self._line.recv()
        except EOFError:
            self._process.join()
            raise RuntimeError(f"the loop ended, exit code {self._process.exitcode}") from None


@contextmanager
def _ctrl_c_left_out() -> Iterator[None]:
    """A process that is started inside is ended by this one alone, never by Ctrl+C."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def run_loop(line: Connection, source: str, seed: int, randomised: bool) -> None:
    """The process: a session in real time until the line breaks."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the viewer ends it
    import_mujoco()
    planner = Planner()
    hurry()
    try:
        try:
            session = Session(source, planner, seed=seed, randomised=randomised)
        except MobiusError as error:
            line.send(error)
            return
        LoopEnd(line, session).run()
    except (EOFError, BrokenPipeError, ConnectionResetError):
        return
    finally:
        planner.close()


class LoopEnd:
    """The loop's end of the line."""

    def __init__(
        self, line: Any, session: Session, *, clock: Callable[[], float] = time.perf_counter
    ) -> None:
        self._line, self._session, self._clock = line, session, clock
        self._pace = Pace(session.stack)
        self._under_way: deque[int] = deque()
        self._scene = self._way = 0
        self._seen: tuple[Sample, Looked] | None = None
        self._untold = False  # what was seen has not been sent yet
        self._looks, self._kept = 0, Keeping()
        self._tell_changes()

    def run(self) -> None:
        """Turn until the line breaks; then the log that was begun is written."""
        try:
            while True:
                self.turn()
        finally:
            self._session.log.end()

    def turn(self) -> None:
        """One tick; at 60 Hz requests are taken and a snapshot is sent, after the round that
        acted is done: the robot first, then the viewer.
        """
        session = self._session
        if session.frozen and self._seen is not None and not self._untold:
            self._pace.pause()
            time.sleep(FROZEN_S)
            if self._hear_all():
                self._tell(session.show(*self._seen, self._keeping()))
            return
        sample = self._pace.turn(session.source(self._clock))
        if sample is not None:
            self._seen, self._untold = (sample, session.look()), True
        elif self._untold:
            self._untold = False
            if self._hear_all() and self._seen is not None:
                self._tell(session.see(*self._seen, self._keeping()))

    def _hear_all(self) -> bool:
        """Take the requests; False where they began anew: there is no sample of that yet."""
        self._hear()
        anew = self._session.stack is not self._pace.stack
        if anew:
            self._pace.restart(self._session.stack)
            self._seen, self._untold = None, False
        self._tell_changes()
        return not anew

    def _tell(self, snapshot: Snapshot) -> None:
        self._tell_changes()
        if len(self._under_way) < UNSEEN:
            self._line.send(snapshot)
            self._under_way.append(snapshot.number)

    def _hear(self) -> None:
        now = self._clock()
        while self._line.poll():
            request = self._line.recv()
            if isinstance(request, Beat):
                while self._under_way and self._under_way[0] <= request.seen:
                    self._under_way.popleft()
            self._session.take(request, now)
        self._session.watch(now)

    def _tell_changes(self) -> None:
        """Send a scene or plan that is new."""
        scene, way = self._session.scene_number, self._session.way
        if scene != self._scene:
            self._scene = scene
            self._line.send(self._session.scene)
        if way.number != self._way:
            self._way = way.number
            self._line.send(way)

    def _keeping(self) -> Keeping:
        """How time is kept, looked at ten times a second: a percentile is dear."""
        self._looks += 1
        if self._looks % LOOK_EVERY != 1:
            return self._kept
        self._kept = self._look()
        return self._kept

    def _look(self) -> Keeping:
        timing = self._pace.timing()
        return Keeping(
            factor=timing.recent_factor,
            misses=timing.miss_share,
            late_p99_ms=1e3 * timing.late_p99,
            dropped_s=timing.dropped,
        )
