"""Episodes over several processes, in the order of their jobs."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import TypeVar

from mobius.headless import import_mujoco

Job = TypeVar("Job")
Result = TypeVar("Result")
Progress = Callable[[float], None]
"""Called with the share of the work that is done (0 to 1)."""


def run_jobs(
    work: Callable[[Job], Result],
    jobs: Sequence[Job],
    *,
    workers: int = 0,
    progress: Progress | None = None,
) -> list[Result]:
    """``work`` on every job.

    Args:
        work: A function of a module, so that another process finds it.
        jobs: Plain values.
        workers: Processes; 0 takes one a CPU; with 1 everything happens here.
        progress: Called after each job.
    """
    workers = min(workers or len(os.sched_getaffinity(0)), len(jobs))
    results: list[Result] = []
    for result in map(work, jobs) if workers <= 1 else _spread(work, jobs, workers):
        results.append(result)
        if progress is not None:
            progress(len(results) / len(jobs))
    return results


def _spread(work: Callable[[Job], Result], jobs: Sequence[Job], workers: int) -> Iterator[Result]:
    with ProcessPoolExecutor(workers, initializer=import_mujoco) as pool:
        futures = [pool.submit(work, job) for job in jobs]
        try:
            for future in futures:
                yield future.result()
        finally:
            pool.shutdown(wait=False, cancel_futures=True)
