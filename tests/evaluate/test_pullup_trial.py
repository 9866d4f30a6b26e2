"""Pull-ups in physics: the hang holds and is symmetric, draws repeat, faults have names."""

import json
from dataclasses import replace

import numpy as np
import pytest

from mobius.control.pullup import PullUp
from mobius.evaluate.pullup import PullUpDraw, build_pullup, draw_of, is_possible, stall_shares
from mobius.evaluate.pullup_judge import PullUpJudge, PullUpTruth
from mobius.evaluate.pullup_trials import PullUps, as_text
from mobius.model.dimensions import ROBOT_MASS
from mobius.model.limit_surface import LimitSurface
from mobius.modes.pullup import PullUpScript
from mobius.types import Mode, ModeCommand, SensorFrame, StateEstimate

UP = np.array([1.0, 0.0, 0.0, 0.0])
GOOD = PullUpTruth(
    head_m=0.01, lifted_m=0.38, return_error_m=(0.001, 0.004), gave_m=(0.02, 0.04),
    slip_m=(0.0, 0.0), load_max=(0.8, 0.8), broken=False, fallen=False, saturated_share=0.0,
    torque_max=1.0, inner_N=1.0, shake_mps2=0.0, touched=(), ended="done",
)  # fmt: skip


@pytest.fixture(scope="module")
def hung():
    """A second of dead hang of the robot as drawn."""
    stack, robot, controller = build_pullup(replace(PullUpDraw(seed=0), noise=0.0))
    judge = PullUpJudge(robot, 1.05)
    for _ in range(600):
        stack.turn(lambda b: ModeCommand(Mode.PULL_UP, np.zeros(3), b.stamp))
        judge.see(controller.script.phase, stack.tick / 600)
    return robot, controller, judge


def test_it_hangs_still_on_both_grasps(hung):
    robot, _, judge = hung
    assert all(g.holds and g.slip == 0.0 for g in robot.grasps)
    assert np.abs(robot.data.qvel[:3]).max() < 0.02
    assert not judge.fallen and not judge.broken


def test_each_hand_bears_half_the_weight(hung):
    robot, controller, _ = hung
    assert controller.half_weight == pytest.approx(0.5 * 9.81 * ROBOT_MASS, rel=0.005)
    left, right = (g.force for g in robot.grasps)
    np.testing.assert_allclose(left[[0, 2]], right[[0, 2]], atol=0.5)


@pytest.mark.parametrize("hands", [(0,), (0, 1)])
def test_wrists_that_say_nothing_for_a_tenth_of_a_second_move_nothing(hands):
    """Not while they are gone, though the trunk is pushed, nor with a jump when they are back."""
    stack, robot, controller = build_pullup(replace(PullUpDraw(seed=1), noise=0.0))
    act, sent, silent, last = controller.act, [], [], []

    def deaf(command, belief, frame):
        age, wrench = np.zeros(2), np.array(frame.wrench_S)
        if 1.0 <= frame.stamp < 1.1:
            age[list(hands)], wrench[list(hands)] = frame.stamp - 1.0, last[0][list(hands)]
            silent.append(len(sent))
        last[:] = [wrench]
        out = act(command, belief, replace(frame, wrench_S=wrench, wrench_age=age))
        sent.append(out.q[:12].copy())
        return out

    controller.act = deaf
    push = np.zeros((robot.model.nbody, 6))
    push[robot.model.body("base_link").id, 2] = -15.0
    for tick in range(900):
        if tick == 630:  # half-way into the silence
            robot.pull(push)
        stack.turn(lambda b: ModeCommand(Mode.PULL_UP, np.zeros(3), b.stamp))
    steps = np.abs(np.diff(sent, axis=0)).max(axis=1)
    assert len(silent) >= 5
    assert steps[silent[0] : silent[-1]].max() < 1e-3
    back = steps[silent[-1] : silent[-1] + 30]
    assert np.abs(np.diff(back)).max() < 1e-3
    assert np.isfinite(sent).all()
    assert all(g.holds and g.slip < 1e-3 for g in robot.grasps)


def test_a_wrist_that_stays_silent_brings_the_robot_down():
    controller = PullUp(PullUpScript())
    frame = SensorFrame(
        0.0, np.zeros(22), np.zeros(22), np.zeros(22), np.zeros((2, 6)), np.zeros(3), np.zeros(3)
    )
    belief = StateEstimate(0.0, np.zeros(3), UP, np.zeros(3), np.zeros(3), np.zeros(4))
    command = ModeCommand(Mode.PULL_UP, np.zeros(3), 0.0)
    for age, reason in ((0.4, ""), (0.6, "a wrist has said nothing for too long")):
        controller.act(command, belief, replace(frame, stamp=age, wrench_age=[0.0, age]))
        assert controller.script.reason == reason


def test_nothing_but_fingers_touches_the_bar(hung):
    assert hung[2].truth().touched == ()


def test_a_seed_draws_the_same_trial_again():
    assert draw_of(3) == draw_of(3)
    assert draw_of(3) != draw_of(4)


def test_grasps_weaker_than_the_load_are_impossible():
    """131 N on two hands turned by 45 deg: 46.4 N across each groove."""
    weak, strong = LimitSurface(46.0, 20.0, 5.0), LimitSurface(47.0, 20.0, 5.0)
    assert not is_possible((strong, weak), 131.2)
    assert is_possible((strong, strong), 131.2)


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({}, ""),
        ({"broken": True}, "broke"),
        ({"fallen": True}, "fell"),
        ({"head_m": -0.01}, "from the bar's height"),
        ({"return_error_m": (0.001,)}, "not pushed"),
        ({"return_error_m": (0.001, 0.02)}, "off 3 s after a push"),
        (dict(ended="abort"), "not lowered"),
        (dict(touched=("bar - left_foot",)), "touched: bar"),
    ],
)
def test_a_fault_is_named(change, why):
    fault = replace(GOOD, **change).fault(2)
    assert (why in fault) and (bool(fault) == bool(why))


def test_the_summary_counts_impossible_grasps_apart():
    from mobius.evaluate.pullup import PullUpTrial

    trials = [
        PullUpTrial(0, True, True, "", GOOD),
        PullUpTrial(1, False, False, "a grasp broke", replace(GOOD, broken=True)),
        PullUpTrial(2, True, False, "it fell", replace(GOOD, fallen=True, return_error_m=())),
    ]
    result = PullUps(0, (15.0, 30.0), trials)
    figures = result.as_json()
    assert (figures["trials"], figures["successes"], figures["impossible_grasps"]) == (3, 1, 1)
    assert figures["return_error_m"] == pytest.approx(0.004)
    assert "1 of 3" in as_text(result) and "1 of 2" in as_text(result)


def test_a_trial_that_never_held_is_plain_json_too():
    from mobius.evaluate.pullup import PullUpTrial

    early = replace(
        GOOD, head_m=-np.inf, lifted_m=-np.inf, return_error_m=(), gave_m=(), ended="abort"
    )
    assert "before the hold" in early.fault(2)
    result = PullUps(0, (15.0,), [PullUpTrial(0, True, False, early.fault(2), early)])
    run = json.loads(json.dumps(result.as_json(), allow_nan=False))["runs"][0]
    assert run["head_m"] is None and run["lifted_m"] is None
    assert "before the hold" in as_text(result)


def test_at_rest_no_servo_needs_three_quarters_of_its_stall_torque_anywhere_on_the_way():
    assert stall_shares()[:, 1].max() < 0.75
