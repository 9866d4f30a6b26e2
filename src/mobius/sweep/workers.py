"""Rows from several processes of this machine, in the order they are done."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool

from mobius.errors import MobiusError
from mobius.sweep.settings import Row, Setting

__all__ = ["Work", "rows_here"]

Work = Callable[[Setting], Row]
LOOK_EVERY_S = 0.5
"""How often a worker looks whether the process that started it is still there [s]."""

_work: Work | None = None


def rows_here(
    work: Work, jobs: Sequence[tuple[int, Setting]], *, workers: int = 0
) -> Iterator[tuple[int, Row]]:
    """Number and row of every job as it is done.

    Args:
        work: A function (or object) that another process can be given.
        jobs: Number and setting.
        workers: Processes, >= 0; 0 takes one a CPU; with 1 everything happens here.
    """
    workers = min(workers or len(os.sched_getaffinity(0)), len(jobs))
    if workers <= 1:
        for number, setting in jobs:
            yield number, work(setting)
        return
    with ProcessPoolExecutor(workers, initializer=_begin, initargs=(work, os.getpid())) as pool:
        numbers = {pool.submit(_row, setting): number for number, setting in jobs}
        try:
            for future in as_completed(numbers):
                yield numbers[future], future.result()
        except BrokenProcessPool:
            raise MobiusError(
                "a worker was killed (out of memory?); finished rows are kept: type the same with"
                " --resume and fewer --workers"
            ) from None
        finally:
            pool.shutdown(wait=False, cancel_futures=True)


def _begin(work: Work, parent: int) -> None:
    """Keep the work, and end when the parent does: a kill -9 leaves no process behind."""
    global _work
    _work = work

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(LOOK_EVERY_S)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def _row(setting: Setting) -> Row:
    if _work is None:
        raise RuntimeError("a worker was asked for a row before it was given its work")
    return _work(setting)
