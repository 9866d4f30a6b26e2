"""The pull-up's script: phases, the way, what it asks of the servos, and going down."""

import numpy as np
import pytest

from mobius.errors import InvalidInput
from mobius.model import hang
from mobius.model.robot import joint_limits
from mobius.modes.pullup import WAY, Phase, PullUpScript, PullUpTimes

DT = 1 / 60


def run(script, seconds, now=0.0):
    goals = []
    for k in range(round(seconds / DT)):
        goals.append(script.step(now + k * DT))
    return goals


def test_phases_follow_each_other_and_end_where_they_began():
    script = PullUpScript()
    goals = run(script, 18.0)
    seen = list(dict.fromkeys(g.phase for g in goals))
    assert seen == [
        Phase.HANG,
        Phase.TUCK,
        Phase.PULL,
        Phase.HOLD,
        Phase.LOWER,
        Phase.UNTUCK,
        Phase.DONE,
    ]
    assert goals[-1].share == 0.0 and goals[-1].legs == 0.0 and goals[-1].grip


def test_nothing_jumps_on_the_way():
    goals = run(PullUpScript(), 18.0)
    for name, most in (("x_B", 0.005), ("z_B", 0.005), ("lean", 0.01), ("along", 0.35)):
        values = np.array([getattr(g, name) for g in goals])
        assert np.abs(np.diff(values)).max() < most


def test_a_waiting_hold_ends_when_asked():
    script = PullUpScript(PullUpTimes(hang_s=0.1, tuck_s=0.1, pull_s=0.1), wait=True)
    assert run(script, 30.0)[-1].phase is Phase.HOLD
    script.ask_down()
    assert script.step(30.1).phase is Phase.LOWER


def test_an_abort_goes_down_from_where_it_is_and_lets_go():
    script = PullUpScript()
    run(script, 5.0)
    share = script.goal().share
    assert 0.1 < share < 0.9
    script.abort("a hand has lost the bar")
    goals = run(script, 2.0, now=5.0)
    assert goals[0].share == pytest.approx(share) and goals[0].grip
    assert goals[-1].share == 0.0 and not goals[-1].grip
    assert script.reason == "a hand has lost the bar"


@pytest.mark.parametrize("share", np.linspace(0, 1, 23))
def test_every_pose_of_the_way_is_within_reach_and_joint_limits(share):
    """q21 may touch its stop (3.10 rad) between two of the poses, by no more than 0.01 rad."""
    goal = PullUpScript().at(float(share))
    q = hang.hang_arms(goal.x_B, goal.z_B, goal.lean)
    low, high = (limit[:6] for limit in joint_limits())
    assert (q > low - 0.01).all() and (q < high + 0.01).all()


def test_the_dead_hang_has_straight_arms():
    """Top servo to wrist is 98 % of the 331 mm that the five-bar can reach out."""
    q = hang.hang_arms(WAY[0, 0], WAY[0, 1], np.radians(WAY[0, 2]))
    from mobius.model.fivebar import ARM_FIVEBAR

    assert np.hypot(*ARM_FIVEBAR.fk(q[1], q[2])) > 0.98 * 0.331


def test_times_must_be_positive():
    with pytest.raises(InvalidInput, match="pull_s"):
        PullUpTimes(pull_s=0.0)
