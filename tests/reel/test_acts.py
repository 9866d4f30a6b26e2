"""A script goes on by what the machine does, and says why it cannot."""

from types import SimpleNamespace

import numpy as np
import pytest

from mobius.errors import InvalidInput
from mobius.geometry import rpy_to_quat
from mobius.reel.acts import Act, Script
from mobius.types import Mode, ModeCommand

WALK = Act(Mode.CRAWL, 0.5, (0.3, 0.0, 0.0))


class Robot:
    """Facing along y; remembers how it was pushed."""

    def __init__(self):
        self.pushed = []

    def truth(self):
        return SimpleNamespace(q_OB=rpy_to_quat(0.0, 0.0, np.pi / 2))

    def push(self, dv, duration, as_force):
        self.pushed.append(np.array(dv))


def played(script, modes, robot=None):
    """Show the script one mode a tenth of a second; returns what it asked for in each."""
    asked = []
    for k, mode in enumerate(modes):
        asked.append(script(SimpleNamespace(stamp=k / 10)))
        command = ModeCommand(mode, np.zeros(3), k / 10)
        script.see(SimpleNamespace(tick=60 * k, command=command), robot or Robot())
        if script.over or script.failed:
            break
    return asked


def test_a_walk_is_over_after_its_time_in_the_mode():
    script = Script([WALK], Mode.CRAWL)
    asked = played(script, 20 * [Mode.CRAWL])
    assert script.over and len(asked) == 6  # 0.0 to 0.5 s
    np.testing.assert_array_equal(asked[-1].twist_H, [0.3, 0, 0])


def test_time_on_the_way_to_a_mode_does_not_count_and_nothing_is_walked_there():
    script = Script([Act(Mode.BIPED, 0.3, (0.2, 0.0, 0.0))], Mode.CRAWL)
    asked = played(script, 10 * [Mode.STAND_UP] + 10 * [Mode.BIPED])
    assert script.over and len(asked) == 14
    assert asked[5].mode is Mode.BIPED and not asked[5].twist_H.any()


def test_a_motion_is_asked_for_until_entered_and_over_when_the_robot_crawls_again():
    script = Script([Act(Mode.ROLL)], Mode.CRAWL)
    asked = played(script, 3 * [Mode.CRAWL] + 4 * [Mode.ROLL] + 5 * [Mode.CRAWL])
    assert [a.mode for a in asked] == 4 * [Mode.ROLL] + 4 * [Mode.CRAWL]
    assert script.over


def test_a_shove_is_along_the_heading_and_once():
    robot = Robot()
    script = Script([Act(Mode.CRAWL, 0.2, shove=(1.0, 0.0))], Mode.CRAWL)
    played(script, 3 * [Mode.CRAWL] + 3 * [Mode.RECOVER] + 5 * [Mode.CRAWL], robot)
    (dv,) = robot.pushed
    np.testing.assert_allclose(dv, [0.0, 1.0], atol=1e-12)
    assert script.over


def test_a_shove_that_knocks_nothing_over_fails_in_the_end():
    script = Script([Act(Mode.CRAWL, 0.2, shove=(0.1, 0.0), limit_s=1.0)], Mode.CRAWL)
    played(script, 20 * [Mode.CRAWL])
    assert not script.over and "not over after 1 s" in script.failed


def test_an_emergency_stop_ends_the_script():
    script = Script([WALK], Mode.CRAWL)
    played(script, [Mode.CRAWL, Mode.STOP])
    assert script.failed == "emergency stop"


def test_an_empty_script_and_a_shove_while_rolling_are_refused():
    with pytest.raises(InvalidInput, match="at least one act"):
        Script([], Mode.CRAWL)
    with pytest.raises(InvalidInput, match="crawl or biped"):
        Act(Mode.ROLL, shove=(1.0, 0.0))
