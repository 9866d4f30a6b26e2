"""What grows harder, when, and that it is all in the state."""

import numpy as np

from mobius.train.curriculum import Curriculum, CurriculumConfig

CFG = CurriculumConfig(
    review=2, command_start=0.4, command_error=0.3, kick_start=0.2, kick_falls=2.0, step=0.1
)


def test_commands_grow_while_tracking_is_good_up_to_one():
    c = Curriculum(CFG, 3, levels=0, columns=0)
    c.watch(0.9, 0.0)
    c.watch(0.9, 0.0)
    assert c.command == 0.4
    for _ in range(40):
        c.watch(0.1, 0.0)
    assert c.command == 1.0


def test_kicks_grow_without_falls_and_shrink_with_many_but_not_to_nothing():
    c = Curriculum(CFG, 3, levels=0, columns=0)
    c.watch(1.0, 0.0)
    assert c.kick == 0.2  # no review yet
    c.watch(1.0, 0.0)
    assert np.isclose(c.kick, 0.3)
    for _ in range(2):
        c.watch(1.0, 3.0)  # between the two marks nothing changes
    assert np.isclose(c.kick, 0.3)
    for _ in range(20):
        c.watch(1.0, 9.0)
    assert np.isclose(c.kick, 0.2)


def test_levels_follow_each_robot_s_own_episodes():
    rng = np.random.default_rng(0)
    c = Curriculum(CFG, 4, levels=2, columns=3)
    ids = np.arange(3)
    c.level[:] = [0, 1, 2, 1]
    c.ended(ids, np.array([True, False, False]), rng)
    assert c.level[0] == 0 and c.level[1] == 2 and 0 <= c.level[2] <= 2
    assert c.level[3] == 1  # did not end
    assert ((c.column >= 0) & (c.column < 3)).all()


def test_without_levels_nothing_is_drawn():
    rng = np.random.default_rng(0)
    Curriculum(CFG, 2, levels=0, columns=0).ended(np.arange(2), np.array([True, False]), rng)
    assert rng.random() == np.random.default_rng(0).random()


def test_state_round_trip():
    rng = np.random.default_rng(1)
    a = Curriculum(CFG, 4, levels=3, columns=2)
    for _ in range(5):
        a.watch(0.1, 1.0)
    a.ended(np.arange(4), np.zeros(4, dtype=bool), rng)
    b = Curriculum(CFG, 4, levels=3, columns=2)
    b.load_state(a.state())
    a.watch(0.1, 0.0)
    b.watch(0.1, 0.0)
    assert str(a.state()) == str(b.state())
