"""Jobs keep their order, in one process and in several."""

from functools import partial

import pytest

from mobius.errors import InvalidInput
from mobius.evaluate.commands import schedule
from mobius.evaluate.jobs import run_jobs


def test_results_come_in_the_order_of_the_jobs_and_progress_ends_at_one():
    shares = []
    assert run_jobs(abs, [-3, 2, -1], workers=1, progress=shares.append) == [3, 2, 1]
    assert shares == pytest.approx([1 / 3, 2 / 3, 1.0])


def test_other_processes_give_the_same():
    jobs, work = ["crawl", "biped"], partial(schedule, seed=0)
    assert run_jobs(work, jobs, workers=2) == run_jobs(work, jobs, workers=1)


def test_a_mistake_in_a_job_comes_out():
    with pytest.raises(InvalidInput, match="-1"):
        run_jobs(_refuse, [1, -1], workers=1)


def _refuse(value):
    if value < 0:
        raise InvalidInput(f"got {value}")
    return value
