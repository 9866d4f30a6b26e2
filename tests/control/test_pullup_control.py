"""The pull-up's controller, without physics: what it wishes, hears and does when a hand slips."""

import numpy as np
import pytest

from mobius.control.pullup import PullUp, leg_targets, pullup_config
from mobius.model import hang
from mobius.model.robot import joint_limits
from mobius.modes.pullup import PullUpScript
from mobius.types import Mode, ModeCommand, SensorFrame, StateEstimate

COMMAND = ModeCommand(Mode.PULL_UP, np.zeros(3), 0.0)
UP_S = hang.hand_rotation().T @ np.array([0.0, 0.0, 1.0])


def frame(t, load=(50.5, 50.5), inner=0.0):
    """What MuJoCo's wrist sensors say while each hand bears ``load`` [N] and ``inner`` [N]."""
    from mobius.control.admittance.loop import mobius_tool

    tool = mobius_tool()
    wrench = np.zeros((2, 6))
    along = hang.hand_rotation().T @ np.array([0.0, 1.0, 0.0])
    for k in (0, 1):
        f = load[k] * UP_S + inner * along  # by the bar on the hand
        weight = -tool.cog_force * UP_S
        m = np.cross([0.0, 0.0, -0.086], f) + np.cross(tool.cog_pos, weight)
        wrench[k] = -np.concatenate([f + weight, m])
    wrench[1] *= hang.MIRROR_WRENCH
    q = np.zeros(22)
    q[:6] = hang.hang_arms(0.372, -0.318, np.radians(36.0))
    q[6:12] = q[:6] * hang.MIRROR
    zero = np.zeros(22)
    return SensorFrame(t, q, zero, zero, wrench, np.zeros(3), np.array([0, 0, 9.81]))


def belief():
    from mobius.geometry import mat_to_quat

    q = mat_to_quat(hang.trunk_rotation(np.radians(36.0)))
    return StateEstimate(0.0, np.zeros(3), q, np.zeros(3), np.zeros(3), np.zeros(4))


def acted(controller, seconds, **readings):
    for k in range(round(300 * seconds)):
        command = controller.act(COMMAND, belief(), frame(k / 300, **readings))
    return command


def test_it_weighs_itself_in_the_dead_hang():
    controller = PullUp(PullUpScript())
    acted(controller, 1.1, load=(53.0, 51.0))
    assert controller.half_weight == pytest.approx(52.0, abs=0.05)


def test_both_hands_hear_the_same_of_a_symmetric_load():
    controller = PullUp(PullUpScript())
    acted(controller, 0.3, inner=4.0)
    np.testing.assert_allclose(controller.heard[0], controller.heard[1], atol=1e-9)


def test_targets_mirror_and_stay_within_joint_limits():
    q = acted(PullUp(PullUpScript()), 0.5).q
    np.testing.assert_allclose(q[6:12], q[:6] * hang.MIRROR, atol=1e-9)
    low, high = joint_limits()
    assert (q[12:20] >= low[12:20]).all() and (q[12:20] <= high[12:20]).all()


def test_too_much_inner_force_lets_the_hands_give_way_to_it():
    """The wish is 5.5 N along the bar; 10 N more drives the mean deviation along it."""
    controller = PullUp(PullUpScript())
    acted(controller, 1.0, inner=15.5)
    assert controller.law.state[0, 0, 0] > 0.005
    assert np.abs(controller.law.state[1, :, 0]).max() == 0.0


def test_a_hand_without_load_ends_it():
    script = PullUpScript()
    controller = PullUp(script)
    acted(controller, 1.1)
    for k in range(330, 330 + 60):
        controller.act(COMMAND, belief(), frame(k / 300, load=(2.0, 99.0)))
    assert script.phase == "abort" and "lost the bar" in script.reason
    for k in range(390, 390 + 600):
        command = controller.act(COMMAND, belief(), frame(k / 300, load=(2.0, 99.0)))
    assert controller.state == "failed" and (command.q[20:] > 0.8).all()


def test_legs_hang_or_are_drawn_up_within_their_limits():
    low, high = (limit[12:20] for limit in joint_limits())
    for up in (0.0, 0.5, 1.0):
        q = leg_targets(up)
        assert (q >= low).all() and (q <= high).all()


def test_the_usual_gains_are_accepted():
    config = pullup_config()
    assert not config.selected_axes[5] and config.stiffness[2] == 500.0
