"""Rows from a Ray cluster, or from Ray on this machine, in the order they are done."""

from __future__ import annotations

import os
import socket
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from mobius.errors import InvalidInput, MissingDependency, MobiusError
from mobius.sweep.settings import Row, Setting
from mobius.sweep.workers import Work

__all__ = ["connected"]

Jobs = Sequence[tuple[int, Setting]]
RowsOf = Callable[[Work, Jobs], Iterator[tuple[int, Row]]]
"""Number and row of every job as it is done; the nodes need mobius installed."""

ANSWER_WITHIN_S = 5.0
"""A cluster's port that has not answered by then is not there [s]; Ray itself would wait on."""
IN_FLIGHT = 256
"""Settings handed to Ray at a time."""


@contextmanager
def connected(address: str, *, workers: int = 0) -> Iterator[RowsOf]:
    """Ray while the block lasts, as a function of work and jobs that gives their rows.

    Args:
        address: ``local`` starts Ray here; else ``host:port``, ``ray://host:port`` or ``auto``.
        workers: CPUs of a local Ray, >= 0; 0 takes all. A cluster has its own.

    Raises:
        MissingDependency: Ray is not installed.
        InvalidInput: Nobody answers there.
    """
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    os.environ.setdefault("RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO", "0")
    try:
        import ray
    except ImportError:
        raise MissingDependency("ray", "sweep", "a sweep on Ray") from None
    _connect(ray, address, workers)
    try:
        yield lambda work, jobs: _rows(ray, work, jobs)
    finally:
        ray.shutdown()


def _connect(ray: Any, address: str, workers: int) -> None:
    local: dict[str, Any] = {"include_dashboard": False}
    if workers:
        local["num_cpus"] = workers
    try:
        _knock(address)
        ray.init(
            address=address,
            log_to_driver=False,
            logging_level="error",
            **(local if address == "local" else {}),
        )
    except (OSError, RuntimeError, ValueError) as error:
        what = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise InvalidInput(
            f"--ray {address}: no Ray there ({what}); start one with 'ray start --head', or type"
            " --ray local"
        ) from None


def _knock(address: str) -> None:
    """Raise where an address with a port has nobody behind it."""
    if address in ("local", "auto"):
        return
    host, colon, port = address.removeprefix("ray://").rpartition(":")
    if not colon or not port.isdigit():
        raise ValueError("expected local, auto, host:port or ray://host:port")
    socket.create_connection((host.strip("[]"), int(port)), ANSWER_WITHIN_S).close()


def _rows(ray: Any, work: Work, jobs: Jobs) -> Iterator[tuple[int, Row]]:
    task = ray.remote(_row)
    shared = ray.put(work)
    left, waiting = iter(jobs), {}
    try:
        while True:
            for number, setting in left:
                waiting[task.remote(shared, setting)] = number
                if len(waiting) >= IN_FLIGHT:
                    break
            if not waiting:
                return
            done, _ = ray.wait(list(waiting), num_returns=1)
            for reference in done:
                yield waiting.pop(reference), ray.get(reference)
    except ray.exceptions.RayTaskError as error:
        raise error.cause from None
    except ray.exceptions.RayError as error:
        raise MobiusError(
            f"Ray stopped ({type(error).__name__}); finished rows are kept: type the same with"
            " --resume"
        ) from None


def _row(work: Work, setting: Setting) -> Row:
    return work(setting)
