"""Real time: when ticks are turned, which deadlines are missed, and what is given up."""

import numpy as np
import pytest

from mobius.pace import CATCH_UP, PERIOD, REMEMBERED, Pace, _Spread
from mobius.robot import TICK


class Wall:
    """A clock that goes on while somebody sleeps or works, and never else."""

    def __init__(self) -> None:
        self.now, self.slept = 100.0, 0.0

    def __call__(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        assert seconds > 0.0
        self.now += seconds
        self.slept += seconds


class Work:
    """A stack whose rounds take given times; the odd tick of a round takes none."""

    def __init__(self, wall: Wall, *, default: float = 1e-3, **rounds: float) -> None:
        self.wall, self.default, self.tick = wall, default, 0
        self.rounds = {int(k.removeprefix("r")): v for k, v in rounds.items()}
        self.began: list[float] = []

    def turn(self, source):
        if self.tick % 2 == 0:
            self.began.append(self.wall.now - 100.0)
            self.wall.now += self.rounds.get(self.tick // 2, self.default)
        self.tick += 1


def paced(**options):
    wall = Wall()
    work = Work(wall, **options)
    return Pace(work, clock=wall, sleep=wall.sleep), work, wall


def rounds(pace, count: int) -> None:
    for _ in range(2 * count):
        pace.turn(None)


def test_the_worked_example_of_the_docstring():
    pace, work, _ = paced(r1=7.5e-3)
    rounds(pace, 5)
    assert work.began == pytest.approx(
        [0.0, 3.3333e-3, 10.8333e-3, 11.8333e-3, 13.3333e-3], abs=1e-7
    )
    timing = pace.timing()
    assert (timing.rounds, timing.misses, timing.dropped) == (5, 2, 0.0)
    assert timing.miss_share == 0.4


def test_the_wall_is_not_looked_at_between_the_two_ticks_of_a_round():
    pace, _, wall = paced()
    pace.turn(None)
    before = wall.slept
    assert pace.wait == 0.0
    pace.turn(None)
    assert wall.slept == before
    assert pace.wait == pytest.approx(PERIOD - 1e-3)


def test_sleeps_that_last_too_long_do_not_add_up():
    """Each sleep is 0.5 ms too long; after a second the stack is behind by that, once."""
    pace, work, wall = paced()
    pace._sleep = lambda seconds: wall.sleep(seconds + 5e-4)
    rounds(pace, 300)
    assert work.began[-1] == pytest.approx(299 * PERIOD + 5e-4)
    assert pace.timing().misses == 0


def test_a_machine_that_is_too_slow_shows_it_and_never_races():
    """Rounds of 5 ms: 2/3 of real time, a steady lag of 0.1 s, the rest dropped."""
    pace, work, wall = paced(default=1.5 * PERIOD)
    rounds(pace, 600)
    timing = pace.timing()
    assert timing.wall == pytest.approx(600 * 1.5 * PERIOD)
    assert timing.factor == pytest.approx(2 / 3)
    assert timing.recent_factor == pytest.approx(2 / 3)
    assert timing.dropped == pytest.approx(timing.wall - timing.simulated - timing.lag)
    assert CATCH_UP <= timing.lag < CATCH_UP + 1.5 * PERIOD
    work.default = 0.0
    rounds(pace, 120)
    # 0.1 s of lag are 30 rounds; after these it waits for every round again
    assert wall.slept == pytest.approx(90 * PERIOD, abs=2 * PERIOD)


def test_a_long_stop_is_not_made_up_for():
    pace, _, wall = paced(r3=60.0)
    rounds(pace, 4)
    began = wall.now
    rounds(pace, 300)
    assert wall.now - began > 300 * PERIOD - CATCH_UP - 2 * PERIOD
    assert pace.timing().dropped == pytest.approx(60.0 - CATCH_UP, abs=2 * PERIOD)


def test_a_pause_counts_for_nothing():
    pace, work, wall = paced()
    rounds(pace, 30)
    pace.pause()
    wall.now += 5.0
    rounds(pace, 30)
    timing = pace.timing()
    assert (timing.misses, timing.dropped) == (0, 0.0)
    assert timing.factor == pytest.approx(1.0, abs=0.05)
    assert work.began[30] == pytest.approx(work.began[29] + 1e-3 + 5.0)


def test_a_restart_goes_on_with_another_stack_and_its_own_count():
    pace, _, wall = paced()
    rounds(pace, 10)
    other = Work(wall)
    other.tick = 1000
    pace.restart(other)
    rounds(pace, 10)
    timing = pace.timing()
    assert other.tick == 1020
    assert timing.simulated == pytest.approx(40 * TICK)
    assert timing.rounds == 20


def test_the_percentile_forgets_what_is_ten_seconds_old():
    pace, _, _ = paced(**{f"r{k}": 9e-3 for k in range(100)})
    rounds(pace, 100)
    assert pace.timing().late_p99 > 9e-3
    rounds(pace, REMEMBERED + 200)
    assert pace.timing().late_p99 == pytest.approx(1e-3)
    assert pace.timing().recent_factor == pytest.approx(1.0)


def test_before_the_first_turn_nothing_is_known():
    timing = paced()[0].timing()
    assert (timing.factor, timing.recent_factor, timing.rounds, timing.lag) == (1.0, 1.0, 0, 0.0)


def test_samples_come_through():
    pace, work, _ = paced()
    work.turn = lambda source: source  # what the stack gives is given on
    assert pace.turn("sample") == "sample"


def test_the_percentile_is_numpys_over_the_newest_numbers():
    numbers = np.random.default_rng(3).exponential(1e-3, 500).round(4)  # with ties
    spread = _Spread(200)
    assert spread.percentile(99) == 0.0
    for k, number in enumerate(numbers):
        spread.take(float(number))
        seen = numbers[max(0, k - 199) : k + 1]
        assert spread.percentile(99) == pytest.approx(np.percentile(seen, 99), abs=1e-15)
