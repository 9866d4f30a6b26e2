"""Other ground: the robot starts on it, falls are judged over it, its softness reaches physics."""

import numpy as np
import pytest

from mobius.control.bodies import body_of
from mobius.errors import UnknownName
from mobius.evaluate import terrain
from mobius.evaluate.commands import Segment
from mobius.evaluate.episode import Setup
from mobius.evaluate.terrain import (
    COMMANDS,
    KINDS,
    MAPS,
    SIZE,
    TerrainRun,
    commands,
    cross,
    per_kind,
)

STAND = [Segment("stand", (0.0, 0.0, 0.0))]


@pytest.mark.parametrize("kind", KINDS)
def test_the_crawl_stands_on_every_kind_of_ground(kind):
    episode = cross(kind, Setup("crawl", 1, "zero"), STAND, hold_s=0.5)
    assert not episode.fallen
    height = episode.readings.height
    assert episode.readings.contact[-1].any()
    # on bumps the trunk may hang over a dent, on the pyramid it stands a metre above the floor
    assert abs(height[-1] - episode.readings.stance) < 0.06
    if kind == "slope":
        assert episode.readings.p[-1, 2] > 1.2


@pytest.mark.parametrize("kind", MAPS)
def test_no_robot_starts_inside_the_ground(kind):
    episode = cross(kind, Setup("biped", 2, "zero"), STAND, hold_s=0.1)
    # a start inside would throw the robot: 0.1 s later it would not be near its stance
    assert np.abs(episode.readings.height - episode.readings.stance).max() < 0.03
    assert episode.readings.max_dq_rpm() < 50.0


def test_ground_follows_from_its_seed():
    for kind in ("heightmap", "steps"):
        a, b, c = (MAPS[kind]("crawl", seed).height for seed in (1, 1, 2))
        assert (a == b).all() and (a != c).any()
    assert MAPS["heightmap"]("biped", 0).height.max() == pytest.approx(0.03)
    assert MAPS["steps"]("crawl", 0).height.max() <= 0.025


@pytest.mark.parametrize("body", ["crawl", "biped"])
def test_twenty_seconds_end_inside_the_map(body):
    high = 0.6 * np.array(body_of(body).command_high)
    assert 20.0 * np.hypot(high[0], high[1]) < 0.5 * SIZE - 0.5


def test_every_command_moves():
    for seed in range(5):
        drawn = commands("crawl", seed)
        assert len(drawn) == COMMANDS and drawn == commands("crawl", seed)
        assert all(np.linalg.norm(s.twist) > 0.1 for s in drawn)


def test_a_kind_counts_its_survivors():
    runs = [TerrainRun("soft", s, s == 1, 20.0, 2.0 + s, [0.1 * s, 0.0, 0.0]) for s in range(3)]
    row = per_kind(runs)
    assert (row["survived"], row["episodes"], row["distance_m"]) == (2, 3, 3.0)
    assert row["mae"]["vx"] == pytest.approx(0.1)


def test_an_unknown_kind_is_refused():
    with pytest.raises(UnknownName, match="Did you mean 'steps'"):
        terrain("crawl", seeds=1, kinds=("step",))
